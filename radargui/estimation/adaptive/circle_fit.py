"""Geometric fit of one receiver's circle: constants, bias map and amplitude map (method 2, adaptive)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.linalg.lapack import dposv

from radargui.estimation.adaptive.still_ellipse import StillEllipse
from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError
from radargui.model.front_end_equations import point_of


@dataclass(frozen=True, slots=True)
class CircleSettings:
    """Priors and stops of the fit; amplitudes are those of the scaled samples, about one. Chosen by hand.

    Attributes
    ----------
    offset, log_gain, quadrature_error_rad, log_amplitude
        Deviations of the constants around their prior means, wide enough for any front end of the field.
    bias, log_amplitude_map
        Deviations of the maps' coefficients before they are re-estimated.
    least_deviation, most_deviation
        Between which they are re-estimated: below the first a map is switched off.
    updates
        So often are they re-estimated.
    furthest
        |ln g| and |eps| never leave this: far outside of what `correction.quality` lets pass, so that an estimate at
        this bound is refused.
    huber_sigmas
        Beyond so many standard deviations a residual counts by its size, not its square.
    first_damping, least_damping, most_damping, damping_factor
        Of Gauss-Newton, as shares of the diagonal (Marquardt 1963).
    steps, close
        At most so many, and none after one that gains less in ln likelihood.
    least_amplitude
        Of a still ellipse as a start.
    """

    offset: float = 0.3
    log_gain: float = 0.15
    quadrature_error_rad: float = 0.15
    log_amplitude: float = 0.5
    bias: float = 0.2
    log_amplitude_map: float = 0.2
    least_deviation: float = 2e-3
    most_deviation: float = 0.5
    updates: int = 2
    furthest: float = 0.8
    huber_sigmas: float = 3.0
    first_damping: float = 1e-3
    least_damping: float = 1e-9
    most_damping: float = 1e4
    damping_factor: float = 10.0
    steps: int = 25
    close: float = 0.02
    least_amplitude: float = 0.05


CIRCLE = CircleSettings()


@dataclass(frozen=True, slots=True)
class CircleLayout:
    """Places of a circle's unknowns in theta: five constants, then the coefficients of its maps.

    Attributes
    ----------
    n_bias, n_amplitude_map
        Numbers of functions of each bias map and of the map of log amplitude.
    """

    offset_i: ClassVar[int] = 0
    offset_q: ClassVar[int] = 1
    log_gain: ClassVar[int] = 2
    quadrature_error: ClassVar[int] = 3
    log_amplitude: ClassVar[int] = 4
    front_end: ClassVar[slice] = slice(2, 4)
    constants: ClassVar[slice] = slice(0, 5)

    n_bias: int
    n_amplitude_map: int

    @property
    def bias_i(self) -> slice:
        """Coefficients of the bias of I."""
        return slice(5, 5 + self.n_bias)

    @property
    def bias_q(self) -> slice:
        """Coefficients of the bias of Q."""
        return slice(5 + self.n_bias, 5 + 2 * self.n_bias)

    @property
    def bias(self) -> slice:
        """Coefficients of both."""
        return slice(5, 5 + 2 * self.n_bias)

    @property
    def amplitude_map(self) -> slice:
        """Coefficients of the map of log amplitude."""
        return slice(5 + 2 * self.n_bias, self.size)

    @property
    def size(self) -> int:
        """Length of theta."""
        return 5 + 2 * self.n_bias + self.n_amplitude_map


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
        Known factor of the amplitude: range factor times the loss by averaging over a moving phase.
    bias, amplitude_map
        Functions of the maps at the bins, shapes (n_bins, n_functions).
    """

    i: FloatArray
    q: FloatArray
    sigma_i: FloatArray
    sigma_q: FloatArray
    shape: FloatArray
    bias: FloatArray
    amplitude_map: FloatArray

    @property
    def layout(self) -> CircleLayout:
        """Where the unknowns of its circle stand."""
        return CircleLayout(self.bias.shape[1], self.amplitude_map.shape[1])


