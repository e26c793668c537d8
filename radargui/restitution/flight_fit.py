"""All flights of a run fitted together: common gravity and drag, neighbours meeting at the impacts.

Method 5, Flights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs

from radargui.estimation.posterior.flight_information import MotionInformation
from radargui.estimation.posterior.input_response import InputResponse
from radargui.estimation.posterior.motion_posterior import MotionPosterior
from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError
from radargui.restitution.flight_unknowns import FlightPlan, FlightUnknowns, UnknownLayout, impact_rows
from radargui.restitution.settings import FLIGHTS

Prior = tuple[FloatArray, FloatArray]
"""Means and weights of the unknowns, each (n,); a weight of zero: nothing is known."""
_MIN_PIVOT = 1e-6
"""Of the Cholesky factor of a system of unit diagonal: below it rounding may decide what a direction gets."""


@dataclass(frozen=True, slots=True)
class FlightInputs:
    """Inputs of the setup that are off by a, in their u: -ln L gets a^T s^T x + pull.a + a^T normal a / 2 besides.

    Attributes
    ----------
    slopes
        s, shape (n_x, n): by what they change the slope of -ln L.
    normal, pull
        Shapes (n, n) and (n,); `normal` with their own squares.
    """

    slopes: FloatArray
    normal: FloatArray
    pull: FloatArray

    @property
    def gained(self) -> float:
        """By how much they lessen chi-square."""
        return float(self.pull @ np.linalg.solve(self.normal, self.pull))


@dataclass(frozen=True, slots=True)
class FlightFit:
    """The fitted flights.

    Attributes
    ----------
    values, covariance
        Gravity, drag and what happened at the impacts between flights (`impact_rows`), and its covariance, shapes (n,)
        and (n, n).
    misfit
        Chi-square of the flights against the free motion, and its degrees of freedom.
    apex_s
        Times of the apexes, one a flight.
    first_begin_s, first_end_s
        Of the first flight, as far as it describes the motion.
    information, response
        What it was fitted to, and the derivative of `values` with respect to the slope of its -ln L.
    jacobian, normal
        J = dx/dq of its unknowns q, and N = J^T Lambda J + prior.
    off
        x of the flights less x of the free motion, shape (n,).
    """

    values: FloatArray
    covariance: FloatArray
    misfit: tuple[float, int]
    apex_s: FloatArray
    first_begin_s: float
    first_end_s: float
    information: MotionInformation = field(repr=False)
    response: FloatArray = field(repr=False)
    jacobian: FloatArray = field(repr=False)
    normal: FloatArray = field(repr=False)
    off: FloatArray = field(repr=False)

    @property
    def g_m_s2(self) -> float:
        """Common gravity."""
        return float(self.values[0])

    @property
    def drag_1_m(self) -> float:
        """Common drag k of a = k v^2."""
        return float(self.values[1])

    @property
    def u_g_m_s2(self) -> float:
        """Standard uncertainty of g from noise and fit."""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def impact_s(self) -> FloatArray:
        """Times of the impacts between flights, shape (n_impacts,)."""
        return impact_rows(self.values)[:, 0]

    @property
    def before_m_s(self) -> FloatArray:
        """Velocities just before the impacts, shape (n_impacts, 3)."""
        return impact_rows(self.values)[:, 1:4]

    @property
    def after_m_s(self) -> FloatArray:
        """Velocities just after the impacts, shape (n_impacts, 3)."""
        return impact_rows(self.values)[:, 4:]

    @property
    def reduced_misfit(self) -> float:
        """Chi-square of the flights over its degrees of freedom."""
        return self.misfit[0] / self.misfit[1]

    @property
    def is_determined(self) -> bool:
        """Whether the samples determine the flights: a form that is positive makes no misfit below zero.

        What the mismatch costs and the smoothness that is lifted are taken off a band. Where that leaves nothing the
        difference has directions of negative curvature, along which any flight fits.
        """
        # rounding makes a small negative misfit of zero
        return self.misfit[0] > -FLIGHTS.slack

    @property
    def is_good(self) -> bool:
        """Whether the flights obey the equation of free flight within what the samples say."""
        return self.is_determined and self.misfit[0] < FLIGHTS.good_misfit * self.misfit[1] + FLIGHTS.slack

    def widened(self) -> FlightFit:
        """Return the fit with its covariance widened by the reduced misfit, where that is above one."""
        # Birge's ratio, never below one: a good fit by chance makes no measurement better
        return replace(self, covariance=self.covariance * max(1.0, self.reduced_misfit))

    @property
    def velocity_covariances(self) -> FloatArray:
        """Covariances of (before x, y, z, after x, y, z) at the impacts, shape (n_impacts, 6, 6)."""
        own = np.arange(self.impact_s.size)
        return self.covariance[2:, 2:].reshape(own.size, 7, own.size, 7)[own, 1:, own, 1:]

    def follow(self, response: InputResponse) -> FloatArray:
        """Return the changes of `values`, (n,), where an input of the estimate changes.

        The flights minimise -ln L(x(q)) + prior. A change s of its slope, all else marginalised, moves them by
        dq = -N^-1 J^T s with J = dx/dq, N = J^T Lambda J + prior: gravity, drag and impacts share it as they share the
        samples.
        """
        return np.asarray(self.response @ self.information.eliminated.marginal(response.slope))

    def bends(self, responses: Sequence[InputResponse]) -> FloatArray:
        """Return the chi-square that each of some changes of the inputs gives these flights, shape (n,)."""
        return np.diag(self.against(responses)[0]) if responses else np.zeros(0)

    def against(self, responses: Sequence[InputResponse]) -> tuple[FloatArray, FloatArray]:
        """Return B (n, n) and c (n,) of the misfit, chi-square + 2 c.a + a^T B a, where inputs change by a.

        A change s of the slope moves the free motion by -Lambda^-1 s and the flights by -J N^-1 J^T s, which parts
        them by d = Lambda^-1 s - J N^-1 J^T s: B = d^T Lambda d = s^T Lambda^-1 s - s^T J N^-1 J^T s. What parts them
        already is across the flights, and c = d^T Lambda away = s^T away.
        """
        s = self._slopes(responses)
        along = self.jacobian.T @ s
        away = self.off - self.information.minimum()
        return s.T @ self.information.form.solve(s) - along.T @ _solve(self.normal, along), s.T @ away

    def _slopes(self, responses: Sequence[InputResponse]) -> FloatArray:
        eliminated = self.information.eliminated
        return np.column_stack([eliminated.marginal(one.slope) for one in responses])

    def inputs(self, responses: Sequence[InputResponse], weights: FloatArray) -> FlightInputs | None:
        """Return what `displaced_after` leaves open beside the flights; None of no inputs.

        Parameters
        ----------
        responses, weights
            Of inputs, and of their own squares in chi-square, shape (n,).
        """
        if not responses:
            return None
        cost, pull = self.against(responses)
        return FlightInputs(self._slopes(responses), cost + np.diag(weights), pull)

    def displaced_after(
        self, number: int, along: FloatArray, inputs: FlightInputs | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Return slope and curvature of -ln L where all after an impact is displaced, the flights marginalised.

        Parameters
        ----------
        number
            Of the impact.
        along
            Unit vectors, shape (m, 3): the slope has shape (m,), the curvature (m, m).
        inputs
            Of the setup, which are marginalised, too: where they are off, flights miss each other.
        """
        information, form = self.information, self.information.form
        # the place at the break is the first of what follows; x leaves out the coefficient at the start
        first = information.free.segments[number].stop_coefficient - 2
        shifted = np.zeros((along.shape[0], information.x0.size))
        shifted[:, 3 * first : 3 * information.size] = np.tile(along, information.size - first)
        curvature = form.times(shifted.T)
        by_flights = self.jacobian.T @ curvature
        slope = curvature.T @ (self.off - information.minimum())
        curvature = shifted @ curvature - by_flights.T @ _solve(self.normal, by_flights)
        if inputs is None:
            return slope, curvature
        across = shifted @ inputs.slopes
        across -= by_flights.T @ _solve(self.normal, self.jacobian.T @ inputs.slopes)
        followed = np.linalg.solve(inputs.normal, np.column_stack([inputs.pull, across.T]))
        return slope - across @ followed[:, 0], curvature - across @ followed[:, 1:]

    def bend_over_u(self, time_s: FloatArray, u_position_m: FloatArray) -> float:
        """Return how far the free motion is off its flights over u (3, n) at the same times, both root mean square."""
        free, size = self.information.free, self.information.size
        spline, breaks = free.motion.spline, self.off[3 * size :]
        inside = (time_s > free.edge_s[0]) & (time_s < free.edge_s[self.impact_s.size + 1])
        coefficients = np.zeros_like(free.motion.coefficients)
        coefficients[:size] = self.off[: 3 * size].reshape(-1, 3)
        # knots move with the breaks: coefficients alone say nothing of the same instant
        by_breaks = spline.break_slopes(time_s[inside], free.motion.coefficients)[:, : breaks.size] @ breaks
        off = spline.offset(time_s[inside], coefficients) + by_breaks.reshape(-1, 3)
        return float(np.sqrt((off**2).mean() / (u_position_m[:, inside] ** 2).mean()))

    def excess(self, explained: FloatArray) -> float:
        """Return by how many standard deviations chi-square is above what noise and some changes of inputs explain.

        Each of `explained` is the mean of a square of one Gaussian number, which scatters by sqrt(2) of itself.
        """
        value, expected = self.misfit
        scatter = np.sqrt(2.0 * (expected + float((explained**2).sum())))
        return float((value - expected - explained.sum()) / scatter)


