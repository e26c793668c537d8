"""Falls as known motions: gravity is known, and all impacts lie on one floor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from radargui.calibration import unknowns as named
from radargui.calibration.unknowns import Unknown
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import SolveError
from radargui.motion.flights import Flights

LEAST_FLIGHT_S, MOST_FLIGHTS = 0.08, 4
"""Flights that are used: shorter ones say little of gravity, later ones no more than the first."""
RELEASE_S, MARGIN_S = 0.010, 0.001
"""What is left out after the onset, for a release is no clean cut, and beside an impact, which takes its time."""
U_ONSET_S, U_START_M_S, U_IMPACT_S, U_VELOCITY_M_S = 0.003, 0.02, 0.005, 0.3
"""Prior deviations: of the release's instant and speed (a finger's), of impacts and of the velocities after them."""
U_CONTACT_M = 2e-5
"""How well an impact lies on the floor's plane: roughness, and how far a sphere presses in."""
LEAN_DEG = 1e-3
"""Half the step of differences by which way gravity leans."""


@dataclass(frozen=True)
class Falls:
    """Rest, first fall, and the flights after it up to a time.

    Attributes
    ----------
    place
        Name of the place where the sphere hangs (`place_unknowns`).
    onset_s, impact_s
        First guesses; impacts end all flights but the last.
    after_m_s
        Velocities after the impacts, first guesses, shape (n_impacts, 3).
    end_s
        End of the last flight.
    slow_m_s
        v1 of the sphere's drag k (|v| + v1) v.
    """

    place: str
    onset_s: float
    impact_s: FloatArray
    after_m_s: FloatArray
    end_s: float
    slow_m_s: float = 0.0

    @property
    def own(self) -> tuple[Unknown, ...]:
        """Unknowns of this recording alone."""
        out = [Unknown("onset_s", self.onset_s, U_ONSET_S)]
        out += [Unknown(f"start.{axis}_m_s", 0.0, U_START_M_S) for axis in "xyz"]
        for n, (time, *velocity) in enumerate(np.column_stack([self.impact_s, self.after_m_s]).tolist(), 1):
            out.append(Unknown(f"impact.{n}_s", time, U_IMPACT_S))
            out += [
                Unknown(f"after.{n}.{axis}_m_s", v, U_VELOCITY_M_S) for axis, v in zip("xyz", velocity, strict=True)
            ]
        return tuple(out)

    @property
    def uses(self) -> tuple[str, ...]:
        """Names of the shared unknowns that it depends on."""
        places = tuple(f"{self.place}.{axis}" for axis in "xyz")
        fall = (named.GRAVITY, named.GRAVITY_X, named.GRAVITY_Y, named.DRAG)
        return (*places, *fall, named.HEIGHT, named.FLOOR_X, named.FLOOR_Y)

    def known(self, time_s: FloatArray) -> BoolArray:
        """Return whether the motion is known at times, shape (n,), as first guessed."""
        # by first guesses: which samples count must not change from step to step of the fit
        known = (time_s < self.onset_s - U_ONSET_S) | (time_s > self.onset_s + RELEASE_S)
        for impact in self.impact_s:
            known &= np.abs(time_s - impact) > MARGIN_S
        return np.asarray(known & (time_s < self.end_s - MARGIN_S))

    def at(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return place, velocity and acceleration at times, shape (3, 3, n), and what the impacts are off the floor.

        The distances from the floor are in standard deviations, shape (n_impacts,).

        Raises
        ------
        SolveError
            The unknowns describe no fall.
        """
        flights, frame = self._flights(shared, own)
        # after its last flight it counts as at rest: what it does there is not asked, and must not be far away
        is_flying = (time_s >= flights.onset_s) & (time_s <= self.end_s)
        place = frame @ flights.position_m(np.append(np.minimum(time_s, self.end_s), flights.impact_s))
        place += np.array([[shared[f"{self.place}.{axis}"]] for axis in "xyz"])
        velocity = frame @ flights.velocity_at(time_s)
        drag = flights.drag_1_m * (np.sqrt((velocity**2).sum(axis=0)) + self.slow_m_s) * velocity
        acceleration = -flights.g_m_s2 * frame[:, 2:] - drag
        series = np.stack(
            [place[:, : time_s.size], *(np.where(is_flying, one, 0.0) for one in (velocity, acceleration))]
        )
        return series, (self._above(shared) @ place[:, time_s.size :] - shared[named.HEIGHT]) / U_CONTACT_M

    def slopes(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return derivatives of places and ties by what it `uses`, then by its own, (n, 3, n_times) and (n, n_ties)."""
        (flights, frame), n_times = self._flights(shared, own), time_s.size
        layout, impacts = flights.layout, flights.impact_s
        _, by = flights.position_and_slopes(np.append(np.minimum(time_s, self.end_s), impacts))
        # an impact takes along the instant at which the sphere is at its floor
        for n, velocity in enumerate(flights.velocity_m_s[1:]):
            by[layout.impacts.start + n, :, n_times + n] += velocity
        by = frame @ by
        turned = [np.tensordot(frame, by[layout.velocity(n)], axes=1) for n in range(layout.n_flights)]
        moments = [by[[layout.onset]], *by[layout.impacts][:, None]]
        of_own = [part for pair in zip(moments, turned, strict=True) for part in pair]
        leaning = []
        for name in (named.GRAVITY_X, named.GRAVITY_Y):
            there = [self._flights({**shared, name: shared[name] + step}, own) for step in (-LEAN_DEG, LEAN_DEG)]
            low, high = (
                other @ one.position_m(np.append(np.minimum(time_s, self.end_s), impacts)) for one, other in there
            )
            leaning.append((high - low) / (2.0 * LEAN_DEG))
        still = np.zeros((3, *by.shape[1:]))
        of_fall = [by[layout.gravity], *leaning, by[layout.drag], *still]
        slopes = np.concatenate([np.broadcast_to(np.eye(3)[:, :, None], still.shape), of_fall, *of_own])
        hit = self.at(impacts, shared, own)[0][0]
        ties = np.einsum("x,kxn->kn", self._above(shared), slopes[:, :, n_times:])
        # the floor's height and its two slopes stand last of what is shared
        ties[7:10] = np.stack([-np.ones(impacts.size), *np.radians(hit[:2])])
        return slopes[:, :, :n_times], ties / U_CONTACT_M

    @staticmethod
    def _above(shared: Mapping[str, float]) -> FloatArray:
        # a floor whose normal leans to x falls off towards x
        return np.array([np.radians(shared[named.FLOOR_X]), np.radians(shared[named.FLOOR_Y]), 1.0])

    def _flights(self, shared: Mapping[str, float], own: FloatArray) -> tuple[Flights, FloatArray]:
        """Return the flights from the place, gravity along -z, and what turns them to where gravity leans, (3, 3)."""
        # two small leanings: the direction's length is one but for their fourth powers
        x, y = np.radians([shared[named.GRAVITY_X], shared[named.GRAVITY_Y]])
        up = np.array([-np.sin(x), -np.sin(y), np.cos(np.hypot(x, y))])
        first = np.array([up[2], 0.0, -up[0]]) / np.hypot(up[0], up[2])
        frame = np.stack([first, np.cross(up, first), up], axis=1)
        begin_s, velocity = np.append(own[0], own[4::4]), np.append(own[1:], 0.0).reshape(-1, 4)[:, :3]
        if not (np.diff(begin_s, append=self.end_s) > 0.0).all() or not np.isfinite(own).all():
            raise SolveError("Impacts out of their order are no fall.")
        g, drag = shared[named.GRAVITY], shared[named.DRAG]
        return Flights(float(own[0]), np.zeros(3), g, drag, self.slow_m_s, velocity @ frame, begin_s[1:]), frame
