"""A receiver whose I and Q are swapped, told from a fall: its path changes as if the sphere fell upwards."""

from __future__ import annotations

import numpy as np

from radargui.geometry.path_length import path_gradient, place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.setup import Setup

WINDOW_S = 0.08
"""Of a parabola; two in turn, the second half a window later, take 0.12 s: a fall of 7 cm. By hand."""
NEAR = 0.25
"""Share by which the acceleration may be off: it changes with the height."""
WORST_M = 0.3e-3
"""Root mean square about the parabola: a hand that throws does not push evenly. By hand."""


class FallsUpwards:
    """Looks for stretches with the acceleration of gravity, or with its opposite.

    Parameters
    ----------
    setup
        Antennas, release, floor's normal.
    rate_hz
        Of the path lengths.
    """

    def __init__(self, setup: Setup, rate_hz: float) -> None:
        release = np.array(setup.tracer.release_position_m)[:, None]
        gradient = path_gradient(release, place_antennas(setup))[:, :, 0]
        self._expected = gradient @ -np.array(setup.floor.normal) * NOMINAL_GRAVITY_M_S2
        self._hop = max(4, round(0.5 * WINDOW_S * rate_hz))
        time = np.arange(2 * self._hop) / rate_hz
        time -= time.mean()
        self._basis = np.stack([np.ones(time.size), time, time**2 - np.mean(time**2)])
        self._power = (self._basis**2).sum(axis=1)
        self._falls = np.zeros(setup.n_receivers, dtype=np.bool_)
        self.begin()

    def begin(self) -> None:
        """Forget the motion before: another one begins. A receiver that fell downwards once is not asked again."""
        self._held = np.empty((self._falls.size, 0))
        self._before = np.zeros(self._falls.size)

    def push(self, change_m: FloatArray) -> int | None:
        """Take the next changes of path length, shape (n_receivers, n); return a receiver that fell upwards."""
        if self._falls.all():
            return None
        self._held = np.concatenate([self._held, change_m], axis=1)
        while self._held.shape[1] >= 2 * self._hop:
            share = self._share(self._held[:, : 2 * self._hop])
            self._held = self._held[:, self._hop :]
            downwards, upwards = (
                (np.abs(share - sign) < NEAR) & (np.abs(self._before - sign) < NEAR) for sign in (1.0, -1.0)
            )
            self._before = share
            self._falls |= downwards
            found = np.flatnonzero(upwards & ~self._falls)
            if found.size:
                return int(found[0])
        return None

    def _share(self, change_m: FloatArray) -> FloatArray:
        """Return the acceleration over that of a fall, shape (n_receivers,); 0 where it was no parabola."""
        weights = change_m @ self._basis.T / self._power
        misfit = np.sqrt(np.mean((change_m - weights @ self._basis) ** 2, axis=1))
        return np.asarray(np.where(misfit < WORST_M, 2.0 * weights[:, 2] / self._expected, 0.0))
