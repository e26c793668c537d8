"""Place antennas and their images; compute path lengths, their gradient and the plane-wave solution.

Locate the tracer in the near field, by the exact bistatic equations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, IntArray, pieces
from radargui.model.setup import Setup

HALF_FIELD_M = 0.15
"""Half an edge of the field of view, 30 x 30 x 30 cm round the origin."""
MIN_RECEIVERS = 3
"""Path lengths that a position in space needs."""
LARGE_CONDITION = 20.0
"""An error of path length then grows twenty times in the position: 0.1 mm become 2 mm, as much as is measured."""


@dataclass(frozen=True, slots=True)
class Antennas:
    """Places of the antennas in the frame of the field of view.

    Attributes
    ----------
    transmitter_m
        Shape (3,).
    receivers_m
        Shape (n_receivers, 3).
    """

    transmitter_m: FloatArray
    receivers_m: FloatArray

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return int(self.receivers_m.shape[0])


def place_antennas(setup: Setup) -> Antennas:
    """Return the antennas of a setup.

    Receiver i stands at distance (sin tilt cos azimuth, sin tilt sin azimuth, cos tilt), the transmitter on +z
    (Rech & Huang 2019, fig. 1) or where `position_m` says.
    """
    return antennas_at(receiver_values(setup), np.array(setup.transmitter.place_m))


def receiver_values(setup: Setup) -> FloatArray:
    """Return tilt and azimuth (degrees) and distance (m) of each receiver's phase centre, shape (3, n_receivers)."""
    return np.array([(one.tilt_deg, one.azimuth_deg, one.reach_m) for one in setup.receiver]).T


def antennas_at(receivers: FloatArray, transmitter_m: FloatArray) -> Antennas:
    """Return the antennas by tilt, azimuth and distance of each receiver, (3, n_receivers), see `place_antennas`."""
    tilt, azimuth = np.radians(receivers[:2])
    # tilt from the z axis, azimuth from x towards y
    direction = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=1)
    return Antennas(transmitter_m, receivers[2][:, None] * direction)


def path_lengths(position_m: FloatArray, antennas: Antennas) -> FloatArray:
    """Return L_i = |p - tx| + |p - rx_i| (Ott, Herminghaus & Huang 2017, eq. 1).

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    antennas
        n_receivers of them.

    Returns
    -------
    FloatArray
        Metres, shape (n_receivers, n_samples).
    """
    to_transmitter = distance(position_m - antennas.transmitter_m[:, None])
    return np.stack([to_transmitter + distance(position_m - own[:, None]) for own in antennas.receivers_m])


def path_gradient(position_m: FloatArray, antennas: Antennas) -> FloatArray:
    """Return dL_i/dp: the sum of the unit vectors from the antennas to the tracer.

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    antennas
        n_receivers of them.

    Returns
    -------
    FloatArray
        No unit, shape (n_receivers, 3, n_samples).
    """
    # the way there is common to all receivers: once
    unit_transmitter = position_m - antennas.transmitter_m[:, None]
    unit_transmitter /= distance(unit_transmitter)
    out = np.empty((antennas.n_receivers, *position_m.shape))
    for row, own in zip(out, antennas.receivers_m, strict=True):
        np.subtract(position_m, own[:, None], out=row)
        row /= distance(row)
        row += unit_transmitter
    return out


def range_factor(position_m: FloatArray, antennas: Antennas, release_m: FloatArray) -> FloatArray:
    """Return 1 / (r_tx r_rx) over its value at release: how the amplitude falls with the ways there and back.

    Radar equation of a small sphere: the field falls as the inverse of both distances (Balanis, Antenna Theory).

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    antennas
        n_receivers of them.
    release_m
        Where the factor is one, shape (3,).

    Returns
    -------
    FloatArray
        No unit, shape (n_receivers, n_samples).
    """

    def product(place: FloatArray) -> FloatArray:
        to_receiver = np.linalg.norm(place[None] - antennas.receivers_m[:, :, None], axis=1)
        return np.asarray(to_receiver * np.linalg.norm(place - antennas.transmitter_m[:, None], axis=0))

    return np.asarray(product(release_m[:, None]) / product(position_m))


