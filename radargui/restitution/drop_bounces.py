"""Bounces of a drop measured by its flights: e at each impact, g, what the setup leaves open of them (method 5)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.result import Bounce, Bounces, FreeFall, VelocitiesAtImpacts
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange
from radargui.motion.flights import Flights
from radargui.restitution.cross_check import TimesOfFlights, cross_check, with_e_by_times
from radargui.restitution.floor_normal import FloorNormal, normal_of_impacts
from radargui.restitution.settings import FLIGHTS
from radargui.restitution.track_response import tilt_and_clock

if TYPE_CHECKING:
    # the window, which starts with this, asks for no estimate yet
    from radargui.estimation.flights.estimate import DropEstimate
    from radargui.estimation.flights.readout import PlaceChanges


def drop_bounces(estimate: DropEstimate, setup: Setup) -> Bounces:
    """Return the bounces between the flights; uncertainties hold what the setup states.

    Speeds are along the floor's normal where the setup gives it, else along the one that the impacts support.
    """
    flights = estimate.flights
    velocity, by_unknowns = estimate.impact_velocities()
    statistical = estimate.widening**2 * np.einsum("ean,nm,ebm->eab", by_unknowns, estimate.held, by_unknowns)
    floor = normal_of_velocities(setup, velocity, statistical)
    impacts = tuple(
        bounce_at(float(time), own, covariance, floor)
        for time, own, covariance in zip(flights.impact_s, velocity, statistical, strict=True)
    )
    given = "normal" in setup.floor.model_fields_set
    x, y, z = (float(part) for part in floor.normal)
    bounces = Bounces(
        impacts,
        fall_of(flights, estimate.end_s, floor.normal, estimate.gravity, flights.start_m),
        (x, y, z),
        None if given or not impacts else floor.u_tilt_deg,
        velocities=VelocitiesAtImpacts(
            flights.impact_s, velocity[:, :3], velocity[:, 3:], statistical, floor.slope_variance
        ),
    )
    time = np.arange(flights.onset_s, estimate.end_s, FLIGHTS.check_step_s)
    height = floor.normal @ flights.position_m(time)
    checked = cross_check(bounces, time, height, flights.g_m_s2 * z, flights.drag_1_m, flights.slow_m_s)
    return with_e_by_times(checked, _times(estimate, z))


def _times(estimate: DropEstimate, upright: float) -> TimesOfFlights:
    """Return the times of flights; the fall counts from when it would have begun at rest."""
    flights, layout = estimate.flights, estimate.flights.layout
    columns = np.zeros((1 + flights.impact_s.size, layout.size))
    columns[0, layout.onset], columns[0, layout.velocity(0).start + 2] = 1.0, 1.0 / flights.g_m_s2
    columns[1:, layout.impacts] = np.eye(flights.impact_s.size)
    by_unknowns = estimate.by_unknowns(columns)
    begins_s = flights.onset_s + float(flights.velocity_m_s[0, 2]) / flights.g_m_s2
    covariance = estimate.widening**2 * by_unknowns @ estimate.covariance @ by_unknowns.T
    times = np.append(begins_s, flights.impact_s)
    return TimesOfFlights(times, covariance, flights.g_m_s2 * upright, flights.drag_1_m, flights.slow_m_s)


def normal_of_velocities(setup: Setup, velocity: FloatArray, covariance: FloatArray) -> FloorNormal:
    """Return the floor's normal, where the setup gives none by velocities before and after the impacts.

    Parameters
    ----------
    setup
        Its floor.
    velocity, covariance
        At the impacts, shapes (n_impacts, 6) and (n_impacts, 6, 6).
    """
    floor = FloorNormal(np.asarray(setup.floor.normal))
    if "normal" in setup.floor.model_fields_set or not len(velocity):
        return floor
    change = np.concatenate([-np.eye(2, 3), np.eye(2, 3)], axis=1)
    aside = np.trace(change @ covariance @ change.T, axis1=1, axis2=2) / 2.0
    return normal_of_impacts(velocity[:, :3], velocity[:, 3:], np.sqrt(aside), setup.floor.u_tilt_deg)


def bounce_at(
    time_s: float, velocity: FloatArray, covariance: FloatArray, floor: FloorNormal, method: str = "flights"
) -> Bounce:
    """Return the bounce of velocities before and after an impact, (6,), with their covariance (6, 6)."""
    before_m_s, after_m_s = velocity[:3], velocity[3:]
    before, after = -float(before_m_s @ floor.normal), float(after_m_s @ floor.normal)
    e = after / before
    slope = np.concatenate([e / before * floor.normal, floor.normal / before])
    variance = float(slope @ covariance @ slope) + float(floor.e_variance(before_m_s, after_m_s))
    u_e = float(np.sqrt(max(variance, 0.0)))
    valid = bool(0.0 < e < FLIGHTS.most_e and u_e < FLIGHTS.usable_u_e)
    return Bounce(time_s, before, after, e, u_e, method, valid)


def fall_of(
    flights: Flights, end_s: float, normal: FloatArray, gravity: tuple[float, float], release_m: FloatArray
) -> FreeFall:
    """Return the first of some flights as a fall from a release, (3,), with g and its u.

    Without an impact it ends at `end_s`.
    """
    ends = flights.impact_s[:1] if flights.impact_s.size else np.array([end_s])
    time = np.linspace(flights.onset_s, float(ends[0]), 200)
    height = normal @ flights.position_m(time)
    bend, slope, level = np.polyfit(time - time[0], height, 2).tolist()
    residual = height - np.polyval([bend, slope, level], time - time[0])
    release = float(normal @ release_m)
    drop = release - float(height[-1]) if flights.impact_s.size else float("nan")
    g, u_g = gravity
    rms = float(np.sqrt((residual**2).mean()))
    return FreeFall(g, u_g, float(time[0]), float(time[-1]), release, drop, (level, slope, bend), rms)


def drop_changes(
    estimate: DropEstimate, bounces: Bounces, changes: PlaceChanges, setup: Setup
) -> tuple[InputChange, ...]:
    """Return what places, e and g change by along each direction that the posterior leaves the setup open in."""
    velocity, by_unknowns = estimate.impact_velocities()
    normal = np.asarray(bounces.normal)
    speed = np.array([[one.speed_before_m_s, one.e] for one in bounces.impacts]).reshape(-1, 2)
    by_speeds = by_unknowns[:, :3] * speed[:, 1, None, None] + by_unknowns[:, 3:]
    e = np.einsum("a,ean->en", normal, by_speeds) / speed[:, :1]
    out = [
        InputChange(
            f"setup[{number}]",
            "calibration",
            changes.time_s,
            estimate.widening * np.einsum("n,nat->at", direction, changes.place),
            estimate.widening * e @ direction,
            0.0,
        )
        for number, direction in enumerate(estimate.by_setup, 1)
    ]
    out += tilt_and_clock(changes.time_s, lambda: (velocity[:, :3], velocity[:, 3:]), bounces, setup)
    return tuple(out)
