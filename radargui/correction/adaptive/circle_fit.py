"""Geometric fit of one receiver's circle: hardware constants, bias map and amplitude map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from radargui.correction.start import StillEllipse
from radargui.model.arrays import FloatArray

_N_CONSTANTS = 5  # offset I, offset Q, ln g, eps, ln A
_CONSTANTS_SD = (0.3, 0.3, 0.15, 0.15, 0.5)
_HUBER = 3.0
_BIAS_SD, _LOG_AMPLITUDE_SD = 0.2, 0.2
_MAXIMUM_STEPS = 25


@dataclass(frozen=True, slots=True)
class CircleData:
    """Bins of one receiver with what the model needs at each.

    Attributes
    ----------
    i, q
        Shape (n_bins,).
    sigma_i, sigma_q
        Standard deviations of them.
    shape
        Known factor of the amplitude: range law times the loss by averaging over a moving phase.
    bias, level
        Map functions of bias and log amplitude at the bins, shapes (n_bins, n_functions).
    """

    i: FloatArray
    q: FloatArray
    sigma_i: FloatArray
    sigma_q: FloatArray
    shape: FloatArray
    bias: FloatArray
    level: FloatArray


@dataclass(frozen=True, slots=True)
class CircleFit:
    """A fitted circle.

    Attributes
    ----------
    theta
        Offset I, offset Q, ln g, eps, ln A, then the coefficients of bias I, bias Q and log amplitude.
    covariance
        Of theta.
    log_evidence
        Laplace approximation.
    chi_square
        Mean square of the residuals in standard deviations, robust.
    """

    theta: FloatArray
    covariance: FloatArray
    log_evidence: float
    chi_square: float

    @classmethod
    def still(cls, ellipse: StillEllipse) -> CircleFit:
        """Return an ellipse as a fit without maps, of unknown quality."""
        amplitude = np.log(max(ellipse.amplitude, 0.05))
        theta = np.array([ellipse.offset_i, ellipse.offset_q, ellipse.log_gain, ellipse.skew_rad, amplitude])
        return cls(theta, np.zeros((theta.size, theta.size)), -np.inf, np.inf)

    @property
    def ellipse(self) -> StillEllipse:
        """The constants alone."""
        offset_i, offset_q, log_gain, skew, log_amplitude = self.theta[:_N_CONSTANTS]
        return StillEllipse(offset_i, offset_q, log_gain, skew, float(np.exp(log_amplitude)))

    def point(self, i: FloatArray, q: FloatArray, bias: FloatArray) -> FloatArray:
        """Return X, Y without offset, bias, gain ratio and quadrature error, shape (2, n)."""
        n = bias.shape[1]
        w_i, w_q = self.theta[_N_CONSTANTS : _N_CONSTANTS + n], self.theta[_N_CONSTANTS + n : _N_CONSTANTS + 2 * n]
        return _unskew(i - self.theta[0] - bias @ w_i, q - self.theta[1] - bias @ w_q, self.theta[2], self.theta[3])

    def amplitude(self, shape: FloatArray, level: FloatArray) -> FloatArray:
        """Return the amplitude, shape (n,)."""
        return _amplitude(self.theta, shape, level)

    def phase_variance(self, data: CircleData) -> FloatArray:
        """Return the variance of each bin's phase from noise and from the fit, shape (n_bins,)."""
        x, y = self.point(data.i, data.q, data.bias)
        radius = np.hypot(x, y)
        columns = _columns(self.theta, data, x, y, tangential=True) / radius[:, None]
        fitted = np.einsum("ij,jk,ik->i", columns, self.covariance, columns)
        noise = ((data.sigma_i * y) ** 2 + (data.sigma_q * np.exp(-self.theta[2]) * x) ** 2) / radius**4
        return np.asarray(noise + fitted)


def fit_circle(data: CircleData, start: FloatArray, home: FloatArray) -> CircleFit:
    """Fit r = |z| / A - 1 - sigma^2 / (2 A^2) by damped Gauss-Newton with robust weights.

    z = X + iY with X = I - b_I, Y = ((Q - b_Q) / g - X sin eps) / cos eps. Constants keep near `home`, the map
    coefficients N(0, sd^2) with sd re-estimated (MacKay 1992) so that a map nobody needs vanishes.

    Parameters
    ----------
    data
        The bins.
    start
        First guess of theta.
    home
        Prior means of the five constants: a still ellipse is never far from the truth, a map's freedom can be.
    """
    n_bias, n_level = data.bias.shape[1], data.level.shape[1]
    mean = np.concatenate([home, np.zeros(2 * n_bias + n_level)])
    sd = np.concatenate([_CONSTANTS_SD, np.full(2 * n_bias, _BIAS_SD), np.full(n_level, _LOG_AMPLITUDE_SD)])
    fit = _minimise(data, start, mean, sd)
    groups = [slice(5, 5 + 2 * n_bias), slice(5 + 2 * n_bias, None)]
    for _ in range(2 if n_bias + n_level else 0):
        for group in groups:
            _update_deviation(sd, fit, group)
        fit = _minimise(data, fit.theta, mean, sd)
    return fit


