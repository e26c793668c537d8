"""Multiply what the runs on one hardware say of antennas, release and wavelength: the prior of another run.

Make a calibration of what the drops of a session say of the antennas.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import takewhile

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.assumed import UncertainInput, release_parts_m, u_release_m
from radargui.model.calibrated_setup import value_at
from radargui.model.calibration import Calibration, Origin
from radargui.model.finding import Finding, warn
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupLikelihood, unknown_inputs

_RELEASE, _WAVE = "tracer.release_position_m", "radar"
_SIGMAS = 3.72
"""A place differs by so much by chance once in ten thousand: as many deviations of a normal number."""
_LEAST = 1e-6
"""Least variance of a value that drops share, in squares of its u: an inverse is wanted."""


_HARDWARE = ("radar", "transmitter", "receiver", "daq", "calibration")


@dataclass(frozen=True, slots=True)
class RunLikelihood:
    """The likelihood of antennas, release and wavelength by a single run.

    Attributes
    ----------
    run
        Name of the run.
    setup
        What its result was made with.
    likelihood
        In the units of that setup's unknowns.
    begins
        Whether the run contradicts the runs before it; those are then not used for later runs.
    """

    run: str
    setup: Setup = field(repr=False)
    likelihood: SetupLikelihood = field(repr=False)
    begins: bool = False

    def is_of(self, setup: Setup) -> bool:
        """Return whether it was made with the antennas of a setup, and with what that is uncertain by."""
        same = all(getattr(self.setup, part) == getattr(setup, part) for part in _HARDWARE)
        return same and unknown_inputs(self.setup)[0] == unknown_inputs(setup)[0]


@dataclass(frozen=True, slots=True)
class SetupPrior:
    """What other runs of a session, together with the setup's prior, say of a run's antennas, release and wavelength.

    Attributes
    ----------
    runs
        Names of the runs.
    mean, covariance
        Of the setup's unknowns (`unknown_inputs`) in their u from what is stated, of this run: its release has its own
        scatter. Shapes (n,) and (n, n).
    used
        Whether the run was estimated with it; it is not used if the run contradicts it.
    """

    runs: tuple[str, ...]
    mean: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]
    used: bool = True

    def likelihood(self, deviation: FloatArray) -> SetupLikelihood:
        """Return what the others say beyond the setup's prior of one run, N(0, deviation^2), shape (n,)."""
        precision = np.linalg.inv(np.array(self.covariance))
        matrix = precision - np.diag(deviation**-2.0)
        return SetupLikelihood.sound(matrix, precision @ np.array(self.mean))


def known_setup(before: Sequence[RunLikelihood], after: Sequence[RunLikelihood], setup: Setup) -> SetupPrior | None:
    """Return what the runs before and after one say of its antennas; None where they say nothing.

    Runs with the same antennas count: those before it back to (and with) a run that contradicts its predecessors, and
    those after it up to the next such run.

    Parameters
    ----------
    before, after
        In the order of their recording.
    setup
        Of the run.
    """
    found: list[RunLikelihood] = []
    for one in reversed([one for one in before if one.is_of(setup)]):
        found.insert(0, one)
        if one.begins:
            break
    found += takewhile(lambda one: not one.begins, (one for one in after if one.is_of(setup)))
    return _pool(found, setup) if found else None


def _pool(runs: Sequence[RunLikelihood], setup: Setup) -> SetupPrior:
    """Return the product of what runs say, each by itself, with one prior from the setup.

    The scatter of each drop's release is integrated out; a release that was stated elsewhere has an error of its own.
    If runs differ by more than their uncertainties the result is widened (Birge ratio).
    """
    inputs, deviation = unknown_inputs(setup)
    per_m, release = _release_moves(inputs)
    scatter = release_parts_m(setup.tracer)[1] * per_m
    each = [_of_drop(one, setup, per_m, release) for one in runs]
    own = np.where(_of_release(inputs), np.diag(scatter @ scatter.T), 0.0)
    prior = np.diag(1.0 / np.maximum(deviation**2 - own, _LEAST * deviation**2))
    matrix, vector = sum(one.matrix for one in each), sum(one.vector for one in each)
    mean = np.asarray(np.linalg.solve(prior + matrix, vector))
    apart, count = (sum(part) for part in zip(*(one.misfit(mean) for one in each), strict=True))
    fitted = float(np.trace(np.linalg.solve(prior + matrix, matrix)))
    birge = max(1.0, apart / max(count - fitted, 1.0))
    covariance = np.linalg.inv(prior + matrix / birge)
    mean = covariance @ vector / birge
    covariance = covariance + scatter @ scatter.T
    return SetupPrior(tuple(one.run for one in runs), tuple(mean.tolist()), tuple(map(tuple, covariance.tolist())))