@dataclass(frozen=True, slots=True)
class CircleFit:
    """A fitted circle.

    Attributes
    ----------
    layout, theta
        The unknowns and where they stand.
    covariance
        Of theta.
    log_evidence
        Laplace approximation.
    chi_square
        Mean square of the residuals in standard deviations, robust.
    """

    layout: CircleLayout
    theta: FloatArray
    covariance: FloatArray
    log_evidence: float
    chi_square: float

    @classmethod
    def still(cls, ellipse: StillEllipse) -> CircleFit:
        """Return an ellipse as a fit without maps, of unknown quality."""
        layout = CircleLayout(0, 0)
        theta = np.empty(layout.size)
        theta[layout.offset_i], theta[layout.offset_q] = ellipse.offset_i, ellipse.offset_q
        theta[layout.log_gain], theta[layout.quadrature_error] = ellipse.log_gain, ellipse.quadrature_error_rad
        theta[layout.log_amplitude] = np.log(max(ellipse.amplitude, CIRCLE.least_amplitude))
        return cls(layout, theta, np.zeros((theta.size, theta.size)), -np.inf, np.inf)

    @property
    def ellipse(self) -> StillEllipse:
        """The constants alone."""
        at, theta = self.layout, self.theta
        return StillEllipse(
            float(theta[at.offset_i]),
            float(theta[at.offset_q]),
            float(theta[at.log_gain]),
            float(theta[at.quadrature_error]),
            float(np.exp(theta[at.log_amplitude])),
        )

    def centre(self, bias: FloatArray) -> FloatArray:
        """Return offset plus bias of I and Q for map functions (n, n_functions), shape (2, n)."""
        return _centre(self.theta, self.layout, bias)

    def point(self, i: FloatArray, q: FloatArray, bias: FloatArray) -> FloatArray:
        """Return X, Y without offset, bias, gain ratio and quadrature error, shape (2, n)."""
        return _point(self.theta, self.layout, i, q, bias)

    def amplitude(self, data: CircleData) -> FloatArray:
        """Return the amplitude, shape (n_bins,)."""
        return _amplitude(self.theta, data)

    def phase_variance(self, data: CircleData) -> FloatArray:
        """Return the variance of each bin's phase from noise and from the fit, shape (n_bins,)."""
        x, y = self.point(data.i, data.q, data.bias)
        radius = np.hypot(x, y)
        columns = _columns(self.theta, data, x, y, tangential=True) / radius[:, None]
        fitted = np.einsum("ij,jk,ik->i", columns, self.covariance, columns)
        sigma_y = data.sigma_q * np.exp(-self.theta[self.layout.log_gain])
        # noise along the circle, through the slopes of arctan; then what the fit leaves open
        return np.asarray(((data.sigma_i * y) ** 2 + (sigma_y * x) ** 2) / radius**4 + fitted)


def fit_circle(
    data: CircleData, start: FloatArray, prior_mean: FloatArray, settings: CircleSettings = CIRCLE
) -> CircleFit:
    """Fit r = |z| / A - 1 - sigma^2 / (2 A^2) by damped Gauss-Newton with robust weights.

    z = X + iY with X = I - b_I, Y = ((Q - b_Q) / g - X sin eps) / cos eps. Constants keep near their prior means, the
    map coefficients N(0, s^2) with s re-estimated (MacKay 1992) so that a map nobody needs vanishes.

    Parameters
    ----------
    data
        The bins.
    start
        First guess of theta, shape (layout.size,).
    prior_mean
        Of the constants, shape (5,): a still ellipse is never far from the truth, a map's freedom can be.
    settings
        Priors and stops.

    Raises
    ------
    SolveError
        The normal matrix is not positive definite.
    """
    layout = data.layout
    mean, sd = np.zeros(layout.size), np.empty(layout.size)
    mean[layout.constants] = prior_mean
    sd[layout.offset_i] = sd[layout.offset_q] = settings.offset
    sd[layout.log_gain], sd[layout.quadrature_error] = settings.log_gain, settings.quadrature_error_rad
    sd[layout.log_amplitude] = settings.log_amplitude
    sd[layout.bias], sd[layout.amplitude_map] = settings.bias, settings.log_amplitude_map
    fit = _minimise(data, start, mean, sd, settings)
    groups = [places for places in (layout.bias, layout.amplitude_map) if places.stop > places.start]
    for _ in range(settings.updates if groups else 0):
        for group in groups:
            sd[group] = _updated_deviation(float(sd[group.start]), fit, group, settings)
        fit = _minimise(data, fit.theta, mean, sd, settings)
    return fit


def _updated_deviation(sd: float, fit: CircleFit, group: slice, settings: CircleSettings) -> float:
    """Return the common deviation of a group of coefficients: s^2 = sum w^2 / number well determined."""
    w = fit.theta[group]
    determined = w.size - np.trace(fit.covariance[group, group]) / sd**2
    # MacKay 1992: s^2 is the mean square of as many coefficients as the data determine
    wanted = np.sqrt((w @ w + 1e-4) / max(determined, 0.5))  # neither may vanish by rounding
    return float(np.clip(wanted, settings.least_deviation, settings.most_deviation))


