"""What the receivers get along one motion: computed where it changes, interpolated between.

Beside the turn of its direct path, exp(i K L), an echo changes over millimetres of the way and not over samples.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from benchmarks.world.drop import Drop
from benchmarks.world.room import Room
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STEP_M, STEP_S = 5e-4, 2e-3
"""Farthest apart along the way and in time: the wave that is mirrored on both ways turns by 0.4 rad in a step."""
MIN_S = 1e-6
"""Breaks nearer than this are one: in it a sphere moves some micrometres."""
_DEGREE = 5
_LOOKED_AT_S = 5e-4


class EchoesAlong:
    """The echoes of a room along a drop, as splines between the breaks of its velocity."""

    def __init__(self, room: Room, drop: Drop) -> None:
        self._room = room
        # a channel that is converted later may see some microseconds more
        ends = [-STEP_S]
        for break_s in sorted({*drop.breaks_s, drop.duration_s + STEP_S}):
            if ends[-1] + MIN_S < break_s < drop.duration_s + 2.0 * STEP_S:
                ends.append(break_s)
        self._breaks_s = np.array(ends[1:-1])
        self._pieces = [self._between(drop, *span) for span in pairwise(ends)]

    def at(self, receiver: int, time_s: Array, place_m: Array) -> Complex:
        """Return the complex signal of a receiver (from 0) at times (n,), the sphere being at places (3, n)."""
        piece = np.searchsorted(self._breaks_s, time_s, side="right")
        slow = np.empty(time_s.size, complex)
        for number in np.unique(piece):
            inside = piece == number
            real, imaginary = self._pieces[number](time_s[inside])[:, receiver].T
            slow[inside] = real + 1j * imaginary
        turns = self._room.sphere.wavenumber_rad_m * self._room.path_m(place_m)[receiver]
        return slow * np.exp(1j * turns)

    def _between(self, drop: Drop, begin_s: float, end_s: float) -> BSpline:
        """Return the spline of one piece: values (n, n_receivers, 2), real and imaginary part without the turn."""
        # at its very ends a piece would show the one beside it
        inside_s = 1e-9 * (end_s - begin_s)
        looked = np.linspace(begin_s + inside_s, end_s - inside_s, max(int((end_s - begin_s) / _LOOKED_AT_S), 8) + 1)
        way = np.linalg.norm(np.diff(drop.position(looked)), axis=0)
        effort = np.concatenate([[0.0], np.cumsum(way / STEP_M + np.diff(looked) / STEP_S)])
        count = max(int(effort[-1]), 3 * _DEGREE) + 1
        nodes = np.interp(np.linspace(0.0, effort[-1], count), effort, looked)
        place = drop.position(nodes)
        paths = self._room.path_m(place)
        values = np.empty((count, len(paths), 2))
        slow = self._room.all_received(place) * np.exp(-1j * self._room.sphere.wavenumber_rad_m * paths)
        values[..., 0], values[..., 1] = slow.real.T, slow.imag.T
        return make_interp_spline(nodes, values, k=_DEGREE)
