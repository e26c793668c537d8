"""What lobes make of the direct wave and of mirrors: an image sees the tracer by another part of its lobe.

Method 4, Mirrors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.forward.parameters import N_LOBE
from radargui.model.arrays import FloatArray
from radargui.physics.mirrors import MirrorPlane, has_floor

LOBE_UNITS = np.array([0.3, 0.1, 0.1])  # m, 1, 1: in which functions of a lobe count, so that their factors are alike
_MAX_LOBE = 10.0  # a reflection that changes e^10-fold is none, and a mirror that hardly reflects does not tell it
_SIDE_LOBE = 0.1  # of horns and small arrays, field over that on the axis (Balanis, Antenna Theory, 13.3)


@dataclass(frozen=True, slots=True)
class Lobes:
    """How the lobes of transmitter and receiver change the direct wave and what mirrors add, against the release.

    Of several receivers all shapes begin with their number.

    Attributes
    ----------
    axis
        Where antennas and images point to, shape (2, 1 + n_mirrors, 3).
    q, q_rest
        1 - cos of the angle from there, (2, 1 + n_mirrors, n) at the nodes and (2, 1 + n_mirrors, 1) at the release.
    functions
        What the mirrors' factors multiply, shape (2, n_mirrors, N_LOBE, n).
    direct
        What the last two of the first factors multiply on the direct way, shape (2, 2, n).
    factors
        As theta has them: directly and over a floor, then over each wall, shape (2, 1 + n_walls, N_LOBE).
    """

    axis: FloatArray
    q: FloatArray
    q_rest: FloatArray
    functions: FloatArray
    direct: FloatArray
    factors: FloatArray

    def exponents(self) -> FloatArray:
        """Return the log of what they do to each mirror's reflection, (2, n_mirrors, n)."""
        exponents = (self._of_mirrors[..., None, :] @ self.functions)[..., 0, :]
        exponents[..., self.n_floors :, :] -= self.factors[..., :1, 1:] @ self.direct
        return np.clip(exponents, -_MAX_LOBE, _MAX_LOBE)

    @property
    def n_floors(self) -> int:
        """How many mirrors, none or one, share the direct wave's factors."""
        return 1 + int(self.functions.shape[-3]) - int(self.factors.shape[-2])

    @property
    def _of_mirrors(self) -> FloatArray:
        """The factors of each mirror, shape (2, n_mirrors, N_LOBE)."""
        return self.factors[..., 1 - self.n_floors :, :]

    def of_direct(self) -> FloatArray:
        """Return what they multiply the direct wave with, (n,)."""
        exponent = (self.factors[..., :1, 1:] @ self.direct).sum(axis=(-3, -2))
        return np.asarray(np.exp(np.clip(exponent, -_MAX_LOBE, _MAX_LOBE)))

    def by_angle(self) -> tuple[FloatArray, FloatArray]:
        """Return the slopes of the exponents by each mirror's q and by minus q at release, (2, n_mirrors, n)."""
        a, b = np.moveaxis((self._of_mirrors / LOBE_UNITS)[..., 1:, None], -2, 0)
        # over a wall the difference counts, over a floor each by itself
        now = self.q[..., 1:, :] - self.q_rest[..., 1:, :]
        rest = now.copy()
        if self.n_floors:
            now[..., 0, :], rest[..., 0, :] = self.q[..., 1, :], self.q_rest[..., 1, :]
        return a + 2.0 * b * now, a + 2.0 * b * rest

    def by_factors(self, over: FloatArray) -> FloatArray:
        """Return the slopes by the factors, (2, 1 + n_walls, N_LOBE, n), of what comes directly and over each mirror.

        Parameters
        ----------
        over
            Shape (2, 1 + n_mirrors, n).
        """
        out = np.zeros((*self.factors.shape, over.shape[-1]))
        out[..., 1 - self.n_floors :, :, :] = over[..., 1:, None, :] * self.functions
        # over a wall the direct lobe is taken off again
        out[..., 0, 1:, :] += over[..., : 1 + self.n_floors, :].sum(axis=-2)[..., None, :] * self.direct
        return out