def first_by_flights(before: FloatArray, after: FloatArray, results: FloatArray | None) -> FloatArray:
    """Return velocities before and after all breaks, (2, n_breaks, 3), those that flights determined by their results.

    The flights are the first ones: their slopes know g, a spline's at its end only its neighbourhood.
    """
    out = np.array([before, after])
    if results is not None:
        rows = impact_rows(results)
        out[:, : len(rows)] = rows[:, 1:4], rows[:, 4:]
    return out


def break_velocities(posterior: MotionPosterior, fit: FlightFit | None) -> FloatArray:
    """Return the velocities just before and just after all breaks of a motion, shape (2, n_breaks, 3)."""
    breaks = posterior.breaks
    return first_by_flights(breaks.before_m_s, breaks.after_m_s, None if fit is None else fit.values)


def fit_flights(information: MotionInformation, plan: FlightPlan) -> FlightFit:
    """Fit gravity, drag, flights and impact times by generalised least squares on the motion's information.

    Neighbouring flights meet at their impact by construction, so that the impact's time follows from both. The drag
    has the prior that the motion was estimated with.

    Parameters
    ----------
    information
        Of the plan, the smoothness prior lifted from the flights' spans.
    plan
        Which segments are flights.

    Raises
    ------
    SolveError
        The flights' equations have no solution.
    """
    unknowns = FlightUnknowns(information, plan)
    # the spline follows the flights closely: the start lies in the right basin
    q = unknowns.start()
    mean, weight = np.zeros((2, q.size))
    # without it, one short fall trades k against g: both accelerate downwards
    mean[UnknownLayout.drag], weight[UnknownLayout.drag] = unknowns.drag.k_1_m, unknowns.drag.u_k_1_m**-2.0
    prior = mean, weight
    cost, damping = _cost(unknowns, q, prior), 0.0
    normal, slope = _normal_equations(unknowns, q, prior)
    for _ in range(FLIGHTS.steps):
        # Levenberg's damping in Marquardt's scale: unknowns are seconds, metres and 1/m
        trial = q - _solve(normal + damping * np.diag(np.diag(normal)), slope)
        # outside, the drag's series diverges or flights run backwards: such a step is none
        trial_cost = _cost(unknowns, trial, prior) if _sensible(unknowns, trial) else np.inf
        if trial_cost < cost:
            gained, q, cost = cost - trial_cost, trial, trial_cost
            normal, slope = _normal_equations(unknowns, q, prior)
            # the form is nearly quadratic: damping is for an impact time that is far off
            damping /= 10.0
            if gained < FLIGHTS.enough:
                break
        else:
            damping = max(10.0 * damping, 1e-6)
    return _result(unknowns, q, normal)


