"""What air drag may have done to e and g of parabolas: a part of their uncertainty (method 5, Flights)."""

from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.bounce import Bounce, Bounces
from radargui.restitution.free_flight import fall_below_apex, speed_below_apex
from radargui.restitution.parabola import Parabolas, fit_parabolas
from radargui.restitution.track_flights import FittedFlights


@dataclass(frozen=True, slots=True)
class _Bends:
    """By how much drag bends the flights away from parabolas, and what parabolas make of that.

    A fit is linear in heights: that of the bends alone is the error of the fit.
    """

    parabolas: Parabolas
    drag_1_m: float
    fitted: Parabolas

    @staticmethod
    def of(parabolas: Parabolas, drag_1_m: float, times_s: list[FloatArray]) -> "_Bends":
        bare = _Bends(parabolas, drag_1_m, parabolas)
        heights = [bare.height(place, time) for place, time in enumerate(times_s)]
        return replace(bare, fitted=fit_parabolas(list(zip(times_s, heights, strict=True))))

    def _after_apex(self, place: int, time_s: FloatArray | float) -> FloatArray:
        own = self.parabolas
        return np.asarray(time_s - own.origin_s[place] - own.speed_m_s[place] / own.g_m_s2)

    def height(self, place: int, time_s: FloatArray | float) -> FloatArray:
        d, g = self._after_apex(place, time_s), self.parabolas.g_m_s2
        return fall_below_apex(d, g, 0.0) - fall_below_apex(d, g, self.drag_1_m)

    def missed_height(self, place: int, time_s: float) -> float:
        """Return true less fitted height."""
        return float(self.height(place, time_s)) - self.fitted.height_at(place, time_s)

    def missed_speed(self, place: int, time_s: float) -> float:
        """Return true less fitted upward speed."""
        d, g = self._after_apex(place, time_s), self.parabolas.g_m_s2
        bend = float(speed_below_apex(d, g, self.drag_1_m) - speed_below_apex(d, g, 0.0))
        return bend - self.fitted.speed_at(place, time_s)


def with_drag(bounces: Bounces, flights: FittedFlights, times_s: list[FloatArray], drag_1_m: float) -> Bounces:
    """Return bounces whose uncertainties of e and g hold what drag does.

    Drag bends a flight by g^2 k D^4 / 12, which a parabola takes for another speed and another g: with k = 0.005 1/m
    (10 mm of steel) e of a 25 cm drop came out 0.1 % too small, and its u 0.006 %. It is not taken off: only the joint
    estimate finds k in the flights themselves.

    Parameters
    ----------
    bounces
        Of parabolas with one g.
    flights, times_s
        The parabolas, and the times of each, shapes (n_samples,).
    drag_1_m
        k of the sphere.
    """
    bends, place = _Bends.of(flights.parabolas, drag_1_m, times_s), flights.place
    impacts = tuple(
        replace(one, u_e=float(np.hypot(one.u_e, _error_of_e(one, bends, place[k], place[k + 1]))))
        if np.isfinite(one.e)
        else one
        for k, one in enumerate(bounces.impacts)
    )
    fall = bounces.free_fall
    if fall is not None and bounces.normal is not None:
        first = times_s[place[0]]
        g = fit_parabolas([(first, bends.height(place[0], first))]).g_m_s2 / max(abs(bounces.normal[2]), 1e-9)
        fall = replace(fall, u_g_m_s2=float(np.hypot(fall.u_g_m_s2, g)))
    return replace(bounces, impacts=impacts, free_fall=fall)


def _error_of_e(impact: Bounce, bends: _Bends, before: int, after: int) -> float:
    """Return by how much e is too small, to first order in k."""
    instant, arriving, leaving = impact.time_s, impact.speed_before_m_s, impact.speed_after_m_s
    # the flights meet elsewhere too, and both speeds change by g until then
    gap = bends.missed_height(after, instant) - bends.missed_height(before, instant)
    gained = -bends.parabolas.g_m_s2 * gap / (arriving + leaving)
    faster_in = gained - bends.missed_speed(before, instant)
    faster_out = bends.missed_speed(after, instant) - gained
    return (faster_out - impact.e * faster_in) / arriving
