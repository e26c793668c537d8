"""The near field: position from path lengths by the exact bistatic equations."""

from __future__ import annotations

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.geometry.path_length import path_gradient, path_lengths
from radargui.geometry.plane_wave import locate_plane
from radargui.model.arrays import FloatArray, pieces

_MAXIMUM_STEPS = 40
_TOLERANCE_M = 1e-8  # the next step would be its square over the distance of the antennas
_SINGULAR = 1e-9


def locate_exact(
    change_m: FloatArray,
    antennas: Antennas,
    release_position_m: FloatArray,
    start_m: FloatArray | None = None,
) -> FloatArray:
    """Solve |p - tx| + |p - rx_i| = L_i(release) + dL_i for p by Gauss-Newton, all samples at once.

    Parameters
    ----------
    change_m
        Change of path length from the rest, shape (n_receivers, n_samples); NaN gives NaN.
    antennas
        At least three receivers.
    release_position_m
        Place at rest, shape (3,): fixes the constant of L, of which only changes are observable.
    start_m
        First guess, shape (3, n_samples); the plane-wave solution where left out.

    Returns
    -------
    FloatArray
        Metres, shape (3, n_samples); NaN where no real position has these path lengths.
    """
    position = locate_plane(change_m, antennas, release_position_m) if start_m is None else start_m
    target = path_lengths(release_position_m[:, None], antennas) + change_m
    out = np.full((3, change_m.shape[1]), np.nan)
    for part in pieces(change_m.shape[1]):
        out[:, part] = _located(target[:, part], antennas, position[:, part])
    return out


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


def solve_gradient(gradient: FloatArray, residual_m: FloatArray) -> FloatArray:
    """Return the least-squares dp of gradient dp = dL for each sample; singular samples give NaN.

    Parameters
    ----------
    gradient
        Shape (n_receivers, 3, n_samples).
    residual_m
        Shape (n_receivers, n_samples).
    """
    rows, right = gradient, residual_m
    if gradient.shape[0] != 3:
        rows = np.einsum("ran,rbn->abn", gradient, gradient)
        right = np.einsum("ran,rn->an", gradient, residual_m)
    # Cramer's rule on whole rows: ten times as fast as a solver called for each sample
    products = [_cross(rows[1], rows[2]), _cross(rows[2], rows[0]), _cross(rows[0], rows[1])]
    determinant = (rows[0] * products[0]).sum(axis=0)
    determinant[np.abs(determinant) < _SINGULAR] = np.nan
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
    for part in pieces(position_m.shape[1]):
        out[:, part] = _uncertain(position_m[:, part], u_path_m[:, part], antennas)
    return out


def _uncertain(position_m: FloatArray, u_path_m: FloatArray, antennas: Antennas) -> FloatArray:
    """Return the roots of the diagonal of a symmetric matrix's inverse: cofactors over the determinant."""
    gradient = path_gradient(position_m, antennas)
    xx, yy, zz, xy, yz, zx = (
        (gradient[:, a] * gradient[:, b] / np.maximum(u_path_m, 1e-15) ** 2).sum(axis=0)
        for a, b in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    )
    cofactors = np.stack([yy * zz - yz**2, zz * xx - zx**2, xx * yy - xy**2])
    determinant = xx * cofactors[0] + xy * (yz * zx - xy * zz) + zx * (xy * yz - yy * zx)
    determinant[determinant <= 0.0] = np.nan
    return np.asarray(np.sqrt(np.maximum(cofactors, 0.0) / determinant))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