def distance(away_m: FloatArray) -> FloatArray:
    """Return the lengths of vectors (3, n), shape (n,)."""
    x, y, z = away_m
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def t_matrix(antennas: Antennas) -> FloatArray:
    """Return T with rows [sin t cos a, sin t sin a, 1 + cos t] (Rech & Huang 2019, eq. 2).

    Returns
    -------
    FloatArray
        No unit, shape (n_receivers, 3).
    """
    to_receiver = antennas.receivers_m / np.linalg.norm(antennas.receivers_m, axis=1, keepdims=True)
    # for a transmitter on the axis (0, 0, 1), which gives the 1 + cos t
    to_transmitter = antennas.transmitter_m / np.linalg.norm(antennas.transmitter_m)
    return np.asarray(to_receiver + to_transmitter)


def condition_number(antennas: Antennas) -> float:
    """Return the condition number of T: how much an error of L can grow in the position."""
    return float(np.linalg.cond(t_matrix(antennas)))


def locate_plane(change_m: FloatArray, antennas: Antennas, release_position_m: FloatArray) -> FloatArray:
    """Return p = p_release - T^-1 dL (Rech & Huang 2019, eq. 3); least squares with more than three receivers.

    Parameters
    ----------
    change_m
        Change of path length from the rest, shape (n_receivers, n_samples); NaN gives NaN.
    antennas
        At least three receivers.
    release_position_m
        Place at rest, shape (3,).

    Returns
    -------
    FloatArray
        Metres, shape (3, n_samples).
    """
    # T^-1 for three receivers, least squares for four
    inverse = np.linalg.pinv(t_matrix(antennas))
    return np.asarray(release_position_m[:, None] - inverse @ change_m)


def mirror(point_m: FloatArray, normal: FloatArray, distance_m: float) -> FloatArray:
    """Return a' = a - 2 (n.a - d) n, the image of points in the plane n.x = d.

    Parameters
    ----------
    point_m
        Shape (..., 3).
    normal
        Unit vector, shape (3,).
    distance_m
        d of the plane.
    """
    height = np.asarray(point_m) @ normal - distance_m
    return np.asarray(point_m - 2.0 * height[..., None] * normal)


_MAXIMUM_STEPS = 40  # of Newton; each doubles the digits: what needs more does not converge (chosen by hand)
_TOLERANCE_M = 1e-8  # the next step would be its square over the distance of the antennas
_SINGULAR, _SINGULAR_SQUARES = 1e-9, 1e-11
"""Determinants of J, whose rows are at most 2 long, and of J^T J, from which on there is a solution.

In 60 000 places in one plane with all antennas both are 0. Rounding leaves up to 1.3e-14 of the first, and with four
receivers 4.3e-14 of the second: 1e-5 of its bound, and half a per cent. The second is the square of the first; where no
path tells the sides, their rows of 0.03 alone make it 1e-6 (chosen by hand).
"""
_SIDEWAYS, _FALLING_STEPS = 0.03, 8  # a metre aside against one of path: enough where no path tells; the steps converge
_NEIGHBOURS, _PIECE = 8, 1 << 14  # places whose J is one, and how many of these are looked at together
_MAX_CONDITION = 1e4
"""Of the antennas' places seen from the transmitter, for places to be known to 1e-12 of their distance at once."""


def locate_exact(
    change_m: FloatArray, antennas: Antennas, release_position_m: FloatArray, start_m: FloatArray | None = None
) -> FloatArray:
    """Solve |p - tx| + |p - rx_i| = L_i(release) + dL_i for p, all samples at once.

    Three receivers that do not lie in one plane with the transmitter have a closed solution; others are solved by
    Gauss-Newton.

    Parameters
    ----------
    change_m
        Change of path length from the rest, shape (n_receivers, n_samples); NaN gives NaN.
    antennas
        At least three receivers.
    release_position_m
        Place at rest, shape (3,): fixes the constant of L, of which only changes are observable.
    start_m
        First guess, shape (3, n_samples); the plane-wave solution if left out. Of two places with the same path lengths
        the nearer one is taken.

    Returns
    -------
    FloatArray
        Metres, shape (3, n_samples); NaN where no real position has these path lengths.
    """
    from_transmitter = antennas.receivers_m - antennas.transmitter_m
    closed = antennas.n_receivers == 3 and np.linalg.cond(from_transmitter) < _MAX_CONDITION
    at_rest = path_lengths(release_position_m[:, None], antennas)
    start = locate_plane(change_m, antennas, release_position_m) if start_m is None else start_m
    solve, out = _intersected if closed else _located, np.empty((3, change_m.shape[1]))
    for part in pieces(change_m.shape[1]):
        out[:, part] = solve(at_rest + change_m[:, part], antennas, start[:, part])
    return out


