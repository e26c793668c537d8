"""The adaptive circles at every sample: phases, uncertainties, corrected IQ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from radargui.correction.adaptive.circle_fit import CircleData
from radargui.correction.adaptive.found import Found
from radargui.correction.adaptive.rounds import circle_data
from radargui.correction.signals import Signals
from radargui.model.arrays import FloatArray
from radargui.model.pieces import pieces

_BANDWIDTH_HZ = 2000.0
_COVERAGE = 1.2

ComplexArray: TypeAlias = NDArray[np.complex128]


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
        variance = fit.phase_variance(own) - _noise_part(own.sigma_i, own.sigma_q, last.amplitude[k])
        fitted = np.maximum(variance, 0.0)
        noise = signals.sigma[2 * k : 2 * k + 2].mean() ** 2 / length
        circle = _Circle(found, signals, k, own)
        for part in pieces(time.size):
            phase[k, part], amplitude, z = circle.at(part)
            out_i[k, part], out_q[k, part] = z.real, signals.phase_sign * z.imag
            square = noise / amplitude**2 + np.interp(time[part], at, fitted)
            u_phase[k, part] = _COVERAGE * np.sqrt(square * max(1.0, fit.chi_square))
        phase[k] = uniform_filter1d(phase[k], length, mode="nearest")
    return CircleSamples(phase, u_phase, out_i, out_q)


class _Circle:
    """One receiver's circle between the bins."""

    def __init__(self, found: Found, signals: Signals, receiver: int, data: CircleData) -> None:
        self.signals, self.receiver, self.turn = signals, receiver, float(found.last.turn_rad[receiver])
        self.bin_s, self.phase = found.ground.bins.time_s, found.last.phase_rad[receiver]
        loss = np.cos(np.clip(np.gradient(self.phase, self.bin_s) * found.ground.bins.node_s, -0.3, 0.3))
        self.amplitude = found.last.amplitude[receiver] / loss
        self.ellipse, theta, n = found.last.fits[receiver].ellipse, found.last.fits[receiver].theta, data.bias.shape[1]
        self.bias_i = self.ellipse.offset_i + data.bias @ theta[5 : 5 + n]
        self.bias_q = self.ellipse.offset_q + data.bias @ theta[5 + n : 5 + 2 * n]

    def at(self, part: slice) -> tuple[FloatArray, FloatArray, ComplexArray]:
        """Return phases, amplitudes and points near the unit circle at some samples."""
        time = self.signals.time_s[part]
        delay_i, delay_q = self.signals.delay_s[2 * self.receiver : 2 * self.receiver + 2]
        i, q = self.signals.value[2 * self.receiver : 2 * self.receiver + 2, part]
        amplitude, base = np.interp(time, self.bin_s, self.amplitude), np.interp(time, self.bin_s, self.phase)
        unit = _unit(base + self.turn)
        gain, skew = np.exp(self.ellipse.log_gain), self.ellipse.skew_rad
        i = i + amplitude * self._change(time, unit, delay_i).real - np.interp(time, self.bin_s, self.bias_i)
        change = self._change(time, unit, delay_q)
        change_q = gain * amplitude * (np.sin(skew) * change.real + np.cos(skew) * change.imag)
        q = q + change_q - np.interp(time, self.bin_s, self.bias_q)
        z = i + 1j * ((q / gain - i * np.sin(skew)) / np.cos(skew))
        return base + np.angle(z * unit.conj()), amplitude, z * np.exp(-1j * self.turn) / amplitude

    def _change(self, time_s: FloatArray, unit: ComplexArray, delay_s: float) -> ComplexArray:
        """Return what the unit circle turns back from the channel's own time to that of channel 0."""
        if delay_s == 0.0:
            return np.zeros_like(unit)
        return np.asarray(unit - _unit(np.interp(time_s + delay_s, self.bin_s, self.phase) + self.turn))


def _unit(angle_rad: FloatArray) -> ComplexArray:
    return np.asarray(np.cos(angle_rad) + 1j * np.sin(angle_rad))


def _noise_part(sigma_i: FloatArray, sigma_q: FloatArray, amplitude: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (sigma_i**2 + sigma_q**2) / amplitude**2)
