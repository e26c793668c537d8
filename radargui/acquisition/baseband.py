"""Take the Doppler signal of each receiver from the ring at a low rate, for spectra, lines and amplitude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.fft import fft, fftfreq, fftshift
from numpy.lib.stride_tricks import sliding_window_view

from radargui.acquisition.ring import Ring
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.front_end import with_phase_sign
from radargui.signals.hum import HARMONICS, MAINS_HZ

_RATE_OF_BAND = 4
"""Samples per second kept for each hertz of half the band: the filter may fall over as much as the band is wide."""
_STEPS_OF_TAPS = 10
"""Length of the low-pass in kept samples: with Kaiser's beta of 7 it lets 0.9995 through and stops 70 dB beyond."""
_BETA = 7.0  # beta = 0.1102 (A - 8.7) with A = 72 dB (Kaiser 1974)
MAX_POINTS = 131_072
"""Kept of each receiver: their spectra take some milliseconds (chosen by hand)."""
_PULL_S = 0.25
"""Taken at a time: after a change of band the past is caught up in some frames, none of which waits for it."""
_MIN_POINTS = 64
"""Kept samples below which nothing is shown. Chosen by hand: of fewer a spectrum is a blur, more come later."""
_STANDS_OUT = 5.6
"""Amplitude of a line over the median of its spectrum, 15 dB: of white noise once in 10^8 bins."""
_BESIDE = 12
"""Bins on each side that a mains line must stand out of: the line of a Doppler chirp is broad there."""


@dataclass(frozen=True, slots=True)
class SpectralLine:
    """A line of a spectrum.

    Attributes
    ----------
    frequency_hz
        Positive where the path gets longer.
    amplitude_v
        Of the rotating pointer I + jQ.
    """

    frequency_hz: float
    amplitude_v: float


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Amplitude spectra of I + jQ of all receivers.

    Attributes
    ----------
    frequency_hz
        Ascending, from minus to plus half the band, shape (n,).
    amplitude_v
        A pointer that turns with amplitude A at one frequency reads A there, shape (n_receivers, n).
    span_s
        Length of the samples; 1 / span_s is the distance of two bins.
    """

    frequency_hz: FloatArray
    amplitude_v: FloatArray
    span_s: float

    @property
    def resolution_hz(self) -> float:
        """Distance of two bins."""
        return 1.0 / self.span_s

    def strongest(self, receiver: int) -> SpectralLine | None:
        """Return the strongest line of a receiver; None where none stands out of the noise."""
        amplitude = self.amplitude_v[receiver].copy()
        # what Hann's window leaves of the mean that was taken out
        amplitude[np.abs(self.frequency_hz) < 2.5 * self.resolution_hz] = 0.0
        return self._line(receiver, int(np.argmax(amplitude)))

    def mains(self, receiver: int) -> list[SpectralLine]:
        """Return the lines at 50 and 60 Hz and their multiples that stand out at plus and at minus.

        A pick-up is a voltage that does not rotate: half of it turns forwards, half backwards. A Doppler line is on one
        side only.
        """
        found, highest_hz = [], float(self.frequency_hz[-1])
        orders = {nominal * order for nominal in MAINS_HZ for order in range(1, HARMONICS + 1)}
        for nominal in sorted(orders):
            if nominal + 2.0 * self.resolution_hz > highest_hz:
                break
            forward, backward = (self._beside(receiver, sign * nominal) for sign in (1.0, -1.0))
            if forward and backward and 0.5 * forward.amplitude_v < backward.amplitude_v < 2.0 * forward.amplitude_v:
                found.append(forward)
        return found

    def _beside(self, receiver: int, frequency_hz: float) -> SpectralLine | None:
        """Return the line at a frequency, within a bin or two, that stands out of the bins around it."""
        amplitude = self.amplitude_v[receiver]
        at = int(np.argmin(np.abs(self.frequency_hz - frequency_hz)))
        near = slice(max(at - 2, 0), at + 3)
        at = near.start + int(np.argmax(amplitude[near]))
        around = np.r_[amplitude[max(at - _BESIDE, 0) : max(at - 3, 0)], amplitude[at + 4 : at + 1 + _BESIDE]]
        if not around.size or amplitude[at] < _STANDS_OUT * np.median(around):
            return None
        return self._line(receiver, at)

    def _line(self, receiver: int, at: int) -> SpectralLine | None:
        """Return a line between its bins, exact for one line under Hann's window (Grandke 1983, eq. 5 and 8)."""
        amplitude = self.amplitude_v[receiver]
        if not 0 < at < amplitude.size - 1 or amplitude[at] < _STANDS_OUT * np.median(amplitude):
            return None
        side = 1 if amplitude[at + 1] > amplitude[at - 1] else -1
        ratio = float(amplitude[at + side] / amplitude[at])
        shift = max(0.0, (2.0 * ratio - 1.0) / (1.0 + ratio))
        height = float(amplitude[at]) * (1.0 - shift**2) / float(np.sinc(shift))
        return SpectralLine(float(self.frequency_hz[at]) + side * shift * self.resolution_hz, height)


def _low_pass(step: int) -> FloatArray:
    """Return the taps, sum 1, by which one of `step` samples is kept: a sinc in Kaiser's window; one tap for step 1.

    Not scipy's: it would be half of what the start of the window waits for.
    """
    half = _STEPS_OF_TAPS * step // 2 if step > 1 else 0
    # in the middle between the band's edge and the lowest frequency that folds into the band
    taps = np.sinc(np.arange(-half, half + 1) / step) * np.kaiser(2 * half + 1, _BETA)
    return np.asarray(taps / taps.sum())


