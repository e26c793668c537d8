"""What air drag may have done to e and g of parabolas: a part of their uncertainty (method 5, Flights)."""

import math
from dataclasses import replace

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.model.result import FreeFall
from radargui.restitution.free_flight import fall_below_apex, speed_below_apex
from radargui.restitution.impact_speeds import ImpactSpeeds
from radargui.restitution.parabola import Parabolas, solve_parabolas
from radargui.restitution.stretches import Stretches
from radargui.restitution.track_flights import FittedFlights


def _bend(after_apex_s: FloatArray, g_m_s2: float, drag_1_m: float) -> FloatArray:
    """Return by how much a flight with drag is above the parabola of the same apex and g."""
    return fall_below_apex(after_apex_s, g_m_s2, 0.0) - fall_below_apex(after_apex_s, g_m_s2, drag_1_m)


def _fitted_to_bends(parabolas: Parabolas, drag_1_m: float, samples: Stretches) -> Parabolas:
    """Return what parabolas make of the bends of flights: a fit is linear in heights, so that this is its error."""
    # about its apex: v0 / g after the middle of the flight
    after_apex = samples.away_s - samples.spread(parabolas.speed_m_s / parabolas.g_m_s2)
    return solve_parabolas(samples, _bend(after_apex, float(parabolas.g_m_s2), drag_1_m))


def error_of_e(impacts: ImpactSpeeds, flights: FittedFlights, drag_1_m: float) -> FloatArray:
    """Return by how much drag makes e of parabolas too small, to first order in k, (n_impacts,); 0 where it has none.

    Drag bends a flight by g^2 k D^4 / 12, which a parabola takes for another speed and another g: with k = 0.005 1/m
    (10 mm of steel) e of a 25 cm drop came out 0.1 % too small, and its u 0.006 %. It is not taken off: only the joint
    estimate finds k in the flights themselves.

    Parameters
    ----------
    impacts, flights
        Of parabolas with one g.
    drag_1_m
        k of the sphere.
    """
    own, g = flights.parabolas, float(flights.parabolas.g_m_s2)
    fitted = _fitted_to_bends(own, drag_1_m, flights.samples)
    sides = np.stack(flights.sides(impacts.e.size))
    known, before, after = sides[:, np.isfinite(impacts.e[sides[0]])]
    instant, arriving, leaving, e = (
        values[known] for values in (impacts.time_s, impacts.before_m_s, impacts.after_m_s, impacts.e)
    )

    def missed(place: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return true less fitted height and upward speed of flights at the instants."""
        d = np.asarray(instant - own.origin_s[place] - own.speed_m_s[place] / g)
        faster = speed_below_apex(d, g, drag_1_m) - speed_below_apex(d, g, 0.0)
        return _bend(d, g, drag_1_m) - fitted.height_at(place, instant), faster - fitted.speed_at(place, instant)

    (height_in, speed_in), (height_out, speed_out) = missed(before), missed(after)
    # the flights meet elsewhere too, and both speeds change by g until then
    gained = -g * (height_out - height_in) / (arriving + leaving)
    faster_in, faster_out = gained - speed_in, speed_out - gained
    out = np.zeros(impacts.e.size)
    out[known] = (faster_out - e * faster_in) / arriving
    return out


def with_drag(fall: FreeFall, flights: FittedFlights, drag_1_m: float, normal: tuple[float, float, float]) -> FreeFall:
    """Return the first fall with what drag does in the uncertainty of its g; parameters as above."""
    first = np.arange(flights.samples.size) == flights.place[0]
    g = _fitted_to_bends(flights.parabolas.chosen(first), drag_1_m, flights.samples.chosen(first)).g_m_s2
    return replace(fall, u_g_m_s2=math.hypot(fall.u_g_m_s2, float(g) / max(abs(normal[2]), 1e-9)))
