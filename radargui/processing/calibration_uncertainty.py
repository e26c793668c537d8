"""What the uncertainty of antennas and release position adds to the results, carried by finite differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from radargui.geometry.antennas import place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.assumed import uncertain_inputs
from radargui.model.bounce import Bounces
from radargui.model.path import PathLengths
from radargui.model.segment import Segment
from radargui.model.setup import Setup
from radargui.model.setup_change import moved
from radargui.model.track import Track
from radargui.processing.locate import locate

POINTS = 2000
Shift = Callable[[FloatArray, FloatArray], tuple[float, float]]


def calibration_uncertainty(
    paths: PathLengths,
    setup: Setup,
    segment: Segment,
    bounces_of: Callable[[Track, Segment, Setup, float], Bounces],
    sample_rate_hz: float,
    shift: Shift | None = None,
) -> dict[str, float] | None:
    """Return standard uncertainties of position, first e and g from those of the antennas and the release position.

    Each input that the setup gives an uncertainty for is shifted by it, the track located again from the same path
    lengths and the results' changes added in squares (GUM, 5.1.3). Path lengths are what the samples determine; that
    they change with the geometry too, through maps of position, is of second order.

    Parameters
    ----------
    paths, setup, segment
        Of the run.
    bounces_of
        Finds bounces in a track, of which e and g are taken, once with and once without the shift.
    sample_rate_hz
        Of the paths.
    shift
        Changes of e and g for a shift of the track, where the road that found them knows them: another finder, with
        other parts free, may follow with the opposite sign.

    Returns
    -------
    dict or None
        `u_position_m` (root mean square over the motion and the axes), `u_e`, `u_g_m_s2`; None where the setup
        gives no uncertainty.
    """
    shifted = list(_shifted(setup))
    if not shifted:
        return None
    size = max(1, (segment.last - segment.first) // POINTS)
    thin = _thinned(paths, size)
    inner = Segment(segment.first // size, segment.last // size, segment.rest_first // size, segment.rest_last // size)
    part, rate_hz = slice(inner.first, inner.last), sample_rate_hz / size
    base = _located(thin, setup)
    if base is None:
        return None
    before = (0.0, 0.0) if shift is not None else _figures(bounces_of(base, inner, setup, rate_hz))
    squares: dict[str, float] = {}
    for other in shifted:
        track = _located(thin, other)
        if track is None:
            continue
        moved = track.position_m - base.position_m
        if shift is not None:
            e, g = shift(thin.time_s[inner.rest_first : inner.last], moved[:, inner.rest_first : inner.last])
        else:
            e, g = np.subtract(_figures(bounces_of(track, inner, other, rate_hz)), before)
        changes = {"u_position_m": float(np.sqrt(np.nanmean(moved[:, part] ** 2))), "u_e": e, "u_g_m_s2": g}
        for name, change in changes.items():
            squares[name] = squares.get(name, 0.0) + change**2
    return {name: float(np.sqrt(value)) for name, value in squares.items() if np.isfinite(value)}


def _located(paths: PathLengths, setup: Setup) -> Track | None:
    release = np.array(setup.tracer.release_position_m)
    return locate(paths, place_antennas(setup), release, setup.processing.geometry)


def _figures(bounces: Bounces) -> tuple[float, float]:
    e = bounces.impacts[0].e if bounces.impacts else float("nan")
    g = bounces.free_fall.g_m_s2 if bounces.free_fall else float("nan")
    return e, g


def _thinned(paths: PathLengths, size: int) -> PathLengths:
    def mean(x: FloatArray) -> FloatArray:
        count = x.shape[-1] // size
        return np.asarray(x[..., : count * size].reshape(*x.shape[:-1], count, size).mean(axis=-1))

    valid = mean(paths.valid.astype(np.float64)) == 1.0
    return PathLengths(mean(paths.time_s), mean(paths.phase_rad), mean(paths.change_m), mean(paths.u_m), valid)


def _shifted(setup: Setup) -> list[Setup]:
    places = ("receiver", "transmitter", "tracer.release")
    given = [one for one in uncertain_inputs(setup) if one.key.startswith(places) and not one.assumed and one.u]
    return [moved(setup, one.key, one.u) for one in given if not one.key.endswith("polarization_deg")]
