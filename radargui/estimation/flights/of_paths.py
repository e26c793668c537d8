"""Flights fitted to path lengths, with antennas, release and wavelength as unknowns within their u (method 5, Flights).

L_i(t) = (|p(t) - tx| + |p(t) - rx_i| - the same at the release) K / K_stated + noise, p(t) a chain of free flights.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.flights.path_noise import NoiseModel, PathNoise
from radargui.estimation.forward.setup_unknowns import SetupUnknowns
from radargui.geometry.path_length import Antennas, path_gradient, path_lengths, place_antennas
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.gravity import drag_of_sphere_1_m
from radargui.model.radar import Tracer
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupPosterior
from radargui.motion.flights import Flights


@dataclass(frozen=True, slots=True)
class PathFlightSettings:
    """How flights are fitted to path lengths.

    Attributes
    ----------
    position_m, velocity_m_s, time_s
        Prior deviations of where the first flight begins, of each flight's velocity, and of the impacts: next to none.
    least_u_g_m_s2
        Of a g that is called exact: what the paths say of it can then still be told.
    drag_share, drag_1_m
        Prior deviation of the drag of a sphere of known density, relative; of another.
    steps, enough, rounds
        Gauss-Newton steps between two renewals of the noise, at most; a step that gains less in chi-square is the last;
        renewals.
    most_damping
        A step that needs more goes nowhere.
    g_m_s2, drag_1_m_most, flight_s
        Least and most g, largest drag and shortest flight that a step may try: outside the series of the drag diverges.
    """

    position_m: float = 0.1
    velocity_m_s: float = 10.0
    time_s: float = 0.1
    least_u_g_m_s2: float = 1e-4
    drag_share: float = 0.3
    drag_1_m: float = 0.04
    steps: int = 10
    enough: float = 0.05
    rounds: int = 2
    most_damping: float = 1e6
    g_m_s2: tuple[float, float] = (5.0, 15.0)
    drag_1_m_most: float = 2.0
    flight_s: float = 1e-3


PATH_FLIGHTS = PathFlightSettings()
FAR = 1e5
"""Times which antennas are away where waves are taken as plane: what is left of their curvature is rounding."""


@dataclass(frozen=True, eq=False)
class PathData:
    """Path lengths within flights.

    Attributes
    ----------
    time_s
        Middles of the means, increasing, shape (n,).
    change_m
        Since the release, shape (n_receivers, n).
    flight
        To which flight each belongs, shape (n,).
    position_m
        About where the body was, shape (3, n).
    added_m
        What the sphere may add to the paths, in independent parts of one standard uncertainty, (n_parts, n_receivers,
        n).
    """

    time_s: FloatArray
    change_m: FloatArray
    flight: IntArray
    position_m: FloatArray
    added_m: FloatArray


@dataclass(frozen=True, eq=False)
class PathSetup:
    """What the setup's unknowns, in their u, make of the path lengths of places.

    Attributes
    ----------
    unknowns
        Antennas, release and wavelength.
    antennas, release_m
        As stated.
    """

    unknowns: SetupUnknowns
    antennas: Antennas
    release_m: FloatArray

    @staticmethod
    def of(setup: Setup) -> PathSetup:
        """Return that of a setup."""
        antennas, unknowns = place_antennas(setup), SetupUnknowns.of(setup)
        if setup.processing.geometry == "plane":
            antennas = Antennas(FAR * antennas.transmitter_m, FAR * antennas.receivers_m)
            unknowns = replace(unknowns, by_antenna=FAR * unknowns.by_antenna)
        return PathSetup(unknowns, antennas, np.array(setup.tracer.release_position_m))

    def change_m(self, by: FloatArray, place_m: FloatArray) -> FloatArray:
        """Return the measured changes of path since the release, (n_receivers, n), at unknowns and places (3, n)."""
        antennas, release = self._moved(by)
        change = path_lengths(place_m, antennas) - path_lengths(release[:, None], antennas)
        return np.asarray(change * self._scale(by))

    def gradient(self, by: FloatArray, place_m: FloatArray) -> FloatArray:
        """Return the derivatives of the changes by the place, shape (n_receivers, 3, n)."""
        return np.asarray(path_gradient(place_m, self._moved(by)[0]) * self._scale(by))

    def by_unknowns(self, by: FloatArray, place_m: FloatArray) -> FloatArray:
        """Return the derivatives of the changes by the unknowns, shape (n_receivers, n, n_unknowns)."""
        (antennas, release), own = self._moved(by), self.unknowns
        at_rest = path_gradient(release[:, None], antennas)[..., 0] @ own.by_release
        sent = _turned(antennas.transmitter_m, place_m, release).T @ own.by_antenna[0]
        got = [
            _turned(antenna, place_m, release).T @ moved
            for antenna, moved in zip(antennas.receivers_m, own.by_antenna[1:], strict=True)
        ]
        longer = (sent + np.stack(got) - at_rest[:, None]) * self._scale(by)
        return np.asarray(longer + self.change_m(by, place_m)[..., None] * own.by_log_wavenumber)

    def _moved(self, by: FloatArray) -> tuple[Antennas, FloatArray]:
        return self.unknowns.antennas(self.antennas, by), self.release_m + self.unknowns.by_release @ by

    def _scale(self, by: FloatArray) -> float:
        return float(np.exp(self.unknowns.by_log_wavenumber @ by))


def _turned(antenna_m: FloatArray, place_m: FloatArray, release_m: FloatArray) -> FloatArray:
    """Return what a change of path is changed by where an antenna moves, shape (3, n)."""
    away, rest = antenna_m[:, None] - place_m, antenna_m - release_m
    return np.asarray(away / np.linalg.norm(away, axis=0) - (rest / np.linalg.norm(rest))[:, None])


@dataclass(frozen=True, eq=False)
class PathModel:
    """What path lengths are by the unknowns: the setup's, in their u; the sphere's parts; the flights' free values.

    Attributes
    ----------
    setup
        Of its unknowns.
    mean, deviation
        Of the flights' values (`FlightLayout`); what has no deviation is held.
    data
        That it is compared with.
    """

    setup: PathSetup
    mean: FloatArray
    deviation: FloatArray
    data: PathData

    @staticmethod
    def of(paths: PathSetup, tracer: Tracer, start: Flights, data: PathData) -> PathModel:
        """Return the model that begins with some flights, of a setup and its sphere."""
        own, layout = PATH_FLIGHTS, start.layout
        drag = drag_of_sphere_1_m(tracer.diameter_m, tracer.density_kg_m3)
        is_known = tracer.density_kg_m3 is not None
        mean, deviation = start.unknowns.copy(), np.zeros(layout.size)
        mean[layout.gravity] = paths.unknowns.gravity_m_s2
        deviation[layout.gravity] = max(paths.unknowns.u_gravity_m_s2, own.least_u_g_m_s2)
        mean[layout.drag], deviation[layout.drag] = drag, own.drag_share * drag if is_known else own.drag_1_m
        deviation[layout.start], deviation[layout.impacts] = own.position_m, own.time_s
        deviation[layout.drag + 1 : layout.impacts.start] = own.velocity_m_s
        return PathModel(paths, mean, deviation, data)

    @property
    def stated(self) -> slice:
        """Places of the setup's unknowns."""
        return slice(0, self.setup.unknowns.size)

    @property
    def sphere(self) -> slice:
        """Places of the sphere's parts; the flights' unknowns follow them."""
        return slice(self.stated.stop, self.stated.stop + len(self.data.added_m))

    @property
    def free(self) -> IntArray:
        """Which values of the flights are unknown."""
        return np.flatnonzero(self.deviation)

    @property
    def gravity(self) -> int:
        """Place of g."""
        place = Flights.of(self.mean).layout.gravity
        return int(self.sphere.stop + np.flatnonzero(self.free == place)[0])

    @property
    def precision(self) -> FloatArray:
        """Of the priors, shape (n,)."""
        others = np.ones(len(self.data.added_m) + self.free.size)
        return np.concatenate([self.setup.unknowns.deviation**-2.0, others])

    def flights(self, at: FloatArray) -> Flights:
        """Return the flights of unknowns (n,)."""
        values = self.mean.copy()
        values[self.free] += self.deviation[self.free] * at[self.sphere.stop :]
        return Flights.of(values)

    def by_unknowns(self, by_flights: FloatArray) -> FloatArray:
        """Return derivatives by the unknowns, (..., n), of those by the flights' values, (..., n_values)."""
        by_free = by_flights[..., self.free] * self.deviation[self.free]
        return np.concatenate([np.zeros((*by_flights.shape[:-1], self.sphere.stop)), by_free], axis=-1)

    def residual_m(self, at: FloatArray) -> FloatArray:
        """Return measured less modelled paths at unknowns (n,), shape (n_receivers, n_times)."""
        modelled = self.setup.change_m(at[self.stated], self.flights(at).position_m(self.data.time_s))
        return np.asarray(self.data.change_m - modelled - np.tensordot(at[self.sphere], self.data.added_m, 1))

    def slopes(self, at: FloatArray) -> FloatArray:
        """Return the derivatives of the paths by the unknowns, shape (n_receivers, n_times, n)."""
        place, by_flights = self.flights(at).position_and_slopes(self.data.time_s)
        by_place = np.moveaxis(by_flights[self.free] * self.deviation[self.free, None, None], 0, -1)
        return np.concatenate(
            [
                self.setup.by_unknowns(at[self.stated], place),
                np.moveaxis(self.data.added_m, 0, -1),
                np.einsum("ran,anu->rnu", self.setup.gradient(at[self.stated], place), by_place, optimize=True),
            ],
            axis=-1,
        )


