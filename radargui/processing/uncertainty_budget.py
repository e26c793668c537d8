"""The uncertainty budget of a result, and the combined uncertainties of its track and its impacts (method 6)."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from radargui.geometry.antennas import place_antennas
from radargui.geometry.bistatic import solve_gradient
from radargui.geometry.path_length import path_gradient, path_lengths
from radargui.geometry.plane_wave import locate_plane
from radargui.geometry.scattering import scattering_delay_m
from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, TILT, assumed_uncertainties, uncertain_inputs
from radargui.model.bounce import Bounces
from radargui.model.path import PathLengths
from radargui.model.segment import Segment
from radargui.model.setup import Setup
from radargui.model.setup_change import moved
from radargui.model.track import Track
from radargui.model.uncertainty_budget import BudgetLine, InputChange, Share, UncertaintyBudget
from radargui.processing.locate import locate
from radargui.restitution.track_response import floor_and_clock, respond

POINTS = 2000
"""Samples of the motion that are located again for each input: how a track bends needs no more, and each is a solve."""
HYPOTHETICAL_DEG = (0.0, 45.0, 90.0, 135.0)
"""Of the transmitter's field, where nobody says it: half a turn of directions, the other half is the same."""
HYPOTHETICAL_TURNS_DEG = (-55.0, 55.0)
"""Of the receivers from the strongest signal: as for the joint estimate."""


def with_budget(
    track: Track, bounces: Bounces, changes: Iterable[InputChange], segment: Segment, setup: Setup
) -> tuple[Track, Bounces, UncertaintyBudget]:
    """Return track and bounces with their combined uncertainties, and the budget.

    Parameters
    ----------
    track, bounces
        With their statistical uncertainties.
    changes
        What they change by with each uncertain input.
    segment
        The motion, over which the position's uncertainty is averaged.
    setup
        Says which uncertainties were assumed.
    """
    thin: dict[str, tuple[FloatArray, FloatArray]] = {}
    e_squares: dict[str, FloatArray] = {}
    g_squares: dict[str, float] = {}
    for one in changes:
        before = thin[one.share][1] if one.share in thin else 0.0
        thin[one.share] = one.time_s, before + one.moved_m**2
        e_squares[one.share] = e_squares.get(one.share, np.zeros(one.e.shape)) + one.e**2
        g_squares[one.share] = g_squares.get(one.share, 0.0) + one.g_m_s2**2
    squares = {
        share: np.array([np.interp(track.time_s, time_s, row) for row in square])
        for share, (time_s, square) in thin.items()
    }
    combined = np.sqrt(track.u_position_m**2 + sum(squares.values()))
    e_all = sum(e_squares.values()) if e_squares else np.zeros(len(bounces.impacts))
    impacts = tuple(
        replace(own, u_e_combined=float(np.hypot(own.u_e, np.sqrt(more))))
        for own, more in zip(bounces.impacts, np.broadcast_to(e_all, len(bounces.impacts)), strict=True)
    )
    part = slice(segment.first, segment.last)

    def motion(square: FloatArray) -> float:
        known = square[:, part][:, track.valid[part]]
        return float(np.sqrt(np.nanmean(known))) if np.isfinite(known).any() else float("nan")

    fall = bounces.free_fall
    budget = UncertaintyBudget(
        _line(motion(track.u_position_m**2), {name: motion(value) for name, value in squares.items()}),
        _line(
            bounces.impacts[0].u_e if bounces.impacts else float("nan"),
            {name: float(np.sqrt(value[0])) for name, value in e_squares.items() if value.size},
        ),
        _line(float("nan") if fall is None else fall.u_g_m_s2, {k: float(np.sqrt(v)) for k, v in g_squares.items()}),
        assumed_uncertainties(setup),
    )
    return replace(track, u_combined_m=combined), replace(bounces, impacts=impacts), budget


def _line(statistical: float, shares: dict[str, float]) -> BudgetLine:
    if not np.isfinite(statistical):
        return BudgetLine()
    calibration, sphere = shares.get("calibration", 0.0), shares.get("sphere", 0.0)
    combined = float(np.sqrt(statistical**2 + calibration**2 + sphere**2))
    known = [value if np.isfinite(value) else None for value in (statistical, calibration, sphere, combined)]
    return BudgetLine(*known)