def bumped(alone: SetupLikelihood, prior: SetupPrior, setup: Setup) -> Finding | None:
    """Return the place, an antenna mostly, that a run by itself finds elsewhere than the others; else None.

    Chi-square of the run against the prior, less that with the values of one place free, is chi-square distributed with
    as many degrees of freedom. If chance exceeds it less than once in ten thousand cases the place has moved.
    """
    inputs, _ = unknown_inputs(setup)
    covariance, mean = np.array(prior.covariance), np.array(prior.mean)
    # the run's estimate scatters about the prior's mean: C = (1 + B P)^-1 B weighs the difference of the two
    off = alone.vector - alone.matrix @ mean
    weighed = np.linalg.inv(np.eye(mean.size) + alone.matrix @ covariance)
    slope, cost = weighed @ off, weighed @ alone.matrix
    found: list[tuple[float, float, str]] = []
    places = np.array([one.key.split("[")[0] if one.key.startswith("tracer.") else _place(one.key) for one in inputs])
    # a wavelength is pushed by nobody, and a drop tells next to nothing of it: what it differs by is rounding
    for place in dict.fromkeys(one for one in places.tolist() if one != _WAVE):
        free = np.flatnonzero(places == place)
        normal = 0.5 * (cost + cost.T)[np.ix_(free, free)]
        gain = float(slope[free] @ np.linalg.pinv(normal, rcond=1e-9, hermitian=True) @ slope[free])
        found.append((gain / max_by_chance(free.size), gain, place))
    share, gain, place = max(found)
    return warn("antenna_moved", place=place, chi_square=gain) if share > 1.0 else None


def max_by_chance(degrees: int) -> float:
    """Return the chi-square that is exceeded once in ten thousand (Wilson & Hilferty, PNAS 17, 684, 1931)."""
    # by hand: loading `scipy.special` costs 0.1 s (decision 26)
    variance = 2.0 / (9.0 * degrees)
    return degrees * float(1.0 - variance + _SIGMAS * math.sqrt(variance)) ** 3


def _place(key: str) -> str:
    return key.split("[")[0] if key.startswith("calibration") else key.split(".")[0]


def _of_release(inputs: Sequence[UncertainInput]) -> FloatArray:
    return np.array([one.key.startswith(_RELEASE) for one in inputs], dtype=bool)


def _of_drop(run: RunLikelihood, setup: Setup, per_m: FloatArray, release: FloatArray) -> SetupLikelihood:
    """Return what a run says of the unknowns of a setup, its own release integrated out.

    `per_m` and `release` as from `_release_moves`.
    """
    if run.setup.tracer.release_position_m == setup.tracer.release_position_m:
        return run.likelihood.smeared(release_parts_m(run.setup.tracer)[1] * per_m)
    # stated elsewhere, measured anew: its error is no other's
    own = run.likelihood.smeared(u_release_m(run.setup.tracer) * per_m)
    held = np.eye(len(per_m)) - per_m @ release
    return SetupLikelihood.sound(held.T @ own.matrix @ held, held.T @ own.vector)


def _release_moves(inputs: Sequence[UncertainInput]) -> tuple[FloatArray, FloatArray]:
    """Return by how much inputs move for a metre of the release's x, y, z, shape (n, 3), and how far each moves it."""
    moves = [dict(one.together or ((one.key, one.u),)) for one in inputs]
    keys = [f"{_RELEASE}[{axis}]" for axis in (1, 2, 3)]
    every = [*keys, *sorted({key for one in moves for key in one} - set(keys))]
    # of a calibration the directions of its covariance are the inputs: together they span what moves
    by_input = np.array([[one.get(key, 0.0) for one in moves] for key in every])
    scale = np.abs(by_input).max(axis=1, initial=0.0)
    scale[scale == 0.0] = 1.0
    return np.asarray(np.linalg.pinv(by_input / scale[:, None])[:, :3] / scale[:3]), by_input[:3]


_STEP = 1e-3
"""Share of an input's u over which the change of a value is taken."""


def pooled_calibration(runs: Sequence[RunLikelihood], setup: Setup, origin: Origin) -> Calibration | None:
    """Return the antennas as runs determine them together; None if none of them says anything of this setup's antennas.

    The release stays as stated, because that of the next drop is another one.

    Parameters
    ----------
    runs
        In the order of their recording; see `known_setup` for which of them count.
    setup
        What states the antennas.
    origin
        Of the calibration.
    """
    pool = known_setup(runs, (), setup)
    if pool is None:
        return None
    inputs, deviation = unknown_inputs(setup)
    names = _names(setup, is_beside=any(one.key.startswith("transmitter.position_m") for one in inputs))
    before = _values(setup, names)
    by_input = np.stack([(_values(one.moved(setup, _STEP), names) - before) / _STEP for one in inputs], axis=1)
    mean, covariance = np.array(pool.mean), by_input @ np.array(pool.covariance) @ by_input.T
    u_before = np.sqrt(((by_input * deviation) ** 2).sum(axis=1))
    known_as_before = bool((np.diag(covariance) > 0.99**2 * u_before**2).any())
    verdict = "usable" if known_as_before else "good"
    reason = f"{', '.join(pool.runs)} together, with what the setup stated."
    return Calibration(names, before, before + by_input @ mean, u_before, covariance, (), (), verdict, reason, origin)


def _names(setup: Setup, *, is_beside: bool) -> tuple[str, ...]:
    receivers = [f"receiver.{n}.{name}" for n in range(1, setup.n_receivers + 1) for name in _ANTENNA]
    is_placed = is_beside or setup.transmitter.position_m is not None
    sender = [f"transmitter.position_m.{axis}" for axis in "xyz"] if is_placed else ["transmitter.distance_m"]
    return (*receivers, *sender)


_ANTENNA = ("tilt_deg", "azimuth_deg", "distance_m")


def _values(setup: Setup, names: Sequence[str]) -> FloatArray:
    place = dict(zip("xyz", setup.transmitter.place_m, strict=True))
    # where the transmitter is stated by its distance, and stands beside its axis all the same
    values = [place[name[-1]] if name.startswith("transmitter.position") else value_at(setup, name) for name in names]
    return np.array([math.nan if one is None else one for one in values])
