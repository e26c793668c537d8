"""What air drag may have done to e and g of parabolas: a part of their uncertainty (method 5, Flights)."""

import math
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.model.result import FreeFall
from radargui.restitution.free_flight import fall_below_apex, speed_below_apex
from radargui.restitution.impact_speeds import ImpactSpeeds
from radargui.restitution.parabola import Parabolas, solve_parabolas
from radargui.restitution.stretches import Stretches
from radargui.restitution.track_flights import FittedFlights


@dataclass(frozen=True, slots=True)
class _Bends:
    """By how much drag bends flights away from parabolas, and what parabolas make of that.

    A fit is linear in heights: that of the bends alone is the error of the fit.
    """

    parabolas: Parabolas
    drag_1_m: float
    fitted: Parabolas

    @staticmethod
    def of(parabolas: Parabolas, drag_1_m: float, samples: Stretches) -> "_Bends":
        # about its apex: v0 / g after the middle of the flight
        after_apex = samples.away_s - samples.spread(parabolas.speed_m_s / parabolas.g_m_s2)
        bend = _bend(after_apex, float(parabolas.g_m_s2), drag_1_m)
        return _Bends(parabolas, drag_1_m, solve_parabolas(samples, bend))

    def missed_height(self, place: IntArray, time_s: FloatArray) -> FloatArray:
        """Return true less fitted height of flights at instants, shapes (n,)."""
        bend = _bend(self._after_apex(place, time_s), float(self.parabolas.g_m_s2), self.drag_1_m)
        return bend - self.fitted.height_at(place, time_s)

    def missed_speed(self, place: IntArray, time_s: FloatArray) -> FloatArray:
        """Return true less fitted upward speed of flights at instants, shapes (n,)."""
        d, g = self._after_apex(place, time_s), float(self.parabolas.g_m_s2)
        bend = speed_below_apex(d, g, self.drag_1_m) - speed_below_apex(d, g, 0.0)
        return np.asarray(bend - self.fitted.speed_at(place, time_s))

    def _after_apex(self, place: IntArray, time_s: FloatArray) -> FloatArray:
        own = self.parabolas
        return np.asarray(time_s - own.origin_s[place] - own.speed_m_s[place] / own.g_m_s2)


def _bend(after_apex_s: FloatArray, g_m_s2: float, drag_1_m: float) -> FloatArray:
    return fall_below_apex(after_apex_s, g_m_s2, 0.0) - fall_below_apex(after_apex_s, g_m_s2, drag_1_m)


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
    bends = _Bends.of(flights.parabolas, drag_1_m, flights.samples)
    sides = np.stack(flights.sides(impacts.e.size))
    known, before, after = sides[:, np.isfinite(impacts.e[sides[0]])]
    instant, arriving, leaving, e = (
        own[known] for own in (impacts.time_s, impacts.before_m_s, impacts.after_m_s, impacts.e)
    )
    # the flights meet elsewhere too, and both speeds change by g until then
    gap = bends.missed_height(after, instant) - bends.missed_height(before, instant)
    gained = -bends.parabolas.g_m_s2 * gap / (arriving + leaving)
    faster_in = gained - bends.missed_speed(before, instant)
    faster_out = bends.missed_speed(after, instant) - gained
    out = np.zeros(impacts.e.size)
    out[known] = (faster_out - e * faster_in) / arriving
    return out


def with_drag(fall: FreeFall, flights: FittedFlights, drag_1_m: float, normal: tuple[float, float, float]) -> FreeFall:
    """Return the first fall with what drag does in the uncertainty of its g; parameters as above."""
    first = np.arange(flights.samples.size) == flights.place[0]
    g = _Bends.of(flights.parabolas.chosen(first), drag_1_m, flights.samples.chosen(first)).fitted.g_m_s2
    return replace(fall, u_g_m_s2=math.hypot(fall.u_g_m_s2, float(g) / max(abs(normal[2]), 1e-9)))
