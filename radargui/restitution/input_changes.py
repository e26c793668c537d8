"""What position, e and g of a joint estimate change by where an input of the setup is off by its uncertainty.

Method 6, Flights that bend.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.joint import JointEstimate
from radargui.estimation.posterior.input_response import InputResponse, moved_inputs, possible_spheres
from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, OF_SPHERE, TILT, uncertain_inputs, usual_u
from radargui.model.finding import Finding, warn
from radargui.model.gravity import expected_gravity
from radargui.model.result import Bounces
from radargui.model.setup import Setup
from radargui.model.setup_posterior import EXACT, SetupLikelihood, SetupPosterior
from radargui.model.uncertainty_budget import InputChange, Share
from radargui.restitution.flight_fit import FlightFit, FlightInputs, break_velocities, first_by_flights
from radargui.restitution.flight_test import FlightTest
from radargui.restitution.settings import FLIGHTS
from radargui.restitution.setup_chi_square import SetupChiSquare
from radargui.restitution.setup_outlier import setup_outlier
from radargui.restitution.track_response import tilt_and_clock

INSTANTS = 8000
"""At which shifts are kept, over the whole record: each is a curve of its own, and there are two dozens."""
SPHERE = "sphere"


@dataclass(frozen=True, slots=True)
class SetupResponses:
    """How the estimate follows each uncertain input of the setup.

    Attributes
    ----------
    time_s
        Where shifts are kept.
    keys, each
        The inputs, "sphere" for each sphere that is possible where no polarisation is given, and the responses.
    exact
        Inputs that the setup calls exact, their responses those to what a laboratory knows them to: they have no part
        in any uncertainty, but may be wrong.
    found
        What the estimate says of antennas, release and wave; None where nothing of them was unknown.
    """

    time_s: FloatArray
    keys: tuple[str, ...]
    each: tuple[InputResponse, ...]
    exact: frozenset[str] = frozenset()
    found: SetupPosterior | None = None

    @property
    def at(self) -> FloatArray:
        """Where the inputs stand in the estimate, in their u from what is stated, shape (n,)."""
        found = (
            {}
            if self.found is None
            else dict(zip((one.key for one in self.found.inputs), self.found.mean, strict=True))
        )
        return np.array([found.get(key, 0.0) for key in self.keys])

    @property
    def covariance(self) -> FloatArray:
        """Of the inputs as the estimate has them, each within its own u where it says nothing of them, shape (n, n)."""
        out = np.diag(1.0 / self.weights)
        if self.found is not None:
            places = [self.keys.index(one.key) for one in self.found.inputs]
            out[np.ix_(places, places)] = self.found.covariance
        return out

    @property
    def others(self) -> SetupLikelihood:
        """What other runs say of the inputs."""
        n = len(self.keys)
        matrix, vector = np.zeros((n, n)), np.zeros(n)
        if self.found is not None and self.found.others is not None:
            places = [self.keys.index(one.key) for one in self.found.inputs]
            matrix[np.ix_(places, places)], vector[places] = self.found.others.matrix, self.found.others.vector
        return SetupLikelihood(matrix, vector)

    @property
    def n_spheres(self) -> int:
        """How many spheres are possible: of them only one is there."""
        return self.keys.count(SPHERE)

    @property
    def weights(self) -> FloatArray:
        """Of the inputs' own squares, shape (n,): of n possible spheres only one is there."""
        return np.array([EXACT**-2.0 if key in self.exact else float(self.keys.count(key)) for key in self.keys])

    def bias_deviations(self) -> FloatArray:
        """Return the deviation that the inputs leave to each receiver's bias maps, shape (n_receivers,)."""
        if not self.each:
            return np.zeros(1)
        return np.asarray(np.sqrt(np.diag(self.covariance) @ np.array([one.bias for one in self.each]) ** 2))

    def floor_covariance(self) -> FloatArray:
        """Return the covariance that the inputs leave to the slope of the floor that reflects, shape (2, 2)."""
        slopes = np.array([one.floor_slope for one in self.each]).reshape(-1, 2)
        return np.asarray(slopes.T @ self.covariance @ slopes)

    def beside(self, fit: FlightFit) -> FlightInputs | None:
        """Return the inputs as what flights leave open, each within its u of what is stated; None without any."""
        inputs = fit.inputs(self.each, self.weights)
        if inputs is None:
            return None
        others, at = self.others, self.at
        pull = inputs.pull + self.weights * at + others.matrix @ at - others.vector
        return replace(inputs, normal=inputs.normal + others.matrix, pull=pull)