@dataclass(frozen=True, eq=False)
class PathFlights:
    """Flights of a track with their posterior.

    Attributes
    ----------
    model, at
        With its unknowns where chi-square is least.
    fitted, end_s
        Which flights bear upon it, shape (n_flights,), and when the last one ends.
    noise
        Which the residuals show.
    matrix
        Inverse covariance of the unknowns, their priors included, shape (n, n).
    goes_on
        Whether somebody dropped the body again after the last flight.
    """

    model: PathModel
    at: FloatArray
    fitted: BoolArray
    end_s: float
    noise: PathNoise
    matrix: FloatArray
    goes_on: bool = False

    @property
    def flights(self) -> Flights:
        """Where the sphere was."""
        return self.model.flights(self.at)

    @property
    def residual_m(self) -> FloatArray:
        """Shape (n_receivers, n_times)."""
        return self.model.residual_m(self.at)

    @property
    def covariance(self) -> FloatArray:
        """Of the unknowns, shape (n, n)."""
        return np.asarray(np.linalg.inv(self.matrix))

    @property
    def held(self) -> FloatArray:
        """The same with setup and sphere held."""
        return _without(self.matrix, np.arange(self.model.sphere.stop))

    @property
    def posterior(self) -> SetupPosterior:
        """What the paths say of the setup."""
        own, part = self.model.setup.unknowns, self.model.stated
        return SetupPosterior(own.inputs, own.deviation, self.at[part], self.covariance[part, part])

    def directions(self, *, prior_of_g: bool = True) -> tuple[FloatArray, FloatArray]:
        """Return independent directions in which setup and sphere leave the unknowns open, each (n_directions, n).

        The setup's with the sphere held, and those that the sphere adds: covariance = held + sum of d d^T of both.
        Without `prior_of_g` nothing is known of g but what the paths say.
        """
        matrix, sphere, stated = (
            self.matrix if prior_of_g else self._without_prior_of_g,
            self.model.sphere,
            self.model.stated,
        )
        # what is called exact may show that it is wrong, but leaves nothing open
        exact = np.flatnonzero(self.model.setup.unknowns.deviation < 1.0)
        beside, every = _without(matrix, np.r_[exact, sphere]), _without(matrix, exact)
        return _directions(beside, np.delete(np.r_[stated], exact)), _directions(every, np.r_[sphere])

    @property
    def gravity(self) -> tuple[float, float]:
        """Acceleration g and its statistical u, m/s^2, with the prior of g taken off again."""
        place, unit = self.model.gravity, float(self.model.deviation[4])
        # the slope of chi-square was zero with the prior, whose pull is what is missing now
        g = float(self.flights.g_m_s2) + unit * float(
            np.linalg.inv(self._without_prior_of_g)[place, place] * self.at[place]
        )
        statistical = _without(self._without_prior_of_g, np.arange(self.model.sphere.stop))[place, place]
        return g, float(unit * np.sqrt(statistical))

    @property
    def drag(self) -> tuple[float, float]:
        """K of the sphere and its u, 1/m; what is known of it beforehand counts."""
        place = self.model.gravity + 1
        return self.flights.drag_1_m, float(self.model.deviation[5] * np.sqrt(self.covariance[place, place]))

    @property
    def _without_prior_of_g(self) -> FloatArray:
        out = self.matrix.copy()
        # not quite: of a fall too short to tell it g would be anything
        out[self.model.gravity, self.model.gravity] -= 1.0 - 1e-6
        return out

    def impact_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the velocities before and after each impact, (n_impacts, 6), and their derivatives by the unknowns."""
        values, slopes = self.flights.impact_velocities()
        return values, self.model.by_unknowns(slopes)


def _without(matrix: FloatArray, part: IntArray) -> FloatArray:
    """Return the covariance of what an inverse covariance leaves where some unknowns are held; theirs is zero."""
    kept = np.delete(np.arange(len(matrix)), part)
    out = np.zeros_like(matrix)
    out[np.ix_(kept, kept)] = np.linalg.inv(matrix[np.ix_(kept, kept)])
    return out


def _directions(covariance: FloatArray, part: IntArray) -> FloatArray:
    """Return independent directions in which some unknowns leave all open: C_s C_ss^-1 C_s^T = sum of d d^T."""
    own = covariance[np.ix_(part, part)]
    root = np.linalg.cholesky(np.linalg.inv(own)) if own.size else own
    return np.asarray((covariance[:, part] @ root).T)


def fit_paths(model: PathModel, fitted: BoolArray, end_s: float, noise: PathNoise | None = None) -> PathFlights | None:
    """Fit flights and the setup to path lengths; None where their equations have no solution.

    Parameters
    ----------
    model
        Begun at its mean.
    fitted, end_s
        Which flights hold data, and when the last one ends.
    noise
        To begin with; None: as the start leaves it.
    """
    at = np.zeros(model.sphere.stop + model.free.size)
    likelihood = NoiseModel(model.data.position_m, model.data.flight)
    try:
        is_settled = noise is not None
        if noise is None:
            noise = likelihood.fitted(model.residual_m(at), model.slopes(at), model.precision, None, is_settled=True)
        for _ in range(PATH_FLIGHTS.rounds):
            at = _minimised(model, at, likelihood, noise)
            residual, slopes = model.residual_m(at), model.slopes(at)
            noise = likelihood.fitted(residual, slopes, model.precision, noise, is_settled=is_settled)
            is_settled = True
        matrix, _ = likelihood.normal(noise, slopes, residual)
        found = PathFlights(model, at, fitted, end_s, noise, matrix + np.diag(model.precision))
        # unknowns that nothing determines have no directions
        found.directions()
    except np.linalg.LinAlgError:
        return None
    return found


def _minimised(model: PathModel, at: FloatArray, likelihood: NoiseModel, noise: PathNoise) -> FloatArray:
    """Return the unknowns of least chi-square by damped Gauss-Newton (Marquardt 1963)."""

    def cost(of: FloatArray) -> float:
        return likelihood.chi_square(noise, model.residual_m(of)) + float(model.precision @ of**2)

    damping, before = 0.0, cost(at)
    for _ in range(PATH_FLIGHTS.steps):
        matrix, pull = likelihood.normal(noise, model.slopes(at), model.residual_m(at))
        matrix, pull = matrix + np.diag(model.precision), pull - model.precision * at
        gained = 0.0
        while damping < PATH_FLIGHTS.most_damping:
            step = np.linalg.solve(matrix + damping * np.diag(np.diag(matrix)), pull)
            if _is_possible(model.flights(at + step)) and (now := cost(at + step)) < before:
                at, gained, before = at + step, before - now, now
                damping = damping / 10.0 if damping > 1e-4 else 0.0
                break
            if float(pull @ step) < PATH_FLIGHTS.enough:
                break
            damping = max(10.0 * damping, 1e-3)
        if gained < PATH_FLIGHTS.enough:
            break
    return at


def _is_possible(flights: Flights) -> bool:
    """Whether the impacts are in order and the series of the drag holds."""
    own, (least, most) = PATH_FLIGHTS, PATH_FLIGHTS.g_m_s2
    in_order = (np.diff(flights.begin_s) > own.flight_s).all()
    return bool(in_order and least < flights.g_m_s2 < most and abs(flights.drag_1_m) < own.drag_1_m_most)
