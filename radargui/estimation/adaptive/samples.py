"""Evaluate the adaptive circles at every sample: phases, uncertainties, corrected IQ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.estimation.adaptive.circle_data import averaging_loss, circle_data, unit_phasor
from radargui.estimation.adaptive.circle_fit import CircleData, CircleFit
from radargui.estimation.adaptive.found import AdaptiveRounds
from radargui.estimation.motion_estimate import few_fringes_factor
from radargui.estimation.signals import ScaledSignals
from radargui.model.arrays import ComplexArray, FloatArray, pieces
from radargui.model.front_end import channels_of, point_of


@dataclass(frozen=True, slots=True)
class CircleSampleSettings:
    """How phases are smoothed and widened.

    Attributes
    ----------
    bandwidth_hz
        Bandwidth to which the phase is smoothed; the noise bound is stated for it. Chosen by hand.
    widened
        Factor on the uncertainty for what a smooth map cannot follow (coverage in the accuracy benchmark).
    along
        The phase is off by so many times the radial residual beyond the noise; the phase at rest, from which all are
        counted, is off as well (decision 44).
    """

    bandwidth_hz: float = 2000.0
    widened: float = 1.2
    along: float = 2.4


CIRCLE_SAMPLES = CircleSampleSettings()


@dataclass(frozen=True, slots=True)
class CircleSamples:
    """Phases against the rest with standard uncertainties and unit-circle I and Q, shapes (n_receivers, n_samples)."""

    phase_rad: FloatArray
    u_phase_rad: FloatArray
    i: FloatArray
    q: FloatArray


def circles_at_samples(found: AdaptiveRounds, signals: ScaledSignals) -> CircleSamples:
    """Apply each receiver's circle to its samples at the time of channel 0; the phase is smoothed to 2 kHz.

    Between bins the sample's own phase is taken relative to the interpolated one, so that it cannot slip.
    """
    binned, last, time = found.data, found.last, signals.time_s
    at = binned.bins.time_s
    n = binned.antennas.n_receivers
    # odd: a mean over an even number stands half a sample late
    length = 2 * int(signals.rate_hz / (4.0 * CIRCLE_SAMPLES.bandwidth_hz)) + 1
    phase, u_phase, out_i, out_q = (np.empty((n, time.size)) for _ in range(4))
    wide = few_fringes_factor(last.phase_rad)
    data = circle_data(binned, last.value, last.phase_rad, last.place, last.bias, last.amplitude_map)
    for k, (fit, own) in enumerate(zip(last.fits, data, strict=True)):
        of_noise = 0.5 * (own.sigma_i**2 + own.sigma_q**2) / last.amplitude[k] ** 2
        # the noise of a bin is not that of a sample, and is added for the band of the latter
        fitted = np.maximum(fit.phase_variance(own) - of_noise, 0.0)
        noise = signals.sigma[2 * k : 2 * k + 2].mean() ** 2 / length
        circle, bent = _CircleBetweenBins(found, signals, k, own), _bent_rad(fit, own, found, k)
        for part in pieces(time.size):
            phase[k, part], amplitude, z = circle.at(part)
            out_i[k, part], out_q[k, part] = z.real, z.imag
            square = noise / amplitude**2 + np.interp(time[part], at, fitted)
            # at rest the phase is zero by what it means, and nothing can have bent it yet
            turned = np.sin(0.5 * np.minimum(np.abs(phase[k, part]), np.pi))
            fitted_rad = CIRCLE_SAMPLES.widened * np.sqrt(square * max(1.0, fit.chi_square))
            u_phase[k, part] = wide[k] * np.hypot(fitted_rad, bent * turned)
        phase[k] = uniform_filter1d(phase[k], length, mode="nearest")
    return CircleSamples(phase, u_phase, out_i, out_q)


def _bent_rad(fit: CircleFit, data: CircleData, found: AdaptiveRounds, receiver: int) -> float:
    """Return by how much reflectors may bend the phase of a moving tracer, standard deviation.

    A second wave changes the radius, and the phase by as much. If it turns with the fringes, the radial residual shows
    the part that maps cannot follow. Other waves are in the maps. Where nothing falls, only the deviations of ln A and
    of the centre over the motion tell how large they are.
    """
    moving, amplitude = ~found.data.rest, found.last.amplitude[receiver]
    off = np.hypot(*fit.point(data.i, data.q, data.bias)) / amplitude - 1.0
    noise = 0.5 * (data.sigma_i**2 + data.sigma_q**2) / amplitude**2
    left = max(float((off**2 - noise)[moving].mean()), 0.0)
    # a fall would tell what the maps have taken: its acceleration is known
    if found.impact_s.size:
        return CIRCLE_SAMPLES.along * float(np.sqrt(left))
    maps = [data.amplitude_map @ fit.theta[fit.layout.amplitude_map], *(fit.centre(data.bias) / amplitude)]
    return float(np.sqrt(CIRCLE_SAMPLES.along**2 * left + sum(float(one[moving].var()) for one in maps)))


class _CircleBetweenBins:
    """One receiver's circle, its centre, amplitude and phase interpolated between the bins."""

    def __init__(self, found: AdaptiveRounds, signals: ScaledSignals, receiver: int, data: CircleData) -> None:
        self.signals, self.receiver = signals, receiver
        self.rest_phase = float(found.last.rest_phase_rad[receiver])
        self.bin_s, self.phase = found.data.bins.time_s, found.last.phase_rad[receiver]
        # a sample is no mean: it shows what a bin of a turning wave has lost
        self.amplitude = found.last.amplitude[receiver] / averaging_loss(self.phase, found.data.bins)
        self.ellipse = found.last.fits[receiver].ellipse
        self.centre_i, self.centre_q = found.last.fits[receiver].centre(data.bias)

    def at(self, part: slice) -> tuple[FloatArray, FloatArray, ComplexArray]:
        """Return phases, amplitudes and points near the unit circle at some samples."""
        time, pair = self.signals.time_s[part], slice(2 * self.receiver, 2 * self.receiver + 2)
        amplitude, base = np.interp(time, self.bin_s, self.amplitude), np.interp(time, self.bin_s, self.phase)
        unit = unit_phasor(base + self.rest_phase)
        gain, error = self.ellipse.gain_ratio, self.ellipse.quadrature_error_rad
        turned_i, turned_q = (self._turned_back(time, unit, delay) for delay in self.signals.delay_s[pair])
        i, q = self.signals.value[pair, part] + amplitude * channels_of(turned_i, turned_q, gain, error)
        i, q = i - np.interp(time, self.bin_s, self.centre_i), q - np.interp(time, self.bin_s, self.centre_q)
        x, y = point_of(i, q, gain, error)
        z = x + 1j * y
        return base + np.angle(z * unit.conj()), amplitude, z * np.exp(-1j * self.rest_phase) / amplitude

    def _turned_back(self, time_s: FloatArray, unit: ComplexArray, delay_s: float) -> ComplexArray:
        """Return what the unit circle turns back from the channel's own time to that of channel 0."""
        if delay_s == 0.0:
            return np.zeros_like(unit)
        return np.asarray(unit - unit_phasor(np.interp(time_s + delay_s, self.bin_s, self.phase) + self.rest_phase))
