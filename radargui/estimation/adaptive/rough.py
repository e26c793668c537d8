"""Fit one circle to pooled samples of each receiver, well enough to count fringes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.correction.phase import unwrapped
from radargui.estimation.forward.bins import pool
from radargui.estimation.signals import ScaledSignals
from radargui.model.arrays import BoolArray, FloatArray
from radargui.signals.ellipse import Ellipse, circle_through
from radargui.signals.rows import pairs_of


@dataclass(frozen=True, slots=True)
class RoughSettings:
    """How samples are pooled and which circles are trusted. Chosen by hand.

    Attributes
    ----------
    pool_s
        Length of the means: a fall of 3 m/s turns at 180 Hz at 10 GHz, a fiftieth of a turn in this time.
    smooth_s
        Time over which the arc's length is smoothed, so that noise does not count as motion along the circle.
    at_rest
        Least number of pooled samples at rest that show which arc noise makes.
    arc_quantile
        No sample weighs more than this quantile of the arcs, so that a jump does not count as motion.
    short_chord
        A receiver whose samples span less than so many radii of the others' circles saw less than a fifth of a turn (2
        sin 37 degrees), and gets their radius.
    half_as_wide
        Receivers whose samples span less than this share of the largest span do not determine a radius.
    enough
        Of more than twice as many pooled samples only some are used to fit a circle.
    """

    pool_s: float = 1e-4
    smooth_s: float = 1e-3
    at_rest: int = 10
    arc_quantile: float = 0.9
    short_chord: float = 1.2
    half_as_wide: float = 0.5
    enough: int = 6000


ROUGH = RoughSettings()


@dataclass(frozen=True, slots=True)
class RoughPhases:
    """Phases by constant circles.

    Attributes
    ----------
    time_s
        Shape (n,).
    phase_rad
        Unwrapped, shape (n_receivers, n).
    turns_hz
        Fringes per second of the fastest receiver by any of its circles, smoothed, shape (n,).
    ellipses
        One a receiver.
    seen
        For each receiver whose arc was completed, by number, the ellipse and phases from its samples alone. A weak echo
        that went round a small circle looks like a short arc of a large one; only fits distinguish them.
    """

    time_s: FloatArray
    phase_rad: FloatArray
    turns_hz: FloatArray
    ellipses: tuple[Ellipse, ...]
    seen: dict[int, tuple[Ellipse, FloatArray]]

    def as_seen(self, receiver: int) -> RoughPhases:
        """Return the same with one receiver's arc not completed."""
        ellipse, own = self.seen[receiver]
        phase, ellipses = self.phase_rad.copy(), list(self.ellipses)
        phase[receiver], ellipses[receiver] = own, ellipse
        return replace(self, phase_rad=phase, ellipses=tuple(ellipses))


def rough_phases(signals: ScaledSignals, onset_s: float) -> RoughPhases:
    """Fit a circle to each receiver's moving part and unwrap its phase."""
    pooled = pool(signals, ROUGH.pool_s)
    spacing = float(np.median(np.diff(pooled.time_s)))
    width = max(1, round(ROUGH.smooth_s / spacing))
    smooth = uniform_filter1d(pooled.value, width, axis=1, mode="nearest")
    moving = pooled.time_s >= onset_s
    fitted = []
    for pair in pairs_of(smooth):
        # weighed by the arc: else the slow beginning and the apexes, with most samples, would be the circle
        arc = np.hypot(*np.gradient(smooth[pair], axis=1))
        noise = float(np.median(arc[~moving])) if (~moving).sum() > ROUGH.at_rest else 0.0
        # noise makes a path of its own, longer than that of a slow target
        arc = np.sqrt(np.maximum(arc**2 - noise**2, 0.05 * noise**2 + 1e-12))
        weight = np.minimum(arc, np.quantile(arc[moving], ROUGH.arc_quantile))[moving]
        part = np.flatnonzero(moving)[:: max(1, weight.size // ROUGH.enough)]
        points, weight = pooled.value[pair, part], weight[:: max(1, weight.size // ROUGH.enough)]
        fitted.append(circle_through(points, weight))
    ellipses = _arcs_completed(smooth, moving, fitted, signals.scale_v)
    pairs = pooled.value.reshape(-1, 2, pooled.time_s.size)
    phase = np.array([_phase_of(pair, pooled.time_s, own) for pair, own in zip(pairs, ellipses, strict=True)])
    changed = [k for k, ellipse in enumerate(ellipses) if ellipse is not fitted[k]]
    seen = {k: (fitted[k], _phase_of(pairs[k], pooled.time_s, fitted[k])) for k in changed}
    every = np.array([*phase, *(own for _, own in seen.values())])
    slope = np.gradient(uniform_filter1d(every, 2 * width, axis=1, mode="nearest"), pooled.time_s, axis=1)
    # the fastest receiver sets the bins, so that in none of them a phase turns too far
    turns = np.abs(uniform_filter1d(slope, width, axis=1, mode="nearest")).max(axis=0) / (2.0 * np.pi)
    return RoughPhases(pooled.time_s, phase, turns, tuple(ellipses), seen)


def _phase_of(pair: FloatArray, time_s: FloatArray, ellipse: Ellipse) -> FloatArray:
    x, y = ellipse.apply(pair)
    return unwrapped(np.arctan2(y, x), time_s)


def _arcs_completed(
    smooth: FloatArray, moving: BoolArray, ellipses: list[Ellipse], scale_v: FloatArray
) -> list[Ellipse]:
    """Return the circles; a receiver that saw less than a fifth of a turn gets a circle as large as the others'.

    A short arc does not determine its circle. The radius is taken from receivers that saw more, and the centre lies on
    the side of the smaller offset.
    """
    chord, middle, along = [], [], []
    for pair in smooth.reshape(-1, 2, smooth.shape[1]):
        # by moments: a chord is known where a circle is not
        mean = pair[:, moving].mean(axis=1)
        apart = pair[:, moving] - mean[:, None]
        _, axes = np.linalg.eigh(apart @ apart.T)
        # the larger eigenvalue comes last: along the arc
        run = axes[:, 1] @ apart
        chord.append(float(run.max() - run.min()))
        middle.append(mean + axes[:, 1] * 0.5 * (run.max() + run.min()))
        along.append(axes[:, 1])
    # in volts: samples are scaled by what each receiver shows, a short arc by less than its circle
    size = np.array(chord) * scale_v
    # who went all the way round has seen a chord as long as the diameter
    radius_v = 0.5 * float(np.median(size[size > ROUGH.half_as_wide * size.max()]))
    out = list(ellipses)
    for k in np.flatnonzero(size < ROUGH.short_chord * radius_v):
        radius = radius_v / float(scale_v[k])
        across = np.array([-along[k][1], along[k][0]]) * np.sqrt(max(radius**2 - (0.5 * chord[k]) ** 2, 0.0))
        # offsets are small against an echo that is tuned for it; the mirror image of a short arc fits as well
        centre = min((middle[k] + across, middle[k] - across), key=lambda c: float(c @ c))
        out[k] = Ellipse(float(centre[0]), float(centre[1]), radius, 1.0, 0.0)
    return out
