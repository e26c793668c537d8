"""Other ways to e: the duration and the height of the flight after the impact, and times alone.

Method 5, Cross-check.
"""

import itertools
import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.finding import Finding, warn
from radargui.model.result import Bounces
from radargui.restitution.parabola import solve_parabolas
from radargui.restitution.settings import CHECKS
from radargui.restitution.stretches import Stretches
from radargui.restitution.track_flights import are_known


def cross_check(
    bounces: Bounces,
    time_s: FloatArray,
    height_m: FloatArray,
    g_m_s2: float,
    drag_1_m: float = 0.0,
    slow_m_s: float = 0.0,
) -> Bounces:
    """Return the bounces with e from the flight time and from the height of the flight that follows each.

    With drag k (v + v1) v a flight of duration T over a level floor begins with
    (g T / 2) (1 + g k T^2 / 16 + k v1 T / 6), to first order in k, and one of height h with
    sqrt((g / k) (exp(2 k h) - 1)) (1 + k v1 sqrt(2 h / g) / 3), exactly in k v^2; without drag with g T / 2 and
    sqrt(2 g h). Over the speed before the impact each is e.

    Parameters
    ----------
    bounces
        Impacts in order.
    time_s, height_m
        Height along the floor's normal on the known samples of the motion, shape (n_samples,).
    g_m_s2
        Gravity along the normal.
    drag_1_m, slow_m_s
        k and v1, where they are known.
    """
    impacts = list(bounces.impacts)
    at = np.array([impact.time_s for impact in impacts])
    rises = _rises_m(at, time_s, height_m)
    for number, (impact, following) in enumerate(itertools.pairwise(impacts)):
        before = impact.speed_before_m_s
        # an impact with no speed before it has no e to compare
        if not before > 0.0:
            continue
        duration, rise = following.time_s - impact.time_s, rises[number]
        # the speed that rises to h under drag: its square is 2 g h times (exp(2 k h) - 1) / (2 k h), one for k = 0
        x = 2.0 * drag_1_m * rise
        braked, linear_1_s = math.expm1(x) / x if x else 1.0, drag_1_m * slow_m_s
        by_time = 1.0 + g_m_s2 * drag_1_m * duration**2 / 16.0 + linear_1_s * duration / 6.0
        by_height = 1.0 + linear_1_s * math.sqrt(2.0 * max(rise, 0.0) / g_m_s2) / 3.0
        impacts[number] = replace(
            impact,
            # T from two instants, h from positions: a wrong slope shows in neither (method 5, Cross-check)
            e_flight_time=0.5 * g_m_s2 * duration * by_time / before,
            e_height=math.sqrt(2.0 * g_m_s2 * rise * braked) * by_height / before if rise > 0.0 else math.nan,
        )
    return replace(bounces, impacts=tuple(impacts))


class TimesOfFlights(NamedTuple):
    """When flights between impacts begin and end, as they were measured.

    Attributes
    ----------
    time_s, covariance
        When a fall from rest would have begun, then the impacts, (1 + n_impacts,), and their covariance.
    g_m_s2, drag_1_m, slow_m_s
        Gravity along the normal, drag k and its v1.
    """

    time_s: FloatArray
    covariance: FloatArray
    g_m_s2: float
    drag_1_m: float
    slow_m_s: float

    def restitution(self, time_s: FloatArray) -> FloatArray:
        """Return e of all impacts but the last for times (1 + n_impacts,), shape (n_impacts - 1,).

        A fall of t from rest ends with g t (1 - g k t^2 / 3 - k v1 t / 2). A flight of T over a level floor begins with
        (g T / 2) (1 + g k T^2 / 16 + k v1 T / 6), and drag takes up as much upwards as it takes downwards: it ends
        with what that leaves of g T. All to first order in k. Without drag g cancels.
        """
        g, k, linear = self.g_m_s2, self.drag_1_m, self.drag_1_m * self.slow_m_s
        lasts = np.diff(time_s)
        fall, flights = lasts[:1], lasts[1:]
        begins = 0.5 * g * flights * (1.0 + g * k * flights**2 / 16.0 + linear * flights / 6.0)
        falls = g * fall * (1.0 - g * k * fall**2 / 3.0 - 0.5 * linear * fall)
        return np.asarray(begins / np.concatenate([falls, g * flights - begins])[: begins.size])


_TIME_STEP_S = 1e-6


def with_e_by_times(bounces: Bounces, times: TimesOfFlights) -> Bounces:
    """Return the bounces with e by the times of flights, which path lengths and antennas do not change.

    Parameters
    ----------
    bounces
        Impacts in order.
    times
        Of the first of them; a flight that met a wall is none of these.
    """
    e = times.restitution(times.time_s)
    steps = _TIME_STEP_S * np.eye(times.time_s.size)
    slopes = np.array([times.restitution(times.time_s + step) - e for step in steps]).T / _TIME_STEP_S
    u = np.sqrt(np.maximum(np.einsum("et,tu,eu->e", slopes, times.covariance, slopes), 0.0))
    impacts = list(bounces.impacts)
    for number, (own, u_own, at) in enumerate(zip(e.tolist(), u.tolist(), times.time_s[1:].tolist(), strict=False)):
        if number < len(impacts) and abs(impacts[number].time_s - at) < _SAME_S:
            impacts[number] = replace(impacts[number], e_times=own, u_e_times=u_own)
    return replace(bounces, impacts=tuple(impacts))