def setup_responses(estimate: JointEstimate, setup: Setup) -> SetupResponses:
    """Return how the estimate follows the uncertain inputs of the setup it was made with.

    Where no polarisation is given the sphere counts as a point: then the responses to conducting spheres of this
    diameter are added, over the transmitter's directions.
    """
    posterior = estimate.posterior
    # the motion has polarisations as unknowns, and does not depend on the floor and the clock
    stated, found = uncertain_inputs(setup), estimate.chosen.setup
    if found is not None:
        setup = found.applied(setup)
    exact = frozenset(one.key for one in stated if one.u == 0.0 and one.key not in OF_SPHERE)
    asked = [
        (one.key, moved_inputs(setup, one))
        for one in (replace(one, u=usual_u(one)) if one.key in exact else one for one in stated)
        if one.u > 0.0
        and one.key not in (TILT, CLOCK)
        and not one.key.endswith("polarization_deg")
        and not (one.key in OF_SPHERE and posterior.is_point)
    ]
    if posterior.is_point:
        asked += [(SPHERE, other) for other in possible_spheres(setup)]
    # shifts are smooth: so many instants say all
    time_s = estimate.time_s[:: max(1, estimate.time_s.size // INSTANTS)]
    each = posterior.responses([other for _, other in asked], time_s)
    return SetupResponses(time_s, tuple(key for key, _ in asked), each, exact, found)


def joint_changes(
    estimate: JointEstimate, bounces: Bounces, fit: FlightFit | None, setup: Setup, responses: SetupResponses
) -> tuple[Bounces, tuple[InputChange, ...], FlightTest]:
    """Return the change with each uncertain input of the setup, carried by the estimate's own equations (method 6).

    And whether the flights bend as neither the noise nor these inputs can make them. A reflector that no model tried
    has bends the motion and leaves chi-square at one: the maps and the motion explain it. But a body in the air cannot
    bend, and the free motion against its flights is a test that nothing was fitted to.

    Parameters
    ----------
    estimate, bounces, fit
        Of the run; None where no flight was fitted.
    setup, responses
        What it was estimated with, and how it follows that.
    """
    time_s, outlier = responses.time_s, None
    unexplained = 0.0 if fit is None else fit.excess(np.zeros(0))
    posterior = of_g = responses.covariance
    if fit is not None and responses.keys:
        chi_square = SetupChiSquare.of(fit, responses.each, responses.weights, responses.at, setup)
        outlier = setup_outlier(chi_square, responses.keys, setup)
        wrong = np.array([outlier is not None and key in outlier.off for key in responses.keys])
        # what the estimate was told of g is no result
        alone = chi_square.without_g(expected_gravity(setup.site, setup.tracer.density_kg_m3, setup.air.gas)[0])
        # what other runs say tells where the inputs are, not whether this run agrees with what is stated
        known, alone = (one.with_others(responses.others) for one in (chi_square, alone))
        posterior, of_g = (one.posterior(wrong, responses.at) for one in (known, alone))
        if bounces.free_fall is not None:
            bounces = replace(bounces, free_fall=replace(bounces.free_fall, g_m_s2=alone.gravity()))
        unexplained = chi_square.sigmas_left(chi_square.least()[1])
    test = FlightTest() if fit is None else judged_flights(fit, estimate, unexplained)
    test = replace(test, bias_deviations=responses.bias_deviations())
    by_unit: list[InputChange] = []
    for key, response in zip(responses.keys, responses.each, strict=True):
        followed = None if fit is None else fit.follow(response)
        e = _e_changes(estimate, bounces, response, followed)
        g = float("nan") if followed is None else float(followed[0])
        kind: Share = "sphere" if key in (SPHERE, *OF_SPHERE) else "calibration"
        by_unit.append(InputChange(key, kind, time_s, response.moved_m, e, g))
    out = _of_posterior(by_unit, posterior, of_g)
    places = _impact_breaks(estimate, bounces)
    before, after = break_velocities(estimate.posterior, fit)
    out += tilt_and_clock(time_s, lambda: (before[places], after[places]), bounces, setup)
    test = test if outlier is None else replace(test, cause=outlier.finding)
    return bounces, tuple(out), test


def _of_posterior(by_unit: list[InputChange], covariance: FloatArray, of_g: FloatArray) -> list[InputChange]:
    """Return changes that are independent of each other, of inputs with a covariance (n, n), by those of each alone.

    C = D D^T, D a triangle: what the sphere's inputs share with the others counts as theirs. `of_g` is the covariance
    that g changes with.
    """
    if not by_unit:
        return []
    # the sphere first: the rest of the triangle is what antennas leave open where it is held
    order = sorted(range(len(by_unit)), key=lambda n: by_unit[n].share != "sphere")
    by_unit, out = [by_unit[n] for n in order], []
    directions, apart = (np.linalg.cholesky(one[np.ix_(order, order)]).T for one in (covariance, of_g))
    for number, (direction, alone) in enumerate(zip(directions, apart, strict=True)):
        with np.errstate(invalid="ignore"):
            moved = np.tensordot(direction, np.array([one.moved_m for one in by_unit]), 1)
            e = direction @ np.array([one.e for one in by_unit]).reshape(len(by_unit), -1)
            g = float(alone @ np.array([one.g_m_s2 for one in by_unit]))
        out.append(replace(by_unit[number], moved_m=moved, e=e, g_m_s2=g))
    return out


def judged_flights(fit: FlightFit, estimate: JointEstimate, unexplained: float) -> FlightTest:
    """Return by what flights that bend widen u, and what is reported where noise does not explain it.

    `unexplained`: standard deviations of chi-square that inputs leave that may be off by more than their u.
    """
    if estimate.u_position_m is None:
        return FlightTest()
    # two motions from the same samples: what parts them belongs to the uncertainty of both
    bend = fit.bend_over_u(estimate.time_s, estimate.u_position_m)
    apart = float(np.hypot(1.0, bend))
    if fit.excess(np.zeros(0)) < FLIGHTS.min_excess:
        return FlightTest(widening=apart)
    # a misfit that noise does not make belongs to u (Birge), whether it bends the flights or not
    value, expected = fit.misfit
    widening = max(apart, float(np.sqrt(value / expected)))
    # what bends by less than u is known to: alternatives have said so
    if bend < FLIGHTS.min_bend:
        if not unexplained > FLIGHTS.max_unexplained:
            return FlightTest(widening=widening)
        return FlightTest(_bent("flights_unsteady", "change", value, expected, widening), widening=widening)
    widening = max(widening, FLIGHTS.min_widening)
    guess = "setup" if unexplained < FLIGHTS.min_excess else "reflector"
    return FlightTest(_bent("flights_bend", guess, value, expected, widening), widening=widening)


def _bent(code: str, guess: str, value: float, expected: int, widening: float) -> Finding:
    return warn(code, chi_square=value, expected=expected, widening=widening, guess=guess, remedy=guess)


def _e_changes(
    estimate: JointEstimate, bounces: Bounces, response: InputResponse, followed: FloatArray | None
) -> FloatArray:
    """Return de of each impact: of fitted flights by what followed, of others by the motion's one-sided velocities."""
    before, after = first_by_flights(response.before_m_s, response.after_m_s, followed)
    places, n = _impact_breaks(estimate, bounces), np.asarray(bounces.normal)
    speeds = np.array([[one.speed_before_m_s, one.e] for one in bounces.impacts]).reshape(-1, 2).T
    # e = -(after . n) / (before . n): the speed before is that into the floor, and de = (da . n + e db . n) / before
    return np.asarray((after[places] @ n + speeds[1] * (before[places] @ n)) / speeds[0])


def _impact_breaks(estimate: JointEstimate, bounces: Bounces) -> list[int]:
    """Return which break each impact is: flights have moved its instant, and breaks that are no impact lie between."""
    return [int(np.argmin(np.abs(estimate.posterior.breaks.time_s - one.time_s))) for one in bounces.impacts]