def _normal_equations(unknowns: FlightUnknowns, q: FloatArray, prior: Prior) -> tuple[FloatArray, FloatArray]:
    """Return J^T Lambda J + prior, and the slope of the cost."""
    information, (mean, weight) = unknowns.information, prior
    jacobian = unknowns.slopes(q).x
    # the slope of -ln L at x(q), by the chain rule pulled back to q
    pull = information.form.times(unknowns.motion(q).x - information.x0) + information.slope
    return jacobian.T @ information.form.times(jacobian) + np.diag(weight), jacobian.T @ pull + weight * (q - mean)


def _cost(unknowns: FlightUnknowns, q: FloatArray, prior: Prior) -> float:
    information, (mean, weight) = unknowns.information, prior
    offset = unknowns.motion(q).x - information.x0
    of_data = 0.5 * offset @ information.form.times(offset) + information.slope @ offset
    return float(of_data + 0.5 * weight @ (q - mean) ** 2)


def _sensible(unknowns: FlightUnknowns, q: FloatArray) -> bool:
    layout, (least, most) = unknowns.layout, FLIGHTS.least_and_most_g
    rising = (np.diff(unknowns.edges(q)) > FLIGHTS.min_flight_s).all()
    times_g = q[layout.gravity] / unknowns.information.free.gravity_m_s2
    return bool(rising and least < times_g < most and abs(q[layout.drag]) < FLIGHTS.drag_1_m)