def _update_deviation(sd: FloatArray, fit: CircleFit, group: slice) -> None:
    """Re-estimate the common deviation of a group of coefficients: sd^2 = sum w^2 / number well determined."""
    w = fit.theta[group]
    if w.size == 0:
        return
    determined = w.size - np.trace(fit.covariance[group, group]) / sd[group.start] ** 2
    sd[group] = float(np.clip(np.sqrt((w @ w + 1e-4) / max(determined, 0.5)), 2e-3, 0.5))


def _minimise(data: CircleData, theta: FloatArray, mean: FloatArray, sd: FloatArray) -> CircleFit:
    precision = 1.0 / sd**2
    damping = 1e-3
    at = _evaluate(theta, data, mean, precision)
    normal, slope = _normal(at, data, mean, precision)
    for _ in range(_MAXIMUM_STEPS):
        damped = normal.copy()
        damped.flat[:: theta.size + 1] *= 1.0 + damping
        trial = at.theta + dposv(damped, -slope)[1]  # positive definite by its priors
        trial[2:4] = np.clip(trial[2:4], -0.5, 0.5)
        trial_at = _evaluate(trial, data, mean, precision)
        if trial_at.cost < at.cost:
            gained = at.cost - trial_at.cost
            at = trial_at
            normal, slope = _normal(at, data, mean, precision)
            damping = max(damping / 10.0, 1e-9)
            if gained < 0.02:
                break
        else:
            damping *= 10.0
            if damping > 1e4:
                break
    covariance: FloatArray = np.asarray(np.linalg.inv(normal))
    evidence = -at.cost - 0.5 * np.linalg.slogdet(normal)[1] + 0.5 * float(np.log(precision).sum())
    return CircleFit(at.theta, covariance, evidence, float((at.weight * at.residual**2).mean()))


@dataclass(frozen=True, slots=True)
class _Evaluated:
    """The circle at a theta: cost, residual in standard deviations, robust weights, and what the slope needs."""

    theta: FloatArray
    cost: float
    residual: FloatArray
    weight: FloatArray
    point: FloatArray
    radius: FloatArray
    sigma_v: FloatArray


def _evaluate(theta: FloatArray, data: CircleData, mean: FloatArray, precision: FloatArray) -> _Evaluated:
    n = data.bias.shape[1]
    u = data.i - theta[0] - data.bias @ theta[5 : 5 + n]
    v = data.q - theta[1] - data.bias @ theta[5 + n : 5 + 2 * n]
    x, y = point = _unskew(u, v, theta[2], theta[3])
    radius = np.sqrt(x * x + y * y)
    amplitude = _amplitude(theta, data.shape, data.level)
    sigma = np.sqrt((x * data.sigma_i) ** 2 + (y * data.sigma_q * np.exp(-theta[2])) ** 2) / radius / amplitude
    residual = (radius / amplitude - 1.0 - 0.5 * sigma**2) / sigma
    size = np.abs(residual)
    weight = np.minimum(1.0, _HUBER / np.maximum(size, _HUBER))
    loss = np.where(size < _HUBER, 0.5 * size**2, _HUBER * size - 0.5 * _HUBER**2).sum()
    cost = float(loss + 0.5 * (precision * (theta - mean) ** 2).sum())
    return _Evaluated(theta, cost, residual, weight, point, radius, amplitude * sigma)


def _normal(at: _Evaluated, data: CircleData, mean: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the normal matrix and the slope of the cost."""
    columns = _columns(at.theta, data, *at.point, tangential=False)
    columns[:, 4] = -at.radius
    columns[:, 5 + 2 * data.bias.shape[1] :] = -at.radius[:, None] * data.level
    root = np.sqrt(at.weight)
    columns *= (root / at.sigma_v)[:, None]
    normal = columns.T @ columns
    normal.flat[:: precision.size + 1] += precision
    return normal, columns.T @ (root * at.residual) + precision * (at.theta - mean)


def _columns(theta: FloatArray, data: CircleData, x: FloatArray, y: FloatArray, *, tangential: bool) -> FloatArray:
    """Return the derivative of the radial (or tangential) coordinate of z with respect to theta."""
    n = data.bias.shape[1]
    radius = np.sqrt(x * x + y * y)
    along_x, along_y = (-y / radius, x / radius) if tangential else (x / radius, y / radius)
    gain, tangent, cosine = np.exp(theta[2]), np.tan(theta[3]), np.cos(theta[3])
    d_i = -(along_x - along_y * tangent)
    d_q = -along_y / (gain * cosine)
    out = np.zeros((x.size, theta.size))
    out[:, 0], out[:, 1] = d_i, d_q
    out[:, 2] = -along_y * (y + x * tangent)
    out[:, 3] = along_y * (-x + y * tangent)
    out[:, 5 : 5 + n] = d_i[:, None] * data.bias
    out[:, 5 + n : 5 + 2 * n] = d_q[:, None] * data.bias
    return out


def _unskew(u: FloatArray, v: FloatArray, log_gain: float, skew: float) -> FloatArray:
    return np.stack([u, (v * np.exp(-log_gain) - u * np.sin(skew)) / np.cos(skew)])


def _amplitude(theta: FloatArray, shape: FloatArray, level: FloatArray) -> FloatArray:
    coefficients = theta[theta.size - level.shape[1] :] if level.shape[1] else np.zeros(0)
    return np.asarray(shape * np.exp(theta[4] + level @ coefficients))
