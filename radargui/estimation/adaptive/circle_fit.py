"""Fit one receiver's circle geometrically: constants, bias map and amplitude map."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg.lapack import dposv, dpotrf, dpotri

from radargui.estimation.adaptive.circle_layout import CIRCLE, CircleLayout, CircleSettings
from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError
from radargui.model.front_end import point_of, slopes_of_point
from radargui.signals.ellipse import Ellipse


@dataclass(frozen=True, slots=True)
class CircleData:
    """The bins of one receiver, with the values that the model needs at each.

    Attributes
    ----------
    i, q
        Shape (n_bins,).
    sigma_i, sigma_q
        Standard deviations of them.
    shape
        Known factor of the amplitude: the range factor times the loss by averaging over a turning phase.
    bias, amplitude_map
        Functions of the maps at the bins, shapes (n_bins, n_functions), best column by column in memory.
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
        The unknowns, and their places in theta.
    covariance
        Of theta.
    log_evidence
        Laplace approximation.
    chi_square
        Mean square of the residuals in standard deviations, robust.
    deviation
        Deviation of the prior of each unknown, shape as theta.
    """

    layout: CircleLayout
    theta: FloatArray
    covariance: FloatArray
    log_evidence: float
    chi_square: float
    deviation: FloatArray

    @classmethod
    def still(cls, ellipse: Ellipse) -> CircleFit:
        """Return a constant ellipse as a fit without maps and of unknown quality."""
        layout = CircleLayout(0, 0)
        theta = np.empty(layout.size)
        theta[layout.offset_i], theta[layout.offset_q] = ellipse.i0_v, ellipse.q0_v
        theta[layout.log_gain] = np.log(ellipse.gain_ratio)
        theta[layout.quadrature_error] = ellipse.quadrature_error_rad
        theta[layout.log_amplitude] = np.log(max(ellipse.amplitude_v, CIRCLE.min_amplitude))
        return cls(layout, theta, np.zeros((theta.size, theta.size)), -np.inf, np.inf, np.zeros(theta.size))

    def deviation_of(self, layout: CircleLayout) -> FloatArray:
        """Return the deviations of the priors for maps of other functions, shape (layout.size,)."""
        out, own = np.empty(layout.size), self.layout
        out[layout.constants] = self.deviation[own.constants]
        # one deviation a map, whatever its functions are: it says how large bias and change of amplitude are
        for new, was in ((layout.bias, own.bias), (layout.amplitude_map, own.amplitude_map)):
            out[new] = self.deviation[was.start]
        return out

    @property
    def ellipse(self) -> Ellipse:
        """The constants alone."""
        at, theta = self.layout, self.theta
        return Ellipse(
            float(theta[at.offset_i]),
            float(theta[at.offset_q]),
            float(np.exp(theta[at.log_amplitude])),
            float(np.exp(theta[at.log_gain])),
            float(theta[at.quadrature_error]),
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
        rows = _rows(self.theta, data, (x, y), (-y / radius, x / radius), 1.0 / radius)
        own = self.covariance[: len(rows), : len(rows)]
        fitted = np.einsum("ij,ij->j", own @ rows, rows)
        # Q is divided by g, and its noise with it; eps is left out: six degrees change the variance by a tenth, up and
        # down within a fringe
        sigma_y = data.sigma_q * np.exp(-self.theta[self.layout.log_gain])
        # noise along the circle, through the slopes of arctan; then what the fit leaves open
        return np.asarray(((data.sigma_i * y) ** 2 + (sigma_y * x) ** 2) / radius**4 + fitted)


def fit_circle(
    data: CircleData,
    start: FloatArray,
    prior_mean: FloatArray,
    deviation: FloatArray | None = None,
    updates: int | None = None,
    settings: CircleSettings = CIRCLE,
) -> CircleFit:
    """Fit r = |z| / A - 1 - sigma^2 / (2 A^2) by damped Gauss-Newton with robust weights.

    z = X + iY with X = I - b_I, Y = ((Q - b_Q) / g - X sin eps) / cos eps. Constants keep near their prior means.
    Coefficients of the maps have the prior N(0, s^2) with s re-estimated (MacKay 1992), so that a map that the data do
    not need vanishes.

    Parameters
    ----------
    data
        The bins.
    start
        First guess of theta, shape (layout.size,).
    prior_mean
        Prior means of the constants, shape (5,): a constant ellipse is never far from the truth, while a map may be.
    deviation
        Deviations of the priors, as another fit has found them.
    updates
        How often the deviations are re-estimated; None: as the settings say.
    settings
        Priors and stops.

    Raises
    ------
    SolveError
        The normal matrix is not positive definite.
    """
    layout = data.layout
    # maps around zero: what bends a circle has to be asked for by the samples
    mean, sd = np.zeros(layout.size), np.empty(layout.size)
    mean[layout.constants] = prior_mean
    sd[layout.offset_i] = sd[layout.offset_q] = settings.offset
    sd[layout.log_gain], sd[layout.quadrature_error] = settings.log_gain, settings.quadrature_error_rad
    sd[layout.log_amplitude] = settings.log_amplitude
    sd[layout.bias], sd[layout.amplitude_map] = settings.bias, settings.log_amplitude_map
    if deviation is not None:
        sd = deviation.copy()
    groups = [places for places in (layout.bias, layout.amplitude_map) if places.stop > places.start]
    updates = settings.updates if updates is None else updates
    fit, at = _minimise(_evaluate(start, data, settings), mean, sd, settings)
    for _ in range(updates if groups else 0):
        for group in groups:
            sd[group] = _updated_deviation(float(sd[group.start]), fit, group, settings)
        fit, at = _minimise(at, mean, sd, settings)
    return fit


def _updated_deviation(sd: float, fit: CircleFit, group: slice, settings: CircleSettings) -> float:
    """Return the common deviation of a group of coefficients: s^2 = sum w^2 / number well determined."""
    w = fit.theta[group]
    determined = w.size - np.trace(fit.covariance[group, group]) / sd**2
    # MacKay 1992: s^2 is the mean square of as many coefficients as the data determine
    wanted = np.sqrt((w @ w + 1e-4) / max(determined, 0.5))  # neither may vanish by rounding
    return float(np.clip(wanted, settings.min_deviation, settings.max_deviation))


def _minimise(
    at: _Evaluated, mean: FloatArray, sd: FloatArray, settings: CircleSettings
) -> tuple[CircleFit, _Evaluated]:
    sd = sd.copy()
    layout, precision = at.data.layout, 1.0 / sd**2
    # the first step alone: a start may be far off, later ones are near the minimum
    damping = settings.first_damping
    cost, (normal, slope) = at.cost(mean, precision), at.with_priors(mean, precision)
    for _ in range(settings.steps):
        damped = normal.copy()
        damped.flat[:: sd.size + 1] *= 1.0 + damping
        _, step, failed = dposv(damped, -slope)  # positive definite by its priors
        if failed:
            raise SolveError("The circle of a receiver cannot be fitted: its normal matrix is not positive definite.")
        # it would end here if it gained no more than its slope says
        if -0.5 * float(slope @ step) < settings.worth * settings.close:
            break
        trial = at.theta + step
        # tan eps has a pole: a step across it never comes back
        trial[layout.front_end] = np.clip(trial[layout.front_end], -settings.furthest, settings.furthest)
        trial_at = _evaluate(trial, at.data, settings)
        trial_cost = trial_at.cost(mean, precision)
        gained = cost - trial_cost
        if gained > 0.0:
            at, cost = trial_at, trial_cost
        # after a last step so small the normal matrix is still that before it
        if abs(gained) < settings.close or damping > settings.max_damping:
            break
        if gained > 0.0:
            normal, slope = at.with_priors(mean, precision)
            # undamped near the minimum: what is held by priors alone would creep there
            damping = damping / settings.damping_factor if damping > settings.first_damping else 0.0
        else:
            damping = max(damping * settings.damping_factor, settings.first_damping)
    factor, _ = dpotrf(normal)
    upper, _ = dpotri(factor)
    covariance: FloatArray = np.triu(upper) + np.triu(upper, 1).T
    # Laplace: -cost - ln det H / 2, and the priors' norms, or maps would be free
    evidence = -cost - float(np.log(np.diagonal(factor)).sum()) + 0.5 * float(np.log(precision).sum())
    # by the robust weights: an impulse is no misfit of the circle
    chi_square = float((at.weight * at.residual**2).mean())
    return CircleFit(layout, at.theta, covariance, evidence, chi_square, sd), at


@dataclass(frozen=True)
class _Evaluated:
    """The circle at a theta: robust loss, residual in standard deviations, its weights, and what the slope needs."""

    theta: FloatArray
    data: CircleData
    loss: float
    residual: FloatArray
    weight: FloatArray
    point: FloatArray
    radius: FloatArray
    sigma_radius: FloatArray

    @cached_property
    def of_bins(self) -> tuple[FloatArray, FloatArray]:
        """Normal matrix and slope of the loss."""
        x, y = self.point
        root = np.sqrt(self.weight)
        weight, along = root / self.sigma_radius, (x / self.radius, y / self.radius)
        rows = _rows(self.theta, self.data, (x, y), along, weight, -self.radius * weight)
        return rows @ rows.T, rows @ (root * self.residual)

    def cost(self, mean: FloatArray, precision: FloatArray) -> float:
        """Return the loss with that of the priors."""
        return self.loss + 0.5 * float(precision @ (self.theta - mean) ** 2)

    def with_priors(self, mean: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the normal matrix and the slope of the cost."""
        normal, slope = self.of_bins
        return normal + np.diag(precision), slope + precision * (self.theta - mean)