def _result(unknowns: FlightUnknowns, q: FloatArray, normal: FloatArray) -> FlightFit:
    information = unknowns.information
    motion, slopes = unknowns.motion(q), unknowns.slopes(q)
    # results by their slopes, not by inverting all unknowns: the coefficients left free are many
    inverse = _solve(normal, slopes.results.T)
    # against the minimum of the same form: the difference is chi-square of the constraint (method 5, Flights)
    off = motion.x - information.x0
    away = off - information.minimum()
    misfit = (float(away @ information.form.times(away)), information.x0.size - q.size)
    end_s = unknowns.last_s(0) if motion.results.size == 2 else float(motion.results[2])
    covariance, response, apex_s = slopes.results @ inverse, -(slopes.x @ inverse).T, unknowns.apexes(q)
    values, begin_s, jacobian = motion.results, unknowns.first_s, slopes.x
    return FlightFit(values, covariance, misfit, apex_s, begin_s, end_s, information, response, jacobian, normal, off)


def _solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a symmetric system whose unknowns have very different sizes."""
    # to a unit diagonal: 1/m beside seconds would cost digits
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * scale[:, None] * scale[None]
    tail = (slice(None),) + (None,) * (right.ndim - 1)
    factor, bad = dpotrf(scaled, lower=1)
    if not bad and float(np.diag(factor).min()) > _MIN_PIVOT:
        return np.asarray(scale[tail] * dpotrs(factor, scale[tail] * right, lower=1)[0])
    try:
        # what was lifted may leave a direction that no sample determines
        solved = np.linalg.lstsq(scaled, scale[tail] * right, rcond=1e-15)[0]
    except np.linalg.LinAlgError as error:
        raise SolveError("The equations of the flights have no solution.") from error
    return np.asarray(scale[tail] * solved)
