"""What position, e and g of a joint estimate change by where an input of the setup is off by its uncertainty.

Method 6, Flights that bend.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.joint import JointEstimate
from radargui.estimation.readout.input_response import DIAMETER, InputResponse, moved_inputs, possible_spheres
from radargui.model.arrays import FloatArray
from radargui.model.assumed import CLOCK, TILT, uncertain_inputs, usual_u
from radargui.model.result import Bounces
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange, Share
from radargui.restitution.bent_flights import bent_flights, unsteady, without_guess
from radargui.restitution.flight_fit import FlightFit, break_velocities, first_by_flights
from radargui.restitution.settings import FLIGHTS
from radargui.restitution.setup_chi_square import SetupChiSquare
from radargui.restitution.setup_outlier import misstated, setup_outlier
from radargui.restitution.track_response import tilt_and_clock

INSTANTS = 8000
"""At which shifts are kept, over the whole record: each is a curve of its own, and there are two dozens."""
SPHERE = "sphere"


@dataclass(frozen=True, slots=True)
class FlightTest:
    """What the flights say: a sentence for people where they bend, what u is widened by, what likely makes them bend.

    And whether that explains all of it; and by what chi-square is blurred (`SetupChiSquare.blur`).
    """

    warning: str = ""
    widening: float = 1.0
    cause: str = ""
    explained: bool = True
    blur: float = 1.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """All that is told, what likely makes the flights bend first, and then no guess where that explains it."""
        sentences = tuple(one for one in (self.cause, self.warning) if one)
        return tuple(without_guess(sentences)) if self.cause and self.explained else sentences


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
    """

    time_s: FloatArray
    keys: tuple[str, ...]
    each: tuple[InputResponse, ...]
    exact: frozenset[str] = frozenset()

    @property
    def uncertain(self) -> SetupResponses:
        """Those of what the setup does not call exact."""
        if not self.exact:
            return self
        kept = [(key, one) for key, one in zip(self.keys, self.each, strict=True) if key not in self.exact]
        return SetupResponses(self.time_s, tuple(key for key, _ in kept), tuple(one for _, one in kept))

    @property
    def n_spheres(self) -> int:
        """How many spheres are possible: of them only one is there."""
        return self.keys.count(SPHERE)

    @property
    def weights(self) -> FloatArray:
        """Of the inputs' own squares, shape (n,): of n possible spheres only one is there."""
        return np.array([float(self.keys.count(key)) for key in self.keys])

    def bias_deviations(self) -> FloatArray:
        """Return the deviation that inputs off by their u give to each receiver's bias maps, shape (n_receivers,)."""
        own = self.uncertain
        squares = [one.bias**2 / share for one, share in zip(own.each, own.weights, strict=True)]
        return np.asarray(np.sqrt(np.sum(squares, axis=0))) if squares else np.zeros(1)

    def floor_covariance(self) -> FloatArray:
        """Return the covariance that the inputs leave to the slope of the floor that reflects, shape (2, 2)."""
        out = np.zeros((2, 2))
        for key, one in zip(self.uncertain.keys, self.uncertain.each, strict=True):
            # no sphere is more likely than another: the mean square over them
            out += np.outer(one.floor_slope, one.floor_slope) / (self.n_spheres if key == SPHERE else 1)
        return out