def _minimise(
    data: CircleData, theta: FloatArray, mean: FloatArray, sd: FloatArray, settings: CircleSettings
) -> CircleFit:
    layout, precision = data.layout, 1.0 / sd**2
    damping = settings.first_damping
    at = _evaluate(theta, data, mean, precision, settings)
    normal, slope = _normal(at, data, mean, precision)
    for _ in range(settings.steps):
        damped = normal.copy()
        damped.flat[:: theta.size + 1] *= 1.0 + damping
        _, step, failed = dposv(damped, -slope)  # positive definite by its priors
        if failed:
            raise SolveError("The circle of a receiver cannot be fitted: its normal matrix is not positive definite.")
        trial = at.theta + step
        # tan eps has a pole: a step across it never comes back
        trial[layout.front_end] = np.clip(trial[layout.front_end], -settings.furthest, settings.furthest)
        trial_at = _evaluate(trial, data, mean, precision, settings)
        if trial_at.cost < at.cost:
            gained = at.cost - trial_at.cost
            at = trial_at
            normal, slope = _normal(at, data, mean, precision)
            damping = max(damping / settings.damping_factor, settings.least_damping)
            if gained < settings.close:
                break
        else:
            damping *= settings.damping_factor
            if damping > settings.most_damping:
                break
    covariance: FloatArray = np.asarray(np.linalg.inv(normal))
    evidence = -at.cost - 0.5 * np.linalg.slogdet(normal)[1] + 0.5 * float(np.log(precision).sum())
    return CircleFit(layout, at.theta, covariance, evidence, float((at.weight * at.residual**2).mean()))


@dataclass(frozen=True, slots=True)
class _Evaluated:
    """The circle at a theta: cost, residual in standard deviations, robust weights, and what the slope needs."""

    theta: FloatArray
    cost: float
    residual: FloatArray
    weight: FloatArray
    point: FloatArray
    radius: FloatArray
    sigma_radius: FloatArray


def _evaluate(
    theta: FloatArray, data: CircleData, mean: FloatArray, precision: FloatArray, settings: CircleSettings
) -> _Evaluated:
    x, y = point = _point(theta, data.layout, data.i, data.q, data.bias)
    radius = np.sqrt(x * x + y * y)
    amplitude = _amplitude(theta, data)
    sigma_y = data.sigma_q * np.exp(-theta[CircleLayout.log_gain])
    # a step may lead to where nothing is a number: its cost is none either, and it is not taken
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        sigma = np.sqrt((x * data.sigma_i) ** 2 + (y * sigma_y) ** 2) / radius / amplitude
        residual = (radius / amplitude - 1.0 - 0.5 * sigma**2) / sigma
        size, huber = np.abs(residual), settings.huber_sigmas
        weight = np.minimum(1.0, huber / np.maximum(size, huber))
        loss = np.where(size < huber, 0.5 * size**2, huber * size - 0.5 * huber**2).sum()
        cost = float(loss + 0.5 * (precision * (theta - mean) ** 2).sum())
        return _Evaluated(theta, cost, residual, weight, point, radius, amplitude * sigma)


def _normal(at: _Evaluated, data: CircleData, mean: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the normal matrix and the slope of the cost."""
    layout = data.layout
    columns = _columns(at.theta, data, *at.point, tangential=False)
    columns[:, layout.log_amplitude] = -at.radius
    columns[:, layout.amplitude_map] = -at.radius[:, None] * data.amplitude_map
    root = np.sqrt(at.weight)
    columns *= (root / at.sigma_radius)[:, None]
    normal = columns.T @ columns
    normal.flat[:: precision.size + 1] += precision
    return normal, columns.T @ (root * at.residual) + precision * (at.theta - mean)


def _columns(theta: FloatArray, data: CircleData, x: FloatArray, y: FloatArray, *, tangential: bool) -> FloatArray:
    """Return the derivative of the radial (or tangential) coordinate of z with respect to theta."""
    layout = data.layout
    radius = np.sqrt(x * x + y * y)
    along_x, along_y = (-y / radius, x / radius) if tangential else (x / radius, y / radius)
    gain, error = np.exp(theta[layout.log_gain]), theta[layout.quadrature_error]
    tangent, cosine = np.tan(error), np.cos(error)
    by_i = -(along_x - along_y * tangent)
    by_q = -along_y / (gain * cosine)
    out = np.zeros((x.size, theta.size))
    out[:, layout.offset_i], out[:, layout.offset_q] = by_i, by_q
    out[:, layout.log_gain] = -along_y * (y + x * tangent)
    out[:, layout.quadrature_error] = along_y * (-x + y * tangent)
    out[:, layout.bias_i] = by_i[:, None] * data.bias
    out[:, layout.bias_q] = by_q[:, None] * data.bias
    return out


def _centre(theta: FloatArray, layout: CircleLayout, bias: FloatArray) -> FloatArray:
    return np.stack(
        [
            theta[layout.offset_i] + bias @ theta[layout.bias_i],
            theta[layout.offset_q] + bias @ theta[layout.bias_q],
        ]
    )


def _point(theta: FloatArray, layout: CircleLayout, i: FloatArray, q: FloatArray, bias: FloatArray) -> FloatArray:
    of_i, of_q = _centre(theta, layout, bias)
    return point_of(i - of_i, q - of_q, float(np.exp(theta[layout.log_gain])), float(theta[layout.quadrature_error]))


def _amplitude(theta: FloatArray, data: CircleData) -> FloatArray:
    log_amplitude = theta[CircleLayout.log_amplitude] + data.amplitude_map @ theta[data.layout.amplitude_map]
    return np.asarray(data.shape * np.exp(log_amplitude))