def changes_of_track(paths: PathLengths, bounces: Bounces, setup: Setup, segment: Segment) -> tuple[InputChange, ...]:
    """Return what a located track changes by with each uncertain input of the setup, to first order.

    The same path lengths are located with the input moved (GUM, 5.1.3). That these change with the geometry too,
    through maps of position, is of second order. A sphere that is no point adds the phase it scatters with: by its
    diameter and the polarisations where they are told, else that of a few polarisations.

    Parameters
    ----------
    paths, bounces, segment
        Of the run.
    """
    size = max(1, (segment.last - segment.first) // POINTS)
    # before and after the motion all shifts stand
    thin = _thinned(paths, slice(segment.first, segment.last), size)
    inner = Segment(0, thin.time_s.size, 0, 0)
    base = _located(thin, setup)
    if base is None:
        return ()
    keys: list[tuple[str, Share]] = []
    shifts: list[FloatArray] = []

    def add(key: str, share: Share, shift_m: FloatArray) -> None:
        keys.append((key, share))
        shifts.append(shift_m)

    told = setup.transmitter.polarization_deg is not None
    for one in uncertain_inputs(setup):
        if one.u == 0.0 or one.key in (CLOCK, TILT):
            continue
        other = moved(setup, one.key, one.u)
        if one.key == "tracer.diameter_m" or one.key.endswith("polarization_deg"):
            if told:
                change_m = scattering_delay_m(base.position_m, setup) - scattering_delay_m(base.position_m, other)
                add(one.key, "sphere", _moved(base, thin.change_m + change_m, setup, setup))
            continue
        longer = other.radar.wavelength_m / setup.radar.wavelength_m
        add(one.key, "calibration", _moved(base, longer * thin.change_m, other, setup))
    ways = [] if told else [(angle, turn) for angle in HYPOTHETICAL_DEG for turn in HYPOTHETICAL_TURNS_DEG]
    for angle, turn in ways:
        delay_m = scattering_delay_m(base.position_m, _polarised(setup, angle, turn))
        add("sphere", "sphere", _moved(base, thin.change_m - delay_m, setup, setup) / np.sqrt(len(ways)))
    if not shifts:
        return ()
    given = "normal" in setup.floor.model_fields_set
    e, g = respond(base, inner, bounces, np.stack(shifts), given, setup.floor.u_tilt_deg)
    known = [np.nan_to_num(own) for own in shifts]
    changes = [InputChange(*key, thin.time_s, *own) for key, *own in zip(keys, known, e, g.tolist(), strict=True)]
    return (*changes, *floor_and_clock(base, inner, bounces, setup))


def _moved(base: Track, change_m: FloatArray, other: Setup, setup: Setup) -> FloatArray:
    """Return how far paths with another setup lie from where they did: one Newton step, of a shift far below them."""
    antennas, release = place_antennas(other), np.array(other.tracer.release_position_m)
    if setup.processing.geometry == "plane":
        return locate_plane(change_m, antennas, release) - base.position_m
    off = path_lengths(release[:, None], antennas) + change_m - path_lengths(base.position_m, antennas)
    return solve_gradient(path_gradient(base.position_m, antennas), off)


def _polarised(setup: Setup, angle_deg: float, turn_deg: float) -> Setup:
    """Return the setup with a polarised transmitter and the receivers turned from the strongest signal."""
    sent = setup.transmitter.model_copy(update={"polarization_deg": angle_deg})
    strongest = setup.model_copy(update={"transmitter": sent}).received_fields()
    receivers = tuple(
        own.model_copy(update={"polarization_deg": field.strongest_deg + turn_deg})
        for own, field in zip(setup.receiver, strongest, strict=True)
    )
    return setup.model_copy(update={"transmitter": sent, "receiver": receivers})


def _located(paths: PathLengths, setup: Setup) -> Track | None:
    release = np.array(setup.tracer.release_position_m)
    return locate(paths, place_antennas(setup), release, setup.processing.geometry)


def _thinned(paths: PathLengths, part: slice, size: int) -> PathLengths:
    def mean(x: FloatArray) -> FloatArray:
        inside = x[..., part]
        count = inside.shape[-1] // size
        return np.asarray(inside[..., : count * size].reshape(*x.shape[:-1], count, size).mean(axis=-1))

    valid = mean(paths.valid.astype(np.float64)) == 1.0
    return PathLengths(mean(paths.time_s), mean(paths.phase_rad), mean(paths.change_m), mean(paths.u_m), valid)
