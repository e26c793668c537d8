"""What track views draw: the live trail, or the result of a run with its impacts and the fitted fall."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from radargui.gui.track.space import MM
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult

_MOST_POINTS = 6000


@dataclass(frozen=True, slots=True)
class ShownTrack:
    """A track thinned for the screen.

    Attributes
    ----------
    time_s
        Shape (n,); of a result from its trigger on, of a live trail before now.
    position_mm
        Shape (3, n); NaN breaks the line.
    impact_time_s, impact_mm
        Shape (n_impacts,) and (3, n_impacts).
    fit_time_s, fit_mm
        Parabola of the first fall in z, shape (n_fit,).
    """

    time_s: FloatArray
    position_mm: FloatArray
    impact_time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    impact_mm: FloatArray = field(default_factory=lambda: np.empty((3, 0)))
    fit_time_s: FloatArray = field(default_factory=lambda: np.empty(0))
    fit_mm: FloatArray = field(default_factory=lambda: np.empty(0))


def result_track(result: RunResult) -> ShownTrack | None:
    """Return the track of a result for the screen; None where it has none."""
    track = result.track
    if track is None:
        return None
    zero = start_time_s(result)
    known = np.flatnonzero(track.valid & np.isfinite(track.position_m).all(axis=0))
    if known.size == 0:
        return None
    step = max(1, -(-(known[-1] - known[0]) // _MOST_POINTS))
    chosen = np.arange(known[0], known[-1] + 1, step)
    position = np.where(track.valid[chosen], track.position_m[:, chosen], np.nan) * MM
    impacts = np.array([bounce.time_s for bounce in result.bounces.impacts])
    at = np.clip(np.searchsorted(track.time_s, impacts), 0, track.time_s.size - 1)
    fall = result.bounces.free_fall
    fit_time, fit = np.empty(0), np.empty(0)
    if fall is not None:
        since = np.linspace(0.0, fall.last_time_s - fall.first_time_s, 120)
        fit_time = fall.first_time_s + since - zero
        fit = np.polynomial.polynomial.polyval(since, fall.parabola) * MM
    return ShownTrack(
        time_s=track.time_s[chosen] - zero,
        position_mm=position,
        impact_time_s=impacts - zero,
        impact_mm=track.position_m[:, at] * MM,
        fit_time_s=fit_time,
        fit_mm=fit,
    )


def start_time_s(result: RunResult) -> float:
    """Return the instant that counts as t = 0: the trigger, else the first motion, else the first sample."""
    recording = result.recording
    time_s = recording.time_s()
    if time_s.size == 0:
        return 0.0
    if recording.trigger_index is not None:
        return float(recording.trigger_index / recording.digitisation.sample_rate_hz)
    if result.segment is not None:
        return float(time_s[min(result.segment.first, time_s.size - 1)])
    return float(time_s[0])
