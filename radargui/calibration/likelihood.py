"""The likelihood of a recording by its path lengths.

It is wide, so a fit can begin far off; `signal_likelihood` is the sharp one, by the samples.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from radargui.calibration.unknowns import Unknown
from radargui.estimation.solve.problem import huber
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.setup import Setup
from radargui.physics.mirrors import MirrorPlane
from radargui.physics.path_length import Antennas, antennas_at, path_gradient, path_lengths, receiver_values, t_matrix

_VALUES = ("tilt_deg", "azimuth_deg", "distance_m")
STEP = 0.01
"""Step of a difference, in prior deviations."""


class MotionModel(Protocol):
    """A motion that is known but for a few unknowns (`Falls`, `KnownMotion`)."""

    @property
    def own(self) -> tuple[Unknown, ...]:
        """Unknowns of this recording alone."""

    @property
    def uses(self) -> tuple[str, ...]:
        """Names of the shared unknowns that it depends on."""

    def known(self, time_s: FloatArray) -> BoolArray:
        """Return at which times it is known, shape (n,)."""

    def at(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return place, velocity, acceleration at times, shape (3, 3, n), and its constraints.

        The constraints are given as deviations from them, in standard deviations, shape (n_ties,).
        """

    def slopes(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return derivatives of places and ties by what it `uses`, then by its own, (n, 3, n_times) and (n, n_ties)."""


@dataclass(frozen=True, eq=False)
class World:
    """The shared unknowns and the setup they belong to.

    Two are equal only if they are the same object (`_antennas` caches by it).

    Attributes
    ----------
    setup
        As it was.
    unknowns
        The unknowns, in the order of all vectors.
    """

    setup: Setup
    unknowns: tuple[Unknown, ...]

    def values(self, z: FloatArray) -> dict[str, float]:
        """Return values by name for shifts in prior deviations, shape (n,)."""
        return {one.name: one.value + one.u * float(shift) for one, shift in zip(self.unknowns, z, strict=True)}

    def antennas(self, z: FloatArray) -> Antennas:
        """Return where the antennas stand."""
        return _antennas(self, tuple(z.tolist()))

    def polarisations(self, z: FloatArray) -> FloatArray:
        """Return the antennas' angles (rad), the transmitter's first; none where they are each recording's own."""
        shifts = zip(self.unknowns, z.tolist(), strict=True)
        return np.radians([one.value + one.u * shift for one, shift in shifts if one.group == "polarization"])


@lru_cache(maxsize=64)
def _antennas(world: World, z: tuple[float, ...]) -> Antennas:
    # all recordings ask for the same places and the same steps from there
    receivers, sent = receiver_values(world.setup), np.array(world.setup.transmitter.place_m)
    for one, shift in zip(world.unknowns, z, strict=True):
        place, _, name = one.key.partition(".")
        by = one.u * shift
        if place.startswith("receiver") and name in _VALUES:
            receivers[_VALUES.index(name), int(place[9:-1]) - 1] += by
        elif name.startswith("position_m"):
            sent[int(name[-2]) - 1] += by
        elif name == "distance_m":
            # a transmitter off the axis stays in its direction
            sent *= 1.0 + by / np.linalg.norm(sent)
    return antennas_at(receivers, sent)


@dataclass(frozen=True)
class Local:
    """A recording at a state: cost, and the normal equations with its own unknowns eliminated.

    H = [[A, B^T], [B, C]] over (shared, own); Schur complement A - B^T C^-1 B.

    Attributes
    ----------
    cost
        Half the robust squares, with the priors of its own unknowns.
    normal, slope
        Normal matrix and slope of the shared unknowns with its own held, shapes (n, n) and (n,).
    coupling, inner, inner_slope
        B, C and the slope of its own, shapes (m, n), (m, m), (m,).
    residual_m
        Measured path less fitted path, shape (n_receivers, n); NaN where it does not count.
    misfit
        Median square of the residuals in standard deviations over what Gaussian ones have, shape (n_receivers,).
    """

    cost: float
    normal: FloatArray
    slope: FloatArray
    coupling: FloatArray
    inner: FloatArray
    inner_slope: FloatArray
    residual_m: FloatArray
    misfit: FloatArray

    def reduced(self, damping: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return Schur complement, its slope, and C^-1 [B, slope] to go back with."""
        # Marquardt damps the diagonal of the whole matrix, of which this is a part
        inner = self.inner + damping * np.diag(np.diag(self.inner))
        back = np.asarray(np.linalg.solve(inner, np.column_stack([self.coupling, self.inner_slope])), np.float64)
        normal = self.normal - self.coupling.T @ back[:, :-1]
        return normal, self.slope - self.coupling.T @ back[:, -1], back


def own_values(motion: MotionModel, own: FloatArray) -> FloatArray:
    """Return the values of a motion's own unknowns; they stand first among a recording's own, in prior deviations."""
    return np.array([one.value + one.u * float(z) for one, z in zip(motion.own, own, strict=False)])


class Likelihood(Protocol):
    """The likelihood of one recording. Methods about maps, mirrors and noise scales do nothing unless overridden."""

    @property
    def start(self) -> FloatArray:
        """First guess of its own unknowns, in prior deviations."""

    def begun(self, world: World, z: FloatArray, own: FloatArray) -> Begun:
        """Return its cost at a state, and the function that computes the rest."""

    def at(self, world: World, z: FloatArray, own: FloatArray) -> Local:
        """Return it at a state."""
        return self.begun(world, z, own).local()

    def renewed(self, own: FloatArray, _local: Local) -> tuple[Likelihood, FloatArray]:
        """Return it with the deviations of maps and mirrors re-estimated and the noise scaled, and its own unknowns."""
        return self, own

    def scaled(self, _misfit: FloatArray, _least: float) -> Likelihood:
        """Return it with the noise of each receiver as its misfit says, shape (n_receivers,)."""
        return self

    def with_mirrors(self, _planes: Sequence[MirrorPlane], own: FloatArray) -> tuple[Likelihood, FloatArray]:
        """Return it with more mirrors, which reflect nothing yet, and its own unknowns."""
        return self, own

    def log_widths(self) -> float:
        """Return the part of the log evidence that is neither cost nor determinant."""
        return 0.0


@dataclass(frozen=True)
class Begun:
    """A recording at a trial state: its cost, and a function that computes the rest, which takes longer."""

    cost: float
    local: Callable[[], Local]


@dataclass(frozen=True)
class Measured:
    """The measured paths of a recording.

    Attributes
    ----------
    time_s
        Shape (n,).
    change_m
        Path length but for a constant, shape (n_receivers, n); NaN where not known.
    u_m
        Standard deviation that counts for each value.
    """

    time_s: FloatArray
    change_m: FloatArray
    u_m: float


def motion_slopes(
    motion: MotionModel, world: World, z: FloatArray, own: FloatArray, time_s: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the motion's series, its place's slopes by shared and own unknowns, (3, n, n_all), ties and their slopes.

    All in prior deviations; the shared unknowns come first.
    """
    values, base, n_shared = world.values(z), own_values(motion, own), len(world.unknowns)
    here, tied = motion.at(time_s, values, base)
    by, by_tied = motion.slopes(time_s, values, base)
    number = {one.name: n for n, one in enumerate(world.unknowns)}
    steps = [*(number[name] for name in motion.uses), *range(n_shared, n_shared + own.size)]
    u = np.array([one.u for one in (*world.unknowns, *motion.own)])[steps]
    slopes, ties = np.zeros((3, time_s.size, n_shared + own.size)), np.zeros((tied.size, n_shared + own.size))
    slopes[:, :, steps], ties[:, steps] = np.moveaxis(by, 0, 2) * u, by_tied.T * u
    return here, slopes, tied, ties


@dataclass(frozen=True)
class PathLikelihood(Likelihood):
    """A recording by its path lengths: a constant each, and slow errors at one and two cycles a fringe.

    L measured = L(p(t)) + c + sum over m = 1, 2 of s_m sin(m K L) + c_m cos(m K L): these are bias and quadrature error
    that a correction left. Other errors that neighbouring samples share must be in `u_m`.

    Attributes
    ----------
    measured, motion
        Data and what is known.
    wavelength_m, is_plane
        Of the setup; whether the far field stands for the antennas.
    slow_m
        Prior deviation of the slow errors.
    loose
        Factor on all deviations but the priors', for a start far from the solution.
    """

    measured: Measured
    motion: MotionModel
    wavelength_m: float
    is_plane: bool = False
    slow_m: float = 1e-3
    loose: float = 1.0

    @property
    def start(self) -> FloatArray:
        """First guess: everything at its prior mean, no slow error."""
        return np.zeros(len(self.motion.own) + 5 * len(self.measured.change_m))

    def begun(self, world: World, z: FloatArray, own: FloatArray) -> Begun:
        """Return all that is known at a state; the constants are in metres, slow errors in their deviations."""
        data, n_own, n_shared, n_rx = self.measured, len(self.motion.own), len(z), len(self.measured.change_m)
        series, slopes, tied, by_ties = motion_slopes(self.motion, world, z, own[:n_own], data.time_s)
        place, antennas = series[0], world.antennas(z)
        rows = np.zeros((n_rx, data.time_s.size, n_shared + own.size))
        model, gradient = self._lengths(place, antennas)
        rows[:, :, : n_shared + n_own] = np.einsum("ran,ank->rnk", gradient, slopes)
        for k, one in enumerate(world.unknowns):
            if one.key:
                other = z.copy()
                other[k] += STEP
                rows[:, :, k] += (self._lengths(place, world.antennas(other))[0] - model) / STEP
        # an offset of I and Q bends the phase once a fringe, gain and quadrature twice
        turn = (2.0 * np.pi / self.wavelength_m) * data.change_m
        waves = np.stack([np.ones_like(turn), *(f(m * turn) for m in (1, 2) for f in (np.sin, np.cos))], axis=2)
        # the constant has a prior of one metre, which is none; slow errors one of slow_m
        waves = np.nan_to_num(waves) * np.array([1.0, *[self.slow_m] * 4])
        extra = own[n_own:].reshape(n_rx, 5)
        for n in range(n_rx):
            rows[n, :, n_shared + n_own + 5 * n :][:, :5] = waves[n]
        residual = model + np.einsum("rnk,rk->rn", waves, extra) - data.change_m
        use = np.isfinite(residual) & self.motion.known(data.time_s)
        u_m = self.loose * data.u_m
        scaled = np.where(use, residual, 0.0) / u_m
        losses, weight = huber(scaled)
        loss, weight = float(losses.sum()), weight * use / u_m**2
        flat, kept = rows.reshape(-1, rows.shape[2]), np.where(use, residual, 0.0)
        weighted = weight.reshape(-1, 1) * flat
        misfit = np.array([misfit_of(one[here]) for one, here in zip(scaled, use, strict=True)])
        # as loose as the paths: far from the solution ties lead astray as much (`fit_paths`)
        ties = tied / (10.0 * self.loose), by_ties / (10.0 * self.loose)
        normal, slope = weighted.T @ flat, weighted.T @ kept.ravel()
        local = local_at(loss, normal, slope, n_shared, ties, own, np.where(use, -residual, np.nan), misfit)
        return Begun(local.cost, lambda: local)

    def _lengths(self, place: FloatArray, antennas: Antennas) -> tuple[FloatArray, FloatArray]:
        if not self.is_plane:
            return path_lengths(place, antennas), path_gradient(place, antennas)
        # dL = -T p (Rech & Huang 2019, eq. 3)
        t = -t_matrix(antennas)
        return t @ place, np.repeat(t[:, :, None], place.shape[1], axis=2)


def misfit_of(scaled: FloatArray) -> float:
    """Return the median square of residuals in standard deviations over that of a Gaussian."""
    # the median of chi-square of one degree of freedom: outliers do not move it
    return float(np.median(scaled**2)) / 0.4549 if scaled.size else 1.0


def cost_of(loss: float, tied: FloatArray, pull: FloatArray) -> float:
    """Return half the squares of samples, ties and priors."""
    return loss + 0.5 * float(tied @ tied) + 0.5 * float(pull @ pull)


def local_at(
    loss: float,
    normal: FloatArray,
    slope: FloatArray,
    n_shared: int,
    ties: tuple[FloatArray, FloatArray],
    pull: FloatArray,
    residual_m: FloatArray,
    misfit: FloatArray,
) -> Local:
    """Return the state with ties added, and the priors of its own unknowns, each `pull` deviations from its mean."""
    tied, by_ties = ties
    k = by_ties.shape[1]
    normal[:k, :k] += by_ties.T @ by_ties
    slope[:k] += by_ties.T @ tied
    cost = cost_of(loss, tied, pull)
    # all unknowns are in prior deviations: every prior has a curvature of one
    inner = normal[n_shared:, n_shared:] + np.eye(pull.size)
    return Local(
        cost, normal[:n_shared, :n_shared], slope[:n_shared], normal[n_shared:, :n_shared], inner,
        slope[n_shared:] + pull, residual_m, misfit,
    )  # fmt: skip
