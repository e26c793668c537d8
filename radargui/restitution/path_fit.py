"""Fit flights and what the setup leaves open to path lengths whose errors belong to the place (method 5, Flights)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupLikelihood, SetupPosterior
from radargui.motion.flights import FlightLayout, Flights
from radargui.physics.path_length import locate_exact, path_gradient, path_lengths, place_antennas
from radargui.physics.setup_unknowns import SetupUnknowns
from radargui.restitution.settings import PATHS
from radargui.restitution.stretches import Stretches


@dataclass(frozen=True, slots=True)
class PathSamples:
    """Means of the changes of path over flights.

    Attributes
    ----------
    time_s
        Shape (n,).
    change_m
        Shape (n_receivers, n).
    """

    time_s: FloatArray
    change_m: FloatArray


@dataclass(frozen=True, slots=True)
class SharedPrior:
    """What is known of the unknowns that all flights share: those of the setup, g, drag k and its v1.

    Attributes
    ----------
    mean, precision
        Shapes (n,) and (n, n).
    """

    mean: FloatArray
    precision: FloatArray

    @staticmethod
    def of(unknowns: SetupUnknowns) -> SharedPrior:
        """Return what the setup states."""
        drag = unknowns.drag
        mean = np.array([*np.zeros(unknowns.size), unknowns.gravity_m_s2, drag.k_1_m, drag.slow_m_s])
        u_g = max(unknowns.u_gravity_m_s2, PATHS.min_u_g_m_s2)
        u_slow = max(drag.u_slow_m_s, PATHS.min_u_slow_m_s)
        deviation = np.array([*unknowns.deviation, u_g, max(drag.u_k_1_m, PATHS.min_u_k_1_m), u_slow])
        return SharedPrior(mean, np.diag(deviation**-2.0))


class PathModel:
    """Changes of path of flights, and their derivatives by the unknowns: those of the setup, then of the flights.

    Parameters
    ----------
    setup
        As stated.
    unknowns
        What of it is unknown.
    """

    def __init__(self, setup: Setup, unknowns: SetupUnknowns) -> None:
        self._antennas, self.unknowns, self.wavelength_m = place_antennas(setup), unknowns, setup.radar.wavelength_m
        self._release_m = np.asarray(setup.tracer.release_position_m)

    def places(self, setup: FloatArray, change_m: FloatArray) -> FloatArray:
        """Return the places (3, n) of changes of path (n_receivers, n) with the setup's unknowns at values."""
        unknowns = self.unknowns
        scale = float(np.exp(unknowns.by_log_wavenumber @ setup))
        release_m = self._release_m + unknowns.by_release @ setup
        return locate_exact(change_m / scale, unknowns.antennas(self._antennas, setup), release_m)

    def changes(self, values: FloatArray, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return L - L(release) in wavelengths as stated, (n_receivers, n), and its derivatives (n_receivers, p, n).

        `values`: unknowns of the setup, then those of `FlightLayout`.
        """
        unknowns = self.unknowns
        setup, flights = values[: unknowns.size], Flights.of(values[unknowns.size :])
        antennas = unknowns.antennas(self._antennas, setup)
        release = (self._release_m + unknowns.by_release @ setup)[:, None]
        # what is shorter than it is stated to be counts too few wavelengths
        scale = float(np.exp(unknowns.by_log_wavenumber @ setup))
        place, by_flights = flights.position_and_slopes(time_s)
        longer = path_lengths(place, antennas) - path_lengths(release, antennas)
        gradient, at_release = path_gradient(place, antennas), path_gradient(release, antennas)[..., 0]
        slopes = np.empty((antennas.n_receivers, values.size, time_s.size))
        sent = unknowns.by_antenna[0].T @ _from(antennas.transmitter_m, release, place)
        for number, (rows, receiver_m) in enumerate(zip(slopes, antennas.receivers_m, strict=True)):
            received = unknowns.by_antenna[1 + number].T @ _from(receiver_m, release, place)
            rows[: unknowns.size] = sent + received - (unknowns.by_release.T @ at_release[number])[:, None]
            rows[: unknowns.size] += np.outer(unknowns.by_log_wavenumber, longer[number])
            x, y, z = gradient[number]
            rows[unknowns.size :] = by_flights[:, 0] * x + by_flights[:, 1] * y + by_flights[:, 2] * z
        return scale * longer, scale * slopes


def _from(antenna_m: FloatArray, release_m: FloatArray, place_m: FloatArray) -> FloatArray:
    """Return what L - L(release) changes by with an antenna's place: unit vectors (3, n)."""
    away, back = place_m - antenna_m[:, None], release_m - antenna_m[:, None]
    return np.asarray(back / np.linalg.norm(back, axis=0) - away / np.linalg.norm(away, axis=0))


@dataclass(frozen=True, slots=True)
class PlaceErrors:
    """Errors of paths that belong to the place: cosines of each path itself, nothing where it rests.

    Attributes
    ----------
    columns
        Shape (n_receivers, n, n_cosines).
    kind
        Which variance each has, shape (n_receivers, n_cosines): longer than a wavelength, that all receivers share; of
        each receiver half to one, and a quarter to half.
    """

    columns: FloatArray
    kind: IntArray

    @staticmethod
    def of(samples: PathSamples, wavelength_m: float) -> PlaceErrors:
        """Return those of paths."""
        path, n_receivers = samples.change_m, samples.change_m.shape[0]
        low, high = np.minimum(path.min(axis=1), 0.0), np.maximum(path.max(axis=1), 0.0)
        reach = np.maximum(high - low, wavelength_m)
        order = np.arange(1 + int(np.ceil(2.0 * reach.max() / (PATHS.finest * wavelength_m))))
        angle, at_rest = np.pi * (path - low[:, None]) / reach[:, None], -np.pi * low / reach
        columns = np.cos(order * angle[..., None])
        # paths count from the rest; what is the same everywhere is the error of that zero
        columns[..., 1:] -= np.cos(order[1:] * at_rest[:, None])[:, None]
        waves = order * wavelength_m / (2.0 * reach[:, None])
        receiver = np.arange(n_receivers)[:, None]
        kind = np.where(waves < 1.0, 0, np.where(waves < 2.0, 1 + receiver, 1 + n_receivers + receiver))
        return PlaceErrors(columns, kind)


@dataclass(frozen=True, slots=True)
class FittedPaths:
    """Flights fitted to paths.

    Attributes
    ----------
    unknowns
        Of the setup.
    samples
        That were fitted.
    values
        As found: unknowns of the setup, then of the flights, shape (p,).
    information
        Of the samples alone about the unknowns but the onset, the errors of place marginalised, shape (m, m).
    prior
        Of what the flights share.
    weighed
        What the unknowns' information says of a change of each path, shape (n_receivers, m, n).
    """

    unknowns: SetupUnknowns
    samples: PathSamples
    values: FloatArray
    information: FloatArray
    prior: SharedPrior
    weighed: FloatArray

    @property
    def flights(self) -> Flights:
        """Where the sphere was."""
        return Flights.of(self.values[self.unknowns.size :])

    @property
    def gravity_place(self) -> int:
        """Where g stands among the unknowns but the onset."""
        return self.n_setup + FlightLayout(1).gravity - 1

    @property
    def drag_place(self) -> int:
        """Where k stands among them."""
        return self.n_setup + FlightLayout(1).drag - 1

    @property
    def n_setup(self) -> int:
        """How many unknowns of the setup there are."""
        return self.unknowns.size

    def precision(self, prior: SharedPrior) -> FloatArray:
        """Return the posterior's precision with a prior, shape (m, m)."""
        out, shared = self.information.copy(), _shared(self.unknowns.size) - _after_onset(self.unknowns.size)
        out[np.ix_(shared, shared)] += prior.precision
        return out

    def covariances(self) -> tuple[FloatArray, FloatArray]:
        """Return the covariance of the unknowns but the onset, and that with the setup held, shape (m, m) each."""
        return _parted(self.precision(self.prior), self.n_setup)

    def directions(self, covariance: FloatArray) -> FloatArray:
        """Return changes of the unknowns along independent directions in which the setup is open, (n_setup, m).

        With what is left where the setup is held they make up the covariance (m, m): C = H + sum of d d^T.
        """
        n = self.n_setup
        apart = covariance[:, :n]
        # of a block matrix: C - H = C_s C_ss^-1 C_s^T
        return np.asarray(apart @ np.linalg.cholesky(np.linalg.inv(apart[:n]))).T if n else np.zeros((0, len(apart)))

    def without_g(self) -> tuple[float, FloatArray, FloatArray]:
        """Return g with what was expected of it taken off again, covariance and that with the setup held, as above."""
        n, place = self.n_setup, _shared(self.n_setup) - _after_onset(self.n_setup)
        alone = self._without_g()
        covariance, held = _parted(self.precision(alone), n)
        away = np.zeros(len(covariance))
        # what held it at the expected g lets go
        away[place] = (self.prior.precision - alone.precision) @ (self.values[_shared(n)] - self.prior.mean)
        g = float(self.flights.g_m_s2) + float(covariance[self.gravity_place] @ away)
        return g, covariance, held

    def _without_g(self) -> SharedPrior:
        """Return what is known of what the flights share but g."""
        n, precision = self.n_setup, self.prior.precision.copy()
        precision[n], precision[:, n] = 0.0, 0.0
        # next to nothing: what the samples do not tell either stays invertible
        precision[n, n] = PATHS.max_u_g_m_s2**-2.0
        return SharedPrior(self.prior.mean, precision)

    def response(self, longer_m: FloatArray) -> tuple[FloatArray, float]:
        """Return what the unknowns but the onset, (m,), change by with the samples, (n_receivers, n).

        And g where nothing is expected of it.
        """
        pull = np.einsum("rmn,rn->m", self.weighed, longer_m)
        change, alone = (_inverse(self.precision(one)) @ pull for one in (self.prior, self._without_g()))
        return np.asarray(change), float(alone[self.gravity_place])

    def by_unknowns(self, by_flights: FloatArray) -> FloatArray:
        """Return derivatives by the unknowns but the onset, (..., m), of those by the flights' values."""
        nothing = np.zeros((*by_flights.shape[:-1], self.n_setup))
        return np.concatenate([nothing, by_flights[..., 1:]], axis=-1)

    def velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the velocities before and after each impact, (n_impacts, 6), and their derivatives, (..., m)."""
        flights = self.flights
        layout = flights.layout
        after = np.zeros((layout.n_flights - 1, 3, layout.size))
        for number, rows in enumerate(after, 1):
            rows[:, layout.velocity(number)] = np.eye(3)
        slopes = np.concatenate([flights.velocity_before_slopes(), after], axis=1)
        values = np.concatenate([flights.velocity_before_m_s(), flights.velocity_m_s[1:]], axis=1)
        return values, self.by_unknowns(slopes)

    def shared_posterior(self) -> SharedPrior:
        """Return what is known of what the flights share, for the flights after these."""
        place = _shared(self.n_setup) - _after_onset(self.n_setup)
        covariance = self.covariances()[0][np.ix_(place, place)]
        return SharedPrior(self.values[_shared(self.n_setup)], np.linalg.inv(covariance))

    def setup_posterior(self) -> SetupPosterior:
        """Return what the flights say of the setup."""
        n = self.n_setup
        covariance = self.covariances()[0][:n, :n]
        # the values are a deviation of one about what is stated
        found = self.values[:n]
        alone = SetupLikelihood.of_posterior(found, covariance, self.unknowns.deviation, n)
        return SetupPosterior(self.unknowns.inputs, self.unknowns.deviation, found, covariance, alone)


def _shared(n_setup: int) -> IntArray:
    """Return the places of the shared unknowns among all values."""
    layout = FlightLayout(1)
    return np.append(np.arange(n_setup), n_setup + np.array([layout.gravity, layout.drag, layout.slow]))


def _after_onset(n_setup: int) -> IntArray:
    """Return how many places less the shared unknowns have among those that are fitted: the onset is none."""
    return np.repeat(np.array([0, 1], dtype=np.intp), [n_setup, 3])


def _parted(precision: FloatArray, n_setup: int) -> tuple[FloatArray, FloatArray]:
    """Return the covariance of a precision (m, m), and that with the first n held."""
    covariance, held = _inverse(precision), np.zeros_like(precision)
    held[n_setup:, n_setup:] = _inverse(precision[n_setup:, n_setup:])
    return covariance, held


def _inverse(matrix: FloatArray) -> FloatArray:
    """Return the inverse of a symmetric matrix whose rows have their own units; one not positive has none."""
    diagonal = np.diagonal(matrix)
    if not (diagonal > 0.0).all():
        raise np.linalg.LinAlgError
    unit = 1.0 / np.sqrt(diagonal)
    scale = np.outer(unit, unit)
    return np.asarray(np.linalg.inv(matrix * scale) * scale)


def fit_paths(samples: PathSamples, start: Flights, model: PathModel, prior: SharedPrior) -> FittedPaths:
    """Fit flights, and what the setup leaves open, to paths.

    L_i + e_i(L_i) + white noise, e_i of `PlaceErrors` and marginalised; the variances of both are those of largest
    evidence by the fixed point of MacKay (Neural Computation 4, 415, 1992), v = sum c^2 / gamma, gamma = sum of
    1 - Var(c) / v, while flights and setup are marginalised, too. Residuals that are not white count as so many times
    fewer as they are correlated (GUM 4.2.7).

    Parameters
    ----------
    samples
        Of the flights.
    start
        About where the flights are; the first begins where the first sample is, at an onset that is held.
    model, prior
        Of the paths, and of what the flights share.

    Raises
    ------
    numpy.linalg.LinAlgError
        The samples do not determine them.
    """
    unknowns, errors = model.unknowns, PlaceErrors.of(samples, model.wavelength_m)
    n_receivers, n = samples.change_m.shape
    columns, kind = errors.columns, errors.kind
    rows = columns.swapaxes(1, 2)
    squares, diagonal = rows @ columns, np.arange(kind.shape[1])
    values = np.concatenate([np.zeros(unknowns.size), start.unknowns])
    shared = _shared(unknowns.size)
    values[shared] = prior.mean
    free = np.delete(np.arange(values.size), unknowns.size)
    known = np.zeros((values.size, values.size))
    known[np.ix_(shared, shared)] = prior.precision
    mean = np.zeros(values.size)
    mean[shared] = prior.mean
    known = known[np.ix_(free, free)]
    residual = samples.change_m
    wave, noise = np.full(1 + 2 * n_receivers, PATHS.first_wave_m**2), np.full(n_receivers, PATHS.first_noise_m**2)
    together = Stretches.between(samples.time_s, np.array([0]), np.array([n]))
    for turn in range(PATHS.turns):
        is_last = turn == PATHS.turns - 1
        if is_last:
            noise = noise * together.correlation_lengths(residual)[:, 0]
        expected, slopes = model.changes(values, samples.time_s)
        slopes, left = slopes[:, free], samples.change_m - expected
        crossed, projected = rows @ slopes.swapaxes(1, 2), (rows @ left[..., None])[..., 0]
        own, pulled = slopes @ slopes.swapaxes(1, 2), (slopes @ left[..., None])[..., 0]
        for _ in range(1 if is_last else PATHS.steps):
            # what cosines follow of flights has hidden part of them
            variance = wave[kind] * (PATHS.widened**2 if is_last else 1.0)
            curvature = squares / noise[:, None, None]
            curvature[:, diagonal, diagonal] += 1.0 / variance
            inverse = np.linalg.inv(curvature)
            across = crossed / noise[:, None, None]
            follow = inverse @ across
            information = (own / noise[:, None, None] - across.swapaxes(1, 2) @ follow).sum(axis=0)
            pull = pulled / noise[:, None] - (follow.swapaxes(1, 2) @ (projected / noise[:, None])[..., None])[..., 0]
            covariance = _inverse(information + known)
            step = covariance @ (pull.sum(axis=0) + known @ (mean - values)[free])
            if is_last:
                break
            apart = (projected / noise[:, None])[..., None] - across @ step[:, None]
            size = (inverse @ apart)[..., 0]
            spread = np.diagonal(inverse, axis1=1, axis2=2) + ((follow @ covariance) * follow).sum(axis=2)
            share = 1.0 - spread / variance
            residual = left - step @ slopes - (columns @ size[..., None])[..., 0]
            freedom = np.maximum(n - share.sum(axis=1) - free.size / n_receivers, PATHS.min_freedom * n)
            noise = np.maximum((residual**2).sum(axis=1) / freedom, PATHS.min_noise_m**2)
            counts, sums = (np.bincount(kind.ravel(), one.ravel(), wave.size) for one in (share, size**2))
            wave = np.maximum(sums / np.maximum(counts, PATHS.min_count), PATHS.min_noise_m**2)
        values[free] += step
    weighed = slopes / noise[:, None, None] - (follow.swapaxes(1, 2) @ rows) / noise[:, None, None]
    return FittedPaths(unknowns, samples, values, information, prior, weighed)
