"""The smooth map: offset and amplitude of one receiver as splines of its path length, with their prior."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray

SPAN_M = (-0.30, 0.90)
"""Path lengths, counted from the rest, that the map covers; beyond, its ends hold."""
KNOT_M = 0.06
OFFSET_LENGTH_M = 0.12
AMPLITUDE_LENGTH_M = 0.25
OFFSET_SD = 0.10
AMPLITUDE_SD = 0.30
HARDWARE_SD = 0.05


class SmoothMap:
    """A state of three splines (offset of I, offset of Q, log amplitude) and two constants (gain ratio, eps in rad).

    Cubic B-splines with knots every 6 cm of path; the prior of their coefficients is a Gaussian process of kernel
    s^2 exp(-d^2 / 2 l^2), l = 12 cm of path for the offsets and 25 cm for the amplitude.

    Attributes
    ----------
    prior
        Covariance of the state before anything is known, shape (n_state, n_state).
    """

    def __init__(self) -> None:
        self._n_pieces = round((SPAN_M[1] - SPAN_M[0]) / KNOT_M)
        self._n = self._n_pieces + 3
        self.prior = self._prior()

    def mean(self) -> FloatArray:
        """Return the state before anything is known: no offset, amplitude 1, a perfect mixer; shape (n_state,)."""
        state = np.zeros(3 * self._n + 2)
        state[-2] = 1.0
        return state

    def parts(self, state: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the coefficients of the three splines, shape (n,) each."""
        n = self._n
        return state[:n], state[n : 2 * n], state[2 * n : 3 * n]

    def basis(self, length_m: FloatArray) -> FloatArray:
        """Return the basis of uniform cubic B-splines at path lengths (n_samples,), shape (n_samples, n)."""
        place = np.clip((length_m - SPAN_M[0]) / KNOT_M, 0.0, self._n_pieces - 1e-9)
        piece = place.astype(np.intp)
        t = place - piece
        left = 1.0 - t
        # products: a power of an array takes numpy ten times as long
        cube, left_cube = t * t * t, left * left * left
        out = np.zeros((length_m.size, self._n))
        row = np.arange(length_m.size)
        out[row, piece] = left_cube / 6.0
        out[row, piece + 1] = (3.0 * cube - 6.0 * t * t + 4.0) / 6.0
        out[row, piece + 2] = (3.0 * left_cube - 6.0 * left * left + 4.0) / 6.0
        out[row, piece + 3] = cube / 6.0
        return out

    def _prior(self) -> FloatArray:
        n = self._n
        place = KNOT_M * np.arange(n)
        away = (place[:, None] - place) ** 2
        out = np.zeros((3 * n + 2, 3 * n + 2))
        out[:n, :n] = out[n : 2 * n, n : 2 * n] = OFFSET_SD**2 * np.exp(-0.5 * away / OFFSET_LENGTH_M**2)
        out[2 * n : 3 * n, 2 * n : 3 * n] = AMPLITUDE_SD**2 * np.exp(-0.5 * away / AMPLITUDE_LENGTH_M**2)
        out[-2, -2] = out[-1, -1] = HARDWARE_SD**2
        return out
