"""Falls as known motions: gravity is known and straight, and all impacts lie on one floor (method 6, Calibration)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

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
"""Of a flight: off by 0.3 um after 0.25 s with a drag of 0.06 1/m (integrated to 1e-12), below `U_CONTACT_M`."""


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

        The latter in standard deviations, shape (n_impacts,).
        """
        series, off = self._series(time_s, shared, own[None], orders=3)
        return series[:, 0], off[0]

    def places(
        self, time_s: FloatArray, shared: Mapping[str, float | FloatArray], own: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return places and what the impacts are off the floor for some values at once, (n_values, ...) as in `at`."""
        series, off = self._series(time_s, shared, own, orders=1)
        return series[0], off

    def _series(
        self, time_s: FloatArray, shared: Mapping[str, float | FloatArray], own: FloatArray, orders: int
    ) -> tuple[FloatArray, FloatArray]:
        def of(name: str) -> FloatArray:
            return np.broadcast_to(shared[name], len(own))

        place = np.stack([of(f"{self.place}.{axis}") for axis in "xyz"], axis=1)
        begin_s = np.concatenate([own[:, :1], own[:, 4::4]], axis=1)
        duration_s = np.diff(begin_s, axis=1, append=self.end_s + 0.01)
        # two small leanings: the direction's length is one but for their fourth powers
        lean = np.radians([of(named.GRAVITY_X), of(named.GRAVITY_Y)])
        down = np.array([*np.sin(lean), -np.cos(np.hypot(*lean))]).T * of(named.GRAVITY)[:, None]
        # onset, velocity, impact, velocity, impact, ...
        velocity = np.pad(own[:, 1:], ((0, 0), (0, 1))).reshape(len(own), -1, 4)[:, :, :3]
        states, slopes = _flights(duration_s, velocity, down, of(named.DRAG))
        # each flight starts where the one before it ended
        end = np.cumsum(states[-1, :, :, :3], axis=1) + place[:, None]
        start = np.concatenate([place[:, None], end[:, :-1]], axis=1)
        # after its last flight it counts as at rest: what it does there is not asked, and must not be far away
        number, over = (time_s[:, None] >= begin_s[:, None]).sum(axis=2) - 1, time_s > self.end_s
        here = np.arange(len(own))[:, None], np.maximum(number, 0)
        still = ((number < 0) | over)[:, :, None]
        share = _STEPS * (time_s - begin_s[here]) / duration_s[here]
        step = np.clip(share.astype(np.intp), 0, _STEPS - 1)
        # cubic between steps: y1 + s r + s (1 - s) w, w = (1 - s) (k1 - r) + s (r - k2), r = y2 - y1 (Hermite)
        first, last, k1, k2 = (one[(step + k, *here)][..., :3] for one in (states, slopes / _STEPS) for k in (0, 1))
        s, rise = (share - step)[:, :, None], last - first
        bend, turn = (1.0 - s) * (k1 - rise) + s * (rise - k2), 2.0 * rise - k1 - k2
        rest = np.where(over[:, None], end[:, -1:], place[:, None])
        out = [np.where(still, rest, start[here] + first + s * rise + s * (1.0 - s) * bend)]
        if orders > 1:
            per_s = (_STEPS / duration_s[here])[:, :, None]
            out.append(np.where(still, 0.0, per_s * (rise + (1.0 - 2.0 * s) * bend + s * (1.0 - s) * turn)))
            out.append(np.where(still, 0.0, 2.0 * per_s**2 * ((1.0 - 2.0 * s) * turn - bend)))
        hit = end[:, : self.impact_s.size].transpose(2, 1, 0)
        # a floor whose normal leans to x falls off towards x
        below = hit[0] * np.radians(of(named.FLOOR_X)) + hit[1] * np.radians(of(named.FLOOR_Y)) - of(named.HEIGHT)
        return np.array(out).transpose(0, 1, 3, 2), (hit[2] + below).T / U_CONTACT_M


def _flights(
    duration_s: FloatArray, velocity: FloatArray, down: FloatArray, drag: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return displacements and velocities at the steps of all flights, and what they change by in a flight's time.

    a = g - k |v| v by Runge and Kutta's fourth order; it does not depend on the place, so that all go together.

    Parameters
    ----------
    duration_s, velocity
        Of each flight, shapes (n_values, n_flights) and (n_values, n_flights, 3).
    down, drag
        g and k, shapes (n_values, 3) and (n_values,).

    Returns
    -------
    states, slopes
        Shape (n_steps + 1, n_values, n_flights, 6).

    Raises
    ------
    SolveError
        The unknowns are those of no fall.
    """
    g, k, h = down[:, None], drag[:, None, None], duration_s[:, :, None] / _STEPS

    def slope(state: FloatArray) -> FloatArray:
        v = state[..., 3:]
        return np.concatenate([v, g - k * np.sqrt((v * v).sum(axis=-1, keepdims=True)) * v], axis=-1)

    states = [np.concatenate([np.zeros_like(velocity), velocity], axis=-1)]
    with np.errstate(over="ignore", invalid="ignore"):  # a step that goes astray is caught below
        for _ in range(_STEPS):
            state = states[-1]
            s1 = slope(state)
            s2 = slope(state + 0.5 * h * s1)
            s3 = slope(state + 0.5 * h * s2)
            states.append(state + h / 6.0 * (s1 + 2.0 * (s2 + s3) + slope(state + h * s3)))
        all_states = np.array(states)
        slopes = slope(all_states) * duration_s[:, :, None]
    if not (duration_s > 0.0).all() or not np.isfinite(all_states[-1]).all():
        raise SolveError("Impacts out of their order are no fall.")
    return all_states, slopes
