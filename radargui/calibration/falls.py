"""Falls as known motions: gravity is known and straight, and all impacts lie on one floor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from radargui.calibration import unknowns as named
from radargui.calibration.unknowns import Unknown
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import SolveError

LEAST_FLIGHT_S, MOST_FLIGHTS = 0.08, 4
"""Flights that are used: shorter ones say little of gravity, later ones no more than the first."""
RELEASE_S, MARGIN_S = 0.010, 0.001
"""What is left out after the onset, for a release is no clean cut, and beside an impact, which takes its time."""
U_ONSET_S, U_START_M_S, U_IMPACT_S, U_VELOCITY_M_S = 0.003, 0.02, 0.005, 0.3
"""Prior deviations: of the release's instant and speed (a finger's), of impacts and of the velocities after them."""
U_CONTACT_M = 2e-5
"""How well an impact lies on the floor's plane: roughness, and how far a sphere presses in."""
_STEPS = 6


@dataclass(frozen=True)
class Falls:
    """Rest, first fall, and the flights after it up to a time.

    Attributes
    ----------
    place
        Name of the place where it hangs (`place_unknowns`).
    onset_s, impact_s
        First guesses; impacts end all flights but the last.
    after_m_s
        Velocities after the impacts, first guesses, shape (n_impacts, 3).
    end_s
        End of the last flight.
    """

    place: str
    onset_s: float
    impact_s: FloatArray
    after_m_s: FloatArray
    end_s: float

    @property
    def own(self) -> tuple[Unknown, ...]:
        """Unknowns of this recording alone."""
        out = [Unknown("onset_s", self.onset_s, U_ONSET_S)]
        out += [Unknown(f"start.{axis}_m_s", 0.0, U_START_M_S) for axis in "xyz"]
        for n, (time, velocity) in enumerate(zip(self.impact_s, self.after_m_s, strict=True), 1):
            out.append(Unknown(f"impact.{n}_s", float(time), U_IMPACT_S))
            out += [
                Unknown(f"after.{n}.{axis}_m_s", float(v), U_VELOCITY_M_S)
                for axis, v in zip("xyz", velocity, strict=True)
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
        known = (time_s < self.onset_s - U_ONSET_S) | (time_s > self.onset_s + RELEASE_S)
        for impact in self.impact_s:
            known &= np.abs(time_s - impact) > MARGIN_S
        return np.asarray(known & (time_s < self.end_s - MARGIN_S))

    def at(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return place, velocity and acceleration at times, shape (3, 3, n), and what the impacts are off the floor.

        The latter in standard deviations, shape (n_impacts,).
        """
        place = np.array([shared[f"{self.place}.{axis}"] for axis in "xyz"])
        begin_s = np.array([own[0], *own[4::4]])
        duration_s = np.diff(begin_s, append=self.end_s + 0.01)
        curve = self._flights(duration_s, own[1:], shared)
        # each flight starts where the one before it ended
        end = np.cumsum(curve(1.0)[:, :3], axis=0) + place
        start = np.vstack([place, end[:-1]])
        # after its last flight it counts as at rest: what it does there is not asked, and must not be far away
        number = np.where(time_s > self.end_s, -1, np.searchsorted(begin_s, time_s, side="right") - 1)
        out = np.zeros((3, 3, time_s.size))
        out[0] = np.where(time_s > self.end_s, end[-1][:, None], place[:, None])
        for n, (begin, lasts) in enumerate(zip(begin_s, duration_s, strict=True)):
            here = number == n
            for order in range(3):
                out[order][:, here] = curve((time_s[here] - begin) / lasts, nu=order)[:, n, :3].T / lasts**order
            out[0][:, here] += start[n][:, None]
        slope = np.radians([shared[named.FLOOR_X], shared[named.FLOOR_Y]])
        hit = end[: self.impact_s.size]
        # a floor whose normal leans to x falls off towards x
        return out, (hit[:, 2] + hit[:, :2] @ slope - shared[named.HEIGHT]) / U_CONTACT_M

    def _flights(self, duration_s: FloatArray, own: FloatArray, shared: Mapping[str, float]) -> CubicHermiteSpline:
        """Return displacements and velocities of all flights over their shares of time, (n_flights, 6).

        a = g - k |v| v by Runge and Kutta's fourth order; it does not depend on the place, so that all go together.

        Raises
        ------
        SolveError
            The unknowns are those of no fall.
        """
        lean = np.radians([shared[named.GRAVITY_X], shared[named.GRAVITY_Y]])
        down = np.array([np.sin(lean[0]), np.sin(lean[1]), -np.cos(np.hypot(*lean))]) * shared[named.GRAVITY]
        k, h = shared[named.DRAG], duration_s[:, None] / _STEPS

        def slope(state: FloatArray) -> FloatArray:
            v = state[:, 3:]
            return np.concatenate([v, down - k * np.linalg.norm(v, axis=1, keepdims=True) * v], axis=1)

        # onset, velocity, impact, velocity, impact, ...
        velocity = np.append(own, 0.0).reshape(-1, 4)[:, :3]
        states = [np.concatenate([np.zeros_like(velocity), velocity], axis=1)]
        with np.errstate(over="ignore", invalid="ignore"):  # a step that goes astray is told below
            for _ in range(_STEPS):
                state = states[-1]
                s1 = slope(state)
                s2 = slope(state + 0.5 * h * s1)
                s3 = slope(state + 0.5 * h * s2)
                states.append(state + h / 6.0 * (s1 + 2.0 * (s2 + s3) + slope(state + h * s3)))
            slopes = [slope(one) * duration_s[:, None] for one in states]
        if not (duration_s > 0.0).all() or not np.isfinite(states[-1]).all():
            raise SolveError("Impacts out of their order are no fall.")
        return CubicHermiteSpline(np.linspace(0.0, 1.0, _STEPS + 1), states, slopes)