_SAME_S = 1e-4  # of two times of one impact


def without_checks_by_walls(bounces: Bounces) -> Bounces:
    """Return the bounces without the other e where the flight after met a wall, whose friction changes them."""
    impacts = list(bounces.impacts)
    for number, (impact, following) in enumerate(itertools.pairwise(impacts)):
        if any(impact.time_s < wall_s < following.time_s for wall_s in bounces.walls_s):
            nan = math.nan
            impacts[number] = replace(impact, e_flight_time=nan, e_height=nan, e_times=nan, u_e_times=nan)
    return replace(bounces, impacts=tuple(impacts))


def _rises_m(impact_s: FloatArray, time_s: FloatArray, height_m: FloatArray) -> list[float]:
    """Return the height of each flight between two impacts above the first, from its own parabola; NaN if unknown."""
    span = np.diff(impact_s)
    # the smoothed corners at the impacts would pull the parabola down
    margin = CHECKS.edge_share * span
    begin, end = np.searchsorted(time_s, [impact_s[:-1] + margin, impact_s[1:] - margin])
    known = np.flatnonzero(are_known(time_s, begin, end, CHECKS.min_known_s))
    out = np.full(span.size, np.nan)
    if known.size:
        flights = Stretches.between(time_s, begin[known], end[known])
        own = solve_parabolas(flights, flights.of(height_m), shared=False)
        # at the impact: v^2 / 2g above it
        g, speed = own.g_m_s2, own.speed_m_s + own.g_m_s2 * (flights.origin_s - impact_s[known])
        falls = g > 0.0
        out[known[falls]] = speed[falls] ** 2 / (2.0 * g[falls])
    return out.tolist()


def found_tilt(bounces: Bounces) -> tuple[str, ...]:
    """Return a sentence where the impacts say that the floor, of which the setup says nothing, is tilted, else none.

    No warning: speeds are along what was found, and what is left open belongs to u.
    """
    if bounces.u_tilt_deg is None or bounces.normal is None:
        return ()
    x, y, z = bounces.normal
    # the angle of the mean normal; its u holds what kicks aside could have done
    tilt = np.degrees(np.arctan2(np.hypot(x, y), z))
    if tilt <= CHECKS.min_tilt_deg + CHECKS.coverage * bounces.u_tilt_deg:
        return ()
    sentence = (
        f"The floor is tilted by {tilt:.2f} ± {bounces.u_tilt_deg:.2f} degrees, as the impacts say (the setup gives no "
        f"floor.normal): speeds are along ({x:.3f}, {y:.3f}, {z:.3f})."
    )
    return (sentence,)


OF_PATHS = "flights of path lengths"
"""Method of impacts whose speeds are those of flights fitted to path lengths."""


def walls_met(bounces: Bounces) -> tuple[str, ...]:
    """Return a sentence where the sphere met walls beside its fall, else none."""
    if not bounces.walls_s:
        return ()
    moments = ", ".join(f"{moment:.3f}" for moment in bounces.walls_s)
    by_track = any(one.method == OF_PATHS for one in bounces.impacts)
    then = "the flights beside them give no e" if by_track else "its flights end there"
    return (f"Walls beside the fall threw the sphere back at {moments} s: {then}.",)


def floor_and_wall(bounces: Bounces) -> list[Finding]:
    """Return a finding for each impact at which a wall was met, too."""
    return [
        warn("wall_at_impact", impact=number, where="beside" if impact.method == OF_PATHS else "within")
        for number, impact in enumerate(bounces.impacts, 1)
        if impact.time_s in bounces.with_walls_s
    ]


def disagreements(bounces: Bounces) -> list[Finding]:
    """Return a finding for each impact whose three coefficients do not agree within three standard uncertainties."""
    found = []
    for number, impact in enumerate(bounces.impacts, 1):
        # what is not valid is warned of already; below this speed an impact can hide in the noise; and where several
        # stand for the next one, it is not the instant at which this flight ends
        known = all(one.valid for one in bounces.impacts[number - 1 : number + 1])
        if not known or impact.speed_after_m_s < CHECKS.min_speed_m_s:
            continue
        # longer than two impacts that are missing would make it: it lay there until somebody dropped it again
        if impact.e_flight_time > CHECKS.longest_flight:
            continue
        # not u alone: a rigid floor without air is a model, and a good one to about a percent
        within = CHECKS.coverage * math.hypot(impact.u_e, CHECKS.model_share * impact.e)
        for way, other in (("flight_time", impact.e_flight_time), ("height", impact.e_height)):
            if math.isfinite(other) and abs(other - impact.e) > within:
                found.append(warn("e_disagrees", impact=number, e=impact.e, other=other, way=way))
    return found