def _evaluate(theta: FloatArray, data: CircleData, settings: CircleSettings) -> _Evaluated:
    x, y = point = _point(theta, data.layout, data.i, data.q, data.bias)
    radius = np.sqrt(x * x + y * y)
    amplitude = _amplitude(theta, data)
    sigma_y = data.sigma_q * np.exp(-theta[CircleLayout.log_gain])
    # a step may lead to where nothing is a number: its cost is none either, and it is not taken
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        sigma = np.sqrt((x * data.sigma_i) ** 2 + (y * sigma_y) ** 2) / radius / amplitude
        # noise across the radius lengthens it by sigma^2 / 2 on average: without that a weak echo's circle would grow
        residual = (radius / amplitude - 1.0 - 0.5 * sigma**2) / sigma
        size, huber = np.abs(residual), settings.huber_sigmas
        weight, inner = huber / np.maximum(size, huber), np.minimum(size, huber)
        return _Evaluated(
            theta, data, float(inner @ (size - 0.5 * inner)), residual, weight, point, radius, amplitude * sigma
        )


def _rows(
    theta: FloatArray,
    data: CircleData,
    point: tuple[FloatArray, FloatArray],
    along: tuple[FloatArray, FloatArray],
    weight: FloatArray,
    by_amplitude: FloatArray | None = None,
) -> FloatArray:
    """Return the weighed derivatives of z along a direction at each bin, one row an unknown, shape (n, n_bins).

    Parameters
    ----------
    theta, data
        Unknowns and bins.
    point, along
        X and Y, and the direction, each of two rows.
    weight
        Of each bin.
    by_amplitude
        Weighed derivative with respect to the log of the amplitude. Without it there are no rows of the amplitude's
        map, the last ones, and that of the amplitude is zero.
    """
    layout, (x, y), (along_x, along_y) = data.layout, point, along
    gain, error = float(np.exp(theta[layout.log_gain])), float(theta[layout.quadrature_error])
    y_by_i, y_by_q, y_by_log_gain, y_by_error = slopes_of_point(x, y, gain, error)
    # X has I alone, Y both: the quadrature error mixes them (`point_of`)
    along_y = along_y * weight
    by_i = along_y * y_by_i - along_x * weight
    by_q = along_y * y_by_q
    out = np.empty((layout.amplitude_map.start if by_amplitude is None else layout.size, x.size))
    out[layout.offset_i], out[layout.offset_q] = by_i, by_q
    np.multiply(along_y, y_by_log_gain, out=out[layout.log_gain])
    np.multiply(along_y, y_by_error, out=out[layout.quadrature_error])
    out[layout.log_amplitude] = 0.0 if by_amplitude is None else by_amplitude
    np.multiply(by_i, data.bias.T, out=out[layout.bias_i])
    np.multiply(by_q, data.bias.T, out=out[layout.bias_q])
    if by_amplitude is not None:
        np.multiply(by_amplitude, data.amplitude_map.T, out=out[layout.amplitude_map])
    return out


def _centre(theta: FloatArray, layout: CircleLayout, bias: FloatArray) -> FloatArray:
    offset = theta[[layout.offset_i, layout.offset_q], None]
    return np.asarray(offset + theta[layout.bias].reshape(2, -1) @ bias.T)


def _point(theta: FloatArray, layout: CircleLayout, i: FloatArray, q: FloatArray, bias: FloatArray) -> FloatArray:
    of_i, of_q = _centre(theta, layout, bias)
    return point_of(i - of_i, q - of_q, float(np.exp(theta[layout.log_gain])), float(theta[layout.quadrature_error]))


def _amplitude(theta: FloatArray, data: CircleData) -> FloatArray:
    log_amplitude = theta[CircleLayout.log_amplitude] + data.amplitude_map @ theta[data.layout.amplitude_map]
    return np.asarray(data.shape * np.exp(log_amplitude))
