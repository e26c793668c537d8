"""The near field: position from path lengths by the exact bistatic equations."""

from __future__ import annotations

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.geometry.path_length import path_gradient, path_lengths
from radargui.geometry.plane_wave import locate_plane
from radargui.model.arrays import FloatArray

_MAXIMUM_STEPS = 40
_TOLERANCE_M = 1e-12


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
    position = locate_plane(change_m, antennas, release_position_m) if start_m is None else start_m.copy()
    target = path_lengths(release_position_m[:, None], antennas) + change_m
    active = np.flatnonzero(np.isfinite(change_m).all(axis=0) & np.isfinite(position).all(axis=0))
    out = np.full((3, change_m.shape[1]), np.nan)
    current = position[:, active]
    for _ in range(_MAXIMUM_STEPS):
        if active.size == 0:
            break
        residual = target[:, active] - path_lengths(current, antennas)
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
    a = gradient.transpose(2, 0, 1)
    b = residual_m.T[:, :, None]
    if a.shape[1] != 3:
        b = a.transpose(0, 2, 1) @ b
        a = a.transpose(0, 2, 1) @ a
    singular = np.abs(np.linalg.det(a)) < 1e-9
    if singular.any():
        a = np.where(singular[:, None, None], np.eye(3), a)
    step = np.linalg.solve(a, b)[:, :, 0].T
    step[:, singular] = np.nan
    return np.asarray(step)


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
        u of x, y, z in metres, shape (3, n_samples); NaN where the position or u is unknown.
    """
    out = np.full(position_m.shape, np.nan)
    known = np.isfinite(position_m).all(axis=0) & np.isfinite(u_path_m).all(axis=0)
    if not known.any():
        return out
    gradient = path_gradient(position_m[:, known], antennas).transpose(2, 0, 1)
    weight = 1.0 / np.maximum(u_path_m[:, known].T, 1e-15) ** 2
    normal = gradient.transpose(0, 2, 1) @ (gradient * weight[:, :, None])
    covariance = np.linalg.pinv(normal, hermitian=True)
    out[:, known] = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2)).T
    return out
