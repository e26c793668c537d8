"""Bounces and the free fall: what the track says about the sphere and the floor."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Bounce:
    """One impact.

    Attributes
    ----------
    time_s
        Instant of impact.
    speed_before_m_s, speed_after_m_s
        Speeds along the floor's normal at the instant of impact, positive.
    e
        Coefficient of restitution, after / before.
    u_e
        Its standard uncertainty.
    method
        How the speeds were found.
    valid
        False where the signal cannot support the coefficient.
    e_flight_time
        From the time until the next impact, g T / (2 v_before); NaN without a next impact.
    e_height
        From the height of the apex that follows, sqrt(2 g h) / v_before; NaN without a next impact.
    u_e_combined
        Standard uncertainty of e with what antennas, floor and sphere leave open; NaN where it was not carried.
    """

    time_s: float
    speed_before_m_s: float
    speed_after_m_s: float
    e: float
    u_e: float
    method: str
    valid: bool
    e_flight_time: float = float("nan")
    e_height: float = float("nan")
    u_e_combined: float = float("nan")

    @property
    def u_stated(self) -> float:
        """What people read behind the ±: the combined uncertainty of e where it is known, else the statistical."""
        return self.u_e_combined if math.isfinite(self.u_e_combined) else self.u_e


@dataclass(frozen=True, slots=True)
class FreeFall:
    """The first fall checked against the parabola.

    Attributes
    ----------
    g_m_s2, u_g_m_s2
        Acceleration and its standard uncertainty.
    first_time_s, last_time_s
        Span of the fit.
    release_height_m
        Height at rest before the fall, along the floor's normal.
    drop_height_m
        Height at rest above the height of the first impact; NaN where the fall ends without one.
    parabola
        Coefficients of the height along the floor's normal, a + b (t - first) + c (t - first)^2 in m, m/s, m/s^2.
    residual_rms_m
        Root mean square of the height against the parabola.
    """

    g_m_s2: float
    u_g_m_s2: float
    first_time_s: float
    last_time_s: float
    release_height_m: float
    drop_height_m: float
    parabola: tuple[float, float, float]
    residual_rms_m: float


@dataclass(frozen=True, slots=True)
class Bounces:
    """All impacts of a run in time order, and the fall before the first.

    Attributes
    ----------
    impacts, free_fall
        What was found.
    normal
        Unit vector away from the floor, which speeds and heights are along; None where nothing was found along any.
    u_tilt_deg
        Standard uncertainty of its angle from the vertical, where it was found from the impacts with one.
    """

    impacts: tuple[Bounce, ...] = ()
    free_fall: FreeFall | None = None
    normal: tuple[float, float, float] | None = None
    u_tilt_deg: float | None = None

    def widened(self, factor: float) -> Bounces:
        """Return them with the uncertainties of every e and of g times a factor."""
        fall = self.free_fall
        return replace(
            self,
            impacts=tuple(replace(one, u_e=factor * one.u_e) for one in self.impacts),
            free_fall=None if fall is None else replace(fall, u_g_m_s2=factor * fall.u_g_m_s2),
        )