def setup_responses(estimate: JointEstimate, setup: Setup) -> SetupResponses:
    """Return how the estimate follows the uncertain inputs of the setup it was made with.

    Where no polarisation is given the sphere counts as a point: then the responses to conducting spheres of this
    diameter are added, over the transmitter's directions.
    """
    posterior = estimate.posterior
    # the motion has polarisations as unknowns, and does not depend on the floor and the clock
    stated = uncertain_inputs(setup)
    exact = frozenset(one.key for one in stated if one.u == 0.0 and one.key != DIAMETER)
    asked = [
        (one.key, moved_inputs(setup, one))
        for one in (replace(one, u=usual_u(one)) if one.key in exact else one for one in stated)
        if one.u > 0.0
        and one.key not in (TILT, CLOCK)
        and not one.key.endswith("polarization_deg")
        and not (one.key == DIAMETER and posterior.is_point)
    ]
    if posterior.is_point:
        asked += [(SPHERE, other) for other in possible_spheres(setup)]
    # shifts are smooth: so many instants say all
    time_s = estimate.time_s[:: max(1, estimate.time_s.size // INSTANTS)]
    each = posterior.responses([other for _, other in asked], time_s)
    return SetupResponses(time_s, tuple(key for key, _ in asked), each, exact)


def joint_changes(
    estimate: JointEstimate, bounces: Bounces, fit: FlightFit | None, setup: Setup, responses: SetupResponses
) -> tuple[tuple[InputChange, ...], FlightTest]:
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
    time_s, out = responses.time_s, []
    outlier, slips = None, np.ones(len(responses.keys))
    unexplained, blur = 0.0 if fit is None else fit.excess(np.zeros(0)), 1.0
    if fit is not None and responses.keys:
        exact = np.array([key in responses.exact for key in responses.keys])
        chi_square = SetupChiSquare.of(fit, responses.keys, responses.each, setup, exact)
        outlier = setup_outlier(chi_square, responses.keys, setup)
        slips = misstated(chi_square, responses.keys, setup)
        unexplained, blur = chi_square.sigmas_left(chi_square.least()[1]), chi_square.blur
    test = FlightTest() if fit is None else _tested(fit, responses.uncertain, estimate, unexplained)
    test = replace(test, blur=blur)
    for key, response, slip in zip(responses.keys, responses.each, slips.tolist(), strict=True):
        if key in responses.exact and (outlier is None or key not in outlier.off):
            continue
        followed = None if fit is None else fit.follow(response)
        e = _e_changes(estimate, bounces, response, followed)
        g = float("nan") if followed is None else float(followed[0])
        # no possible sphere is more likely than another: their squares add up to the mean square
        share = 1.0 / np.sqrt(responses.n_spheres) if key == SPHERE else 1.0
        # as far off as the run itself says
        share *= slip if outlier is None else max(slip, outlier.widening(key))
        kind: Share = "sphere" if key in (SPHERE, DIAMETER) else "calibration"
        out.append(InputChange(key, kind, time_s, share * response.moved_m, share * e, share * g))
    places = _impact_breaks(estimate, bounces)
    before, after = break_velocities(estimate.posterior, fit)
    out += tilt_and_clock(time_s, lambda: (before[places], after[places]), bounces, setup)
    return tuple(out), test if outlier is None else replace(test, cause=outlier.sentence, explained=outlier.explains)


def _tested(fit: FlightFit, responses: SetupResponses, estimate: JointEstimate, unexplained: float) -> FlightTest:
    """Return by what flights that bend widen u, and what is reported where neither noise nor the setup explains it.

    `unexplained`: standard deviations of chi-square that inputs leave that may be off by more than their u.
    """
    bends, keys = fit.bends(responses.each), responses.keys
    # of the possible spheres only one is there: their mean counts as one input
    each = np.array([bends[[other == key for other in keys]].mean() for key in dict.fromkeys(keys)])
    if estimate.u_position_m is None:
        return FlightTest()
    # two motions from the same samples: what parts them belongs to the uncertainty of both
    bend = fit.bend_over_u(estimate.time_s, estimate.u_position_m)
    apart = float(np.hypot(1.0, bend))
    if fit.excess(each) < FLIGHTS.least_excess:
        return FlightTest(widening=apart)
    # a misfit that noise does not make belongs to u (Birge), whether it bends the flights or not
    value, expected = fit.misfit
    widening = max(apart, float(np.sqrt(value / (expected + each.sum()))))
    # what bends by less than u is known to: alternatives have said so
    if bend < FLIGHTS.least_bend:
        is_reported = unexplained > FLIGHTS.most_unexplained
        return FlightTest(unsteady(value, expected, widening) if is_reported else "", widening)
    widening = max(widening, FLIGHTS.least_widening)
    return FlightTest(bent_flights(value, expected, widening, by_setup=unexplained < FLIGHTS.least_excess), widening)


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
