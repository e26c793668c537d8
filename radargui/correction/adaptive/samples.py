"""The adaptive circles at every sample: phases, uncertainties, corrected IQ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.correction.adaptive.found import Found
from radargui.correction.adaptive.rounds import circle_data
from radargui.correction.signals import Signals
from radargui.model.arrays import FloatArray

_BANDWIDTH_HZ = 2000.0
_COVERAGE = 1.2


@dataclass(frozen=True, slots=True)
class CircleSamples:
    """Phases against the rest with standard uncertainties and unit-circle I and Q, shapes (n_receivers, n_samples)."""

    phase_rad: FloatArray
    u_phase_rad: FloatArray
    i: FloatArray
    q: FloatArray


def circles_at_samples(found: Found, signals: Signals) -> CircleSamples:
    """Apply each receiver's circle to its samples at the time of channel 0; the phase is smoothed to 2 kHz.

    Between the bins' phases the sample's own phase is taken against the interpolated one, so that it cannot slip.
    """
    ground, last, time = found.ground, found.last, signals.time_s
    at = ground.bins.time_s
    n = ground.antennas.n_receivers
    length = max(1, round(signals.rate_hz / (2.0 * _BANDWIDTH_HZ)))
    phase, u_phase, out_i, out_q = (np.empty((n, time.size)) for _ in range(4))
    data = circle_data(ground, last.value, last.phase_rad, last.place, last.bias, last.level)
    for k, (fit, own) in enumerate(zip(last.fits, data, strict=True)):
        none = np.zeros(at.size)
        w = fit.theta[5 : 5 + own.bias.shape[1]], fit.theta[5 + own.bias.shape[1] : 5 + 2 * own.bias.shape[1]]
        bias = [np.interp(time, at, own.bias @ part if part.size else none) for part in w]
        loss = np.cos(np.clip(np.gradient(last.phase_rad[k], at) * ground.bins.node_s, -0.3, 0.3))
        amplitude = np.interp(time, at, last.amplitude[k] / loss)
        turn = last.turn_rad[k]
        base = np.interp(time, at, last.phase_rad[k])
        ellipse = fit.ellipse
        gain, sine, cosine = np.exp(ellipse.log_gain), np.sin(ellipse.skew_rad), np.cos(ellipse.skew_rad)
        channels = []
        for part in range(2):
            later = np.interp(time + signals.delay_s[2 * k + part], at, last.phase_rad[k])
            change = amplitude * (np.exp(1j * (base + turn)) - np.exp(1j * (later + turn)))
            added = change.real if part == 0 else gain * (sine * change.real + cosine * change.imag)
            offset = ellipse.offset_i if part == 0 else ellipse.offset_q
            channels.append(signals.value[2 * k + part] + added - offset - bias[part])
        x = channels[0]
        y = (channels[1] / gain - x * sine) / cosine
        z = (x + 1j * y) * np.exp(-1j * turn) / amplitude
        raw = base + np.angle(z * np.exp(-1j * base))
        phase[k] = uniform_filter1d(raw, length, mode="nearest")
        variance = fit.phase_variance(own) - _noise_part(own.sigma_i, own.sigma_q, last.amplitude[k])
        noise = signals.sigma[2 * k : 2 * k + 2].mean() ** 2 / amplitude**2 / length
        fitted = np.interp(time, at, np.maximum(variance, 0.0))
        u_phase[k] = _COVERAGE * np.sqrt((noise + fitted) * max(1.0, fit.chi_square))
        out_i[k], out_q[k] = z.real, signals.phase_sign * z.imag
    return CircleSamples(phase, u_phase, out_i, out_q)


def _noise_part(sigma_i: FloatArray, sigma_q: FloatArray, amplitude: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (sigma_i**2 + sigma_q**2) / amplitude**2)