def _spectra(frames: ComplexArray) -> FloatArray:
    """Return the amplitude spectra of frames along their last axis, without their means, by a Hann window."""
    # periodic, so that a line between two bins is known from two of them (`Spectrum._line`)
    window = np.hanning(frames.shape[-1] + 1)[:-1]
    return np.asarray(np.abs(fft((frames - frames.mean(axis=-1, keepdims=True)) * window, axis=-1)) / window.sum())


class Baseband:
    """I + jQ of the last seconds within +-`half_band_hz`, low-passed and thinned out of a ring; pulled, never pushed.

    Parameters
    ----------
    ring
        Where the samples are.
    rate_hz
        Of the ring.
    half_band_hz
        Highest frequency of interest; what lies beyond three times of it folds in, 70 dB weaker.
    window_s
        Length kept; less where that were more than `MAX_POINTS`.
    phase_sign
        -1 where Q is inverted, so that a path that gets longer has positive frequencies.

    Attributes
    ----------
    rate_hz
        Of what is kept.
    end
        Absolute index in the ring up to which samples are in.
    """

    def __init__(self, ring: Ring, rate_hz: float, half_band_hz: float, window_s: float, phase_sign: int) -> None:
        self._ring, self._sign = ring, phase_sign
        self._step = max(1, int(rate_hz / (_RATE_OF_BAND * half_band_hz)))
        self.rate_hz = rate_hz / self._step
        self.half_band_hz = min(half_band_hz, 0.5 * self.rate_hz)
        self._capacity = max(_MIN_POINTS, min(round(window_s * self.rate_hz), MAX_POINTS))
        self._most = max(1, round(_PULL_S * rate_hz))
        self._taps = _low_pass(self._step)
        self._tail: ComplexArray | None = None
        self._kept: ComplexArray | None = None
        self.end = 0

    @property
    def samples_v(self) -> ComplexArray:
        """The newest, shape (n_receivers, n); NaN where samples were lost."""
        return np.empty((0, 0), np.complex128) if self._kept is None else self._kept

    def pull(self, until: int) -> bool:
        """Take what is new in the ring up to absolute index `until`; return whether more waits."""
        oldest = until - self._capacity * self._step - self._taps.size
        if self._tail is None or self.end < max(oldest, self._ring.first):
            # so old that nothing of it would stay
            self._tail, self._kept = None, None
            self.end = max(oldest, self._ring.first)
        span = self._ring.span(self.end, min(until, self.end + self._most))
        if not span.volts.shape[1]:
            return False
        self.end = span.first_index + span.volts.shape[1]
        volts = with_phase_sign(span.volts, self._sign)
        new = volts[0::2] + 1j * volts[1::2]
        joined = new if self._tail is None else np.concatenate([self._tail, new], axis=1)
        count = max(0, (joined.shape[1] - self._taps.size) // self._step + 1)
        if count:
            windows = sliding_window_view(joined, self._taps.size, axis=1)
            out = np.asarray(windows[:, :: self._step] @ self._taps, np.complex128)
            kept = out if self._kept is None else np.concatenate([self._kept, out], axis=1)
            self._kept = kept[:, -self._capacity :]
        self._tail = joined[:, count * self._step :]
        return self.end < until

    def spectrum(self) -> Spectrum | None:
        """Return the spectra of the newest samples without a gap; None while there are too few."""
        samples = self._unbroken()
        count = samples.shape[1]
        if count < _MIN_POINTS:
            return None
        spectra = _spectra(samples)
        frequency = fftshift(fftfreq(count, 1.0 / self.rate_hz))
        inside = np.abs(frequency) <= self.half_band_hz
        return Spectrum(frequency[inside], fftshift(spectra, axes=1)[:, inside], count / self.rate_hz)

    def waterfall(self, size: int, hop: int) -> FloatArray:
        """Return spectra of `size` samples each, `hop` apart, the newest last: shape (n_receivers, n_frames, n_bins).

        Amplitudes in V from minus to plus half the band; NaN where samples were lost.
        """
        samples = self.samples_v
        if samples.shape[1] < size:
            return np.empty((samples.shape[0], 0, 0))
        frames = sliding_window_view(samples, size, axis=1)[:, ::-1][:, ::hop][:, ::-1]
        spectra = _spectra(frames)
        inside = np.abs(fftshift(fftfreq(size, 1.0 / self.rate_hz))) <= self.half_band_hz
        return np.asarray(fftshift(spectra, axes=2)[:, :, inside], dtype=np.float64)

    def amplitude_v(self, span_s: float) -> FloatArray:
        """Return the amplitude of the Doppler signal over the newest `span_s`, shape (n_receivers,).

        The root mean square of I + jQ about its mean: the radius of its circle where the path changed by more than a
        wavelength, less where it changed less. NaN while nothing is known.
        """
        newest = self._unbroken()[:, -max(_MIN_POINTS, round(span_s * self.rate_hz)) :]
        if newest.shape[1] < _MIN_POINTS:
            return np.full(newest.shape[0], np.nan)
        return np.asarray(np.std(newest, axis=1))

    def _unbroken(self) -> ComplexArray:
        samples = self.samples_v
        lost = np.flatnonzero(~np.isfinite(samples).all(axis=0))
        return samples[:, lost[-1] + 1 :] if lost.size else samples