def _intersected(target_m: FloatArray, antennas: Antennas, start_m: FloatArray) -> FloatArray:
    """Return the intersection of three ellipsoids that share the transmitter as a focus.

    With q = p - tx, R = |q| and b_i = rx_i - tx, |q - b_i| = L_i - R squared is 2 b_i . q = |b_i|^2 - L_i^2 + 2 L_i R:
    q is a line in R, and |q|^2 = R^2 a quadratic equation.
    """
    receivers = antennas.receivers_m - antennas.transmitter_m
    inverse = 0.5 * np.linalg.inv(receivers)
    level = inverse @ ((receivers**2).sum(axis=1)[:, None] - target_m**2)
    along = inverse @ (2.0 * target_m)
    slant, half, rest = _dot(along, along), _dot(level, along), _dot(level, level)
    square, shortest = slant - 1.0, target_m.min(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        # without the difference of nearly equal numbers; where there is no real root it is none in what follows either
        sum_of_two = -(half + np.copysign(np.sqrt(half**2 - square * rest), half))
        # where the line passes nearest to the guess
        guess = (_dot(along, start_m - antennas.transmitter_m[:, None]) - half) / slant
        one, other = sum_of_two / square, rest / sum_of_two
        # of two places the nearer to the guess, none without a guess
        further = np.abs(other - guess) - np.abs(one - guess)
        near, far = np.where(further > 0.0, one, other), np.where(further > 0.0, other, one)
        # neither way may be shorter than nothing
        far[(far < 0.0) | (far > shortest)] = np.nan
        away = np.where((near >= 0.0) & (near <= shortest), near, far)
    away[np.isnan(guess)] = np.nan
    return np.asarray(antennas.transmitter_m[:, None] + level + along * away)


def _located(target_m: FloatArray, antennas: Antennas, start_m: FloatArray) -> FloatArray:
    active = np.flatnonzero(np.isfinite(target_m).all(axis=0) & np.isfinite(start_m).all(axis=0))
    out = np.full(start_m.shape, np.nan)
    current = start_m[:, active]
    for _ in range(_MAXIMUM_STEPS):
        if active.size == 0:
            break
        residual = target_m[:, active] - path_lengths(current, antennas)
        step = solve_gradient(path_gradient(current, antennas), residual)
        current = current + step
        settled = np.abs(step).max(axis=0) < _TOLERANCE_M
        lost = ~np.isfinite(current).all(axis=0)
        out[:, active[settled]] = current[:, settled]
        keep = ~(settled | lost)
        active, current = active[keep], current[:, keep]
    return out


def locate_falling(
    change_m: FloatArray, antennas: Antennas, release_position_m: FloatArray, normal: FloatArray
) -> FloatArray:
    """Return places that have the path lengths of one or two receivers, as near to the line of fall as these allow.

    Parameters
    ----------
    change_m
        Change of path length from the rest, shape (n_receivers, n_samples).
    antennas
        These receivers; of three or more the paths decide.
    release_position_m, normal
        Where the fall begins, and its direction reversed, shape (3,).

    Returns
    -------
    FloatArray
        Metres, shape (3, n_samples).
    """
    release = release_position_m[:, None]
    target = path_lengths(release, antennas) + change_m
    sideways = _SIDEWAYS * (np.eye(3) - np.outer(normal, normal))
    rows = np.broadcast_to(sideways[:, :, None], (3, 3, change_m.shape[1]))
    place = np.repeat(release, change_m.shape[1], axis=1)
    for _ in range(_FALLING_STEPS):
        gradient = np.concatenate([path_gradient(place, antennas), rows])
        residual = np.concatenate([target - path_lengths(place, antennas), sideways @ (release - place)])
        place = place + solve_gradient(gradient, residual)
    return place


def solve_gradient(gradient: FloatArray, residual_m: FloatArray) -> FloatArray:
    """Return the least-squares dp of gradient dp = dL for each sample; singular samples give NaN.

    Parameters
    ----------
    gradient
        Shape (n_receivers, 3, n_samples).
    residual_m
        Shape (n_receivers, n_samples).
    """
    rows, right, least = gradient, residual_m, _SINGULAR
    if gradient.shape[0] != 3:
        rows, least = _normal(gradient), _SINGULAR_SQUARES
        right = np.einsum("ran,rn->an", gradient, residual_m)
    # Cramer's rule on whole rows: ten times as fast as a solver called for each sample
    products, determinant = _cofactors(rows, least)
    return np.asarray((right[0] * products[0] + right[1] * products[1] + right[2] * products[2]) / determinant)


def position_uncertainty(position_m: FloatArray, u_path_m: FloatArray, antennas: Antennas) -> FloatArray:
    """Carry independent standard uncertainties of L through the bistatic Jacobian.

    Cov(p) = (J^T W J)^-1 with J = dL/dp and W = diag(1 / u_L^2).

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    u_path_m
        Shape (n_receivers, n_samples), above zero.
    antennas
        At least three receivers.

    Returns
    -------
    FloatArray
        u of x, y, z in metres, shape (3, n_samples); NaN where the position or u is unknown, or J is singular.
    """
    out = np.full(position_m.shape, np.nan)
    known = np.flatnonzero(np.isfinite(position_m).all(axis=0))
    # where u_L stays, only J changes: among eight neighbours by parts in a thousand
    alike = _NEIGHBOURS if (u_path_m == u_path_m[:, :1]).all() else 1
    for part in pieces(known.size, alike * _PIECE):
        place: IntArray | slice = part if known.size == position_m.shape[1] else known[part]
        there = _uncertain(position_m[:, place][:, ::alike], u_path_m[:, place][:, ::alike], antennas)
        for row, own in zip(out, there, strict=True):
            row[place] = np.repeat(own, alike)[: part.stop - part.start]
    return out


def _uncertain(position_m: FloatArray, u_path_m: FloatArray, antennas: Antennas) -> FloatArray:
    """Return the roots of the diagonal of (J^T W J)^-1."""
    gradient = path_gradient(position_m, antennas)
    if antennas.n_receivers == 3:
        # J^-1 U J^-T: its rows are cross products of those of J over the determinant
        columns, determinant = _cofactors(gradient, _SINGULAR)
        square = (columns[0] * u_path_m[0]) ** 2
        for column, u in zip(columns[1:], u_path_m[1:], strict=True):
            square += (column * u) ** 2
        return np.asarray(np.sqrt(square) / np.abs(determinant))
    # whether J is singular is decided without weights, whose determinant has the unit 1 / u^6
    _, single = _cofactors(_normal(gradient), _SINGULAR_SQUARES)
    products, determinant = _cofactors(_normal(gradient / np.maximum(u_path_m, 1e-15)[:, None]), 0.0)
    determinant[(determinant <= 0.0) | np.isnan(single)] = np.nan
    return np.stack([np.sqrt(np.maximum(products[k][k], 0.0) / determinant) for k in range(3)])


def _normal(gradient: FloatArray) -> FloatArray:
    """Return J^T J of gradients (n_receivers, 3, n), shape (3, 3, n)."""
    return np.asarray(np.einsum("ran,rbn->abn", gradient, gradient))


def _cofactors(rows: FloatArray, least: float) -> tuple[list[FloatArray], FloatArray]:
    """Return the cross products of each two of three rows (3, 3, n), and the determinant, NaN below the least."""
    products = [_cross(rows[k - 2], rows[k - 1]) for k in range(3)]
    determinant = _dot(rows[0], products[0])
    determinant[np.abs(determinant) < least] = np.nan
    return products, determinant


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("an,an->n", a, b))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    out = np.empty_like(a)
    for row, (k, m) in enumerate(((1, 2), (2, 0), (0, 1))):
        np.multiply(a[k], b[m], out=out[row])
        out[row] -= a[m] * b[k]
    return out
