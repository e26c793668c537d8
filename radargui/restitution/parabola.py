"""Parabolas through flights, gravity shared or free, with uncertainties that know of correlated residuals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.motion.impacts import THIRD_DIFFERENCE_GAIN
from radargui.restitution.settings import TRACKS


@dataclass(frozen=True, slots=True)
class Parabolas:
    """h_k(t) = h0_k + v0_k (t - t0_k) - g (t - t0_k)^2 / 2 for flights k = 1 ... n.

    Attributes
    ----------
    origin_s
        t0_k, shape (n_flights,).
    height_m, speed_m_s
        h0_k and v0_k, shape (n_flights,).
    g_m_s2
        Deceleration along the height, shared.
    covariance
        Of (h0_1, v0_1, h0_2, ..., v0_n, g), shape (2 n + 1, 2 n + 1).
    residual_rms_m
        Root mean square of the residuals.
    """

    origin_s: FloatArray
    height_m: FloatArray
    speed_m_s: FloatArray
    g_m_s2: float
    covariance: FloatArray
    residual_rms_m: float

    @property
    def u_g_m_s2(self) -> float:
        """Standard uncertainty of g."""
        return float(np.sqrt(self.covariance[-1, -1]))

    def height_at(self, flight: int, time_s: float) -> float:
        """Return the height of a flight's parabola at an instant."""
        d = time_s - self.origin_s[flight]
        return float(self.height_m[flight] + self.speed_m_s[flight] * d - 0.5 * self.g_m_s2 * d * d)

    def speed_at(self, flight: int, time_s: float) -> float:
        """Return the speed of a flight's parabola at an instant."""
        return float(self.speed_m_s[flight] - self.g_m_s2 * (time_s - self.origin_s[flight]))

    def height_gradient(self, flight: int, time_s: float) -> FloatArray:
        """Return d height / d parameters, shape (2 n + 1,)."""
        d = time_s - self.origin_s[flight]
        out = np.zeros(self.covariance.shape[0])
        out[2 * flight], out[2 * flight + 1], out[-1] = 1.0, d, -0.5 * d * d
        return out

    def speed_gradient(self, flight: int, time_s: float) -> FloatArray:
        """Return d speed / d parameters, shape (2 n + 1,)."""
        out = np.zeros(self.covariance.shape[0])
        out[2 * flight + 1], out[-1] = 1.0, -(time_s - self.origin_s[flight])
        return out


def fit_parabolas(stretches: Sequence[tuple[FloatArray, FloatArray]]) -> Parabolas:
    """Fit one parabola a flight with g shared, by least squares.

    The covariance is that of white residuals of the observed size, times their correlation length in samples and
    widened where they are not white (each flight its own): residuals of a mismatch are waves, not noise.

    Parameters
    ----------
    stretches
        Per flight times in s and heights in m, each of shape (n_samples,), at least four samples.
    """
    n = len(stretches)
    origin, blocks = parabola_design([time for time, _ in stretches])
    design = np.concatenate(blocks)
    heights = np.concatenate([height for _, height in stretches])
    solution, *_ = np.linalg.lstsq(design, heights, rcond=None)
    residual = heights - design @ solution
    # sandwich A^-1 B A^-1: each flight has residuals of its own size (White 1980)
    inverse = np.linalg.inv(design.T @ design)
    meat = np.zeros_like(inverse)
    begin = 0
    for block in blocks:
        own = residual[begin : begin + block.shape[0]]
        begin += block.shape[0]
        # two parameters of its own and its share of g
        freedom = max(1.0, own.size - 2.0 - 1.0 / n)
        # as many independent samples as there are correlation lengths (GUM 4.2.7)
        variance = float(own @ own) / freedom * correlation_length(own) * misfit_widening(own)
        meat += variance * (block.T @ block)
    covariance = inverse @ meat @ inverse
    return Parabolas(
        origin,
        solution[:-1:2].copy(),
        solution[1:-1:2].copy(),
        float(solution[-1]),
        covariance,
        float(np.sqrt(np.mean(residual**2))),
    )


def parabola_design(times_s: Sequence[FloatArray]) -> tuple[FloatArray, list[FloatArray]]:
    """Return t0 of each flight, its middle, and d heights / d (h0_1, v0_1, h0_2, ..., v0_n, g) in rows a flight."""
    # about the middle of each flight: height and speed are then nearly uncorrelated
    origin_s, blocks = np.array([float(time.mean()) for time in times_s]), []
    for k, time in enumerate(times_s):
        d = time - origin_s[k]
        block = np.zeros((time.size, 2 * len(times_s) + 1))
        block[:, 2 * k], block[:, 2 * k + 1], block[:, -1] = 1.0, d, -0.5 * d * d
        blocks.append(block)
    return origin_s, blocks


def misfit_widening(residual: FloatArray) -> float:
    """Return by how much the variance of residuals that are not white must be widened, 1 to 4.

    A parabola follows part of the waves that a mismatch leaves in the track, so that the residuals show less of them
    than there is (`TrackSettings.hidden_waves`).
    """
    if residual.size < 8 or not residual.any():
        return 1.0
    # third differences see noise, not waves: what is left of the residuals is no noise
    white = float(np.mean(np.diff(residual, 3) ** 2)) / THIRD_DIFFERENCE_GAIN
    share = min(1.0, white / float(np.mean(residual**2)))
    return share + (1.0 - share) * TRACKS.hidden_waves**2


def correlation_length(residual: FloatArray) -> float:
    """Return 1 + 2 sum of the autocorrelation up to its first zero, in samples, at least 1."""
    if residual.size < 8 or not residual.any():
        return 1.0
    # padded to twice its length: the correlation must not wrap round
    size = 1 << int(2 * residual.size - 1).bit_length()
    spectrum = np.fft.rfft(residual - residual.mean(), size)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2, size)[: residual.size // 2]
    if correlation[0] <= 0:
        return 1.0
    correlation = correlation / correlation[0]
    # up to the first zero: beyond it the sum is noise, over all of it exactly zero
    negative = np.flatnonzero(correlation <= 0)
    end = int(negative[0]) if negative.size else correlation.size
    return float(max(1.0, 1.0 + 2.0 * correlation[1:end].sum()))