def lobes_at(
    node_m: FloatArray,
    length_m: FloatArray,
    antenna_m: FloatArray,
    mirrors: tuple[tuple[MirrorPlane, ...], FloatArray],
    release_m: FloatArray,
    factors: FloatArray,
) -> Lobes:
    """Return what tells how an antenna's lobe sees the tracer over each mirror, against what it sees directly.

    A lobe is an even function of the angle from its axis: ln s = a q + b q^2, q = 1 - cos theta, the same directly and
    over a floor; over a wall another part of it sees the tracer, ln s = a' dq + b' dq^2 from the release. Antennas
    point to the origin; one that is turned a little from there adds what goes with height.

    Parameters
    ----------
    node_m, length_m, antenna_m
        Shapes (3, n), (2, 1 + n_mirrors, n), (2, 1 + n_mirrors, 3), see `Waves`; of several receivers with their number
        first.
    mirrors
        Planes and their unknowns, (n_mirrors, 3).
    release_m
        Where every exponent is zero.
    factors
        Of height and the angle's two functions, shape (2, 1 + n_walls, N_LOBE).
    """
    axis = axis_of(antenna_m[..., 0, :])
    over = [plane.turned(axis, one) for plane, one in zip(*mirrors, strict=True)]
    axes = np.stack([axis, *over], axis=-2)
    q, q_rest = off_axis(axes, antenna_m, node_m[..., None, :, :], length_m, release_m)
    change = q - q_rest
    out = np.empty((*axis.shape[:-1], len(over), N_LOBE, node_m.shape[-1]))
    out[..., 0, :] = ((node_m[..., 2, :] - release_m[2]) / LOBE_UNITS[0])[..., None, None, :]
    np.multiply(change[..., 1:, :], 1.0 / LOBE_UNITS[1], out=out[..., 1, :])
    np.multiply(change[..., 1:, :], change[..., 1:, :] / LOBE_UNITS[2], out=out[..., 2, :])
    # even functions of the angle itself: of the direct wave, and of a floor's
    few = slice(0, 2 if has_floor(mirrors[0]) else 1)
    first = change[..., few, :]
    squares = first * (q[..., few, :] + q_rest[..., few, :])
    even = np.stack([first / LOBE_UNITS[1], squares / LOBE_UNITS[2]], axis=-2)
    direct = even[..., 0, :, :]
    if few.stop > 1:
        out[..., 0, 1:, :] = even[..., 1, :, :] - direct
    return Lobes(axes, q, q_rest, out, direct, factors)


def strength_change(exponent: float, q: FloatArray, q_rest: FloatArray) -> FloatArray:
    """Return ln s against that at the release, see `main_lobe`."""
    now, rest = (np.clip(1.0 - one, 1e-3, None) ** (2.0 * exponent) + _SIDE_LOBE**2 for one in (q, q_rest))
    return np.asarray(0.5 * np.log(now / rest))


def main_lobe(exponent: FloatArray, q: FloatArray) -> FloatArray:
    """Return d ln s / dq, shape as q, of s = |(1 - q)^exponent + j 0.1|: a main lobe on side lobes of -20 dB."""
    square = np.clip(1.0 - q, 1e-3, None) ** (2.0 * exponent)
    return np.asarray(-exponent * square / (square + _SIDE_LOBE**2) / np.clip(1.0 - q, 1e-3, None))


def axis_of(antenna_m: FloatArray) -> FloatArray:
    """Return where antennas point to, shape (..., 3): to the origin."""
    return np.asarray(-antenna_m / np.linalg.norm(antenna_m, axis=-1, keepdims=True))


def off_axis(
    axis: FloatArray, antenna_m: FloatArray, node_m: FloatArray, length_m: FloatArray, release_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return q = 1 - cos theta of nodes, (..., n), and of the release, (..., 1), seen by antennas (..., 3)."""
    before = (axis * antenna_m).sum(axis=-1, keepdims=True)
    rest_m = np.linalg.norm(release_m - antenna_m, axis=-1, keepdims=True)
    return 1.0 + (before - axis @ node_m) / length_m, 1.0 + (before - (axis @ release_m)[..., None]) / rest_m
