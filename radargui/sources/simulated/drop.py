"""The drop: free fall onto the floor, bounces, rolling out."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.errors import SetupError
from radargui.model.simulation import Simulation
from radargui.sources.simulated.floor import ContactPlane
from radargui.sources.simulated.glide import Glide

REST_SPEED_M_S = 0.02
LONGEST_S = 600.0
ROLL_OUT_S = 0.25


class Drop:
    """A sphere let go at rest that bounces without loss along the floor.

    Along the floor's normal: flights with -g n_z between impacts, each rebound e times the speed before it; a rebound
    slower than 0.02 m/s does not lift off any more. Along the floor: see `Glide`; after the last impact the sphere
    rolls out evenly within 0.25 s.

    Raises
    ------
    SetupError
        The sphere would bounce for more than ten minutes.
    """

    def __init__(self, simulation: Simulation, release_m: FloatArray, floor: ContactPlane) -> None:
        self._release_m = release_m
        self._floor = floor
        self._gravity_m_s2 = simulation.gravity_m_s2 * float(floor.normal[2])
        self._glide = Glide(simulation, floor)
        e = simulation.restitution
        height = floor.height_m(release_m)
        first_s = float(np.sqrt(2.0 * height / self._gravity_m_s2))
        speed = self._gravity_m_s2 * first_s
        check_it_ends(simulation, height, float(floor.normal[2]))
        rebounds = _rebounds(speed, e)
        self._rebound_m_s = rebounds
        flights_s = 2.0 * rebounds[:-1] / self._gravity_m_s2
        self._impact_s = first_s + np.concatenate([[0.0], np.cumsum(flights_s)])

    @property
    def impact_time_s(self) -> FloatArray:
        """Instants of the impacts, shape (n_impacts,)."""
        return self._impact_s

    @property
    def duration_s(self) -> float:
        """Time from the release until the sphere stays where it is."""
        last = float(self._impact_s[-1])
        return last + ROLL_OUT_S if self._glide.speed_m_s(last) > 0.0 else last

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,)."""
        time_s = np.maximum(time_s, 0.0)
        height = self._floor.height_m(self._release_m) - 0.5 * self._gravity_m_s2 * time_s**2
        flight = np.searchsorted(self._impact_s, time_s, side="right") - 1
        bounced = flight >= 0
        since = time_s[bounced] - self._impact_s[flight[bounced]]
        rebound = self._rebound_m_s[flight[bounced]]
        height[bounced] = np.where(rebound > 0.0, rebound * since - 0.5 * self._gravity_m_s2 * since**2, 0.0)
        along = self._glide.travel_m(time_s, float(self._impact_s[-1]), ROLL_OUT_S)
        fallen = height - self._floor.height_m(self._release_m)
        return np.asarray(self._release_m[:, None] + self._floor.normal[:, None] * fallen + along)


def check_it_ends(simulation: Simulation, height_m: float, upward: float) -> None:
    """Check that a fall of this height, along a normal with this share of the vertical, comes to rest in time.

    Raises
    ------
    SetupError
        The sphere would bounce for more than ten minutes.
    """
    e = simulation.restitution
    first_s = float(np.sqrt(2.0 * height_m / (simulation.gravity_m_s2 * upward)))
    if first_s * (1.0 + e) / (1.0 - e) > LONGEST_S:
        raise SetupError(
            f"simulation.restitution = {e:g}: the simulated sphere would bounce for more than {LONGEST_S:g} s",
            remedy="Choose a smaller restitution.",
        )


def _rebounds(speed_m_s: float, e: float) -> FloatArray:
    """Return the speed after each impact, the last one zero: v_k = e^k v."""
    rebounds = []
    speed = e * speed_m_s
    while speed >= REST_SPEED_M_S:
        rebounds.append(speed)
        speed *= e
    return np.array([*rebounds, 0.0])
