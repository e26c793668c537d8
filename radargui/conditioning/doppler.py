"""The Doppler frequency moment by moment, from spectra alone: what every correction is held against."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.conditioning.hum import HARMONICS, MAINS_HZ
from radargui.model.arrays import BoolArray, ComplexArray, FloatArray, IntArray, even_transform_size


@dataclass(frozen=True, slots=True)
class DopplerSettings:
    """How the Doppler frequency is measured.

    Attributes
    ----------
    lengths_s
        Lengths of frames that are tried.
    frames
        That the record should hold: a check needs several.
    about
        Share of the most steady lines that any length shows.
    few
        Share of steady lines below which the clear ones are compared.
    fewer
        Share of the most steady lines below which longer frames are not tried.
    strong
        Power of a line over white noise: 15 dB, false once in some 10^12 frequencies.
    alone
        Share of what is above the noise that a clear line holds within three bins (a chirp is broader than a tone).
    lowest_bin
        Below lie the trend's leak and slow mismatch.
    """

    lengths_s: tuple[float, ...] = (0.0125, 0.025, 0.05, 0.1, 0.2, 0.5)
    frames: float = 6.0
    about: float = 0.9
    few: float = 0.1
    fewer: float = 0.3
    strong: float = 30.0
    alone: float = 0.6
    lowest_bin: int = 2


SETTINGS = DopplerSettings()
ALONE = DopplerSettings(
    lengths_s=(0.0125, 0.018, 0.025, 0.035, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.5), frames=5.0, few=1.0
)
"""Of one or two receivers, whose path rests on these frames."""
STEADY = 0.9
"""Share of what is above the noise that the line of one speed holds."""
MAINS_WITHIN_HZ = 0.3
"""Of the mains' nominal frequency, which grids keep within 0.05 Hz."""
_HALF_LINE = 3
_BY_FRAME = ("centre", "frequency_hz", "power", "share", "clear", "mixed", "i", "q", "moments")


@dataclass(frozen=True, slots=True)
class Doppler:
    """Lines of one receiver's frames.

    Attributes
    ----------
    centre
        Sample in the middle of each frame, shape (n_frames,).
    size
        Samples of a frame; neighbours overlap by half.
    sample_rate_hz
        Of the samples.
    frequency_hz
        Of the strongest line, without sign, shape (n_frames,).
    power
        Of that line, at +f and -f together, over the white noise of one such bin, shape (n_frames,).
    share
        Of what is above the noise that the line holds, shape (n_frames,).
    clear, mixed
        Whether it stands out of the noise and is alone; or is not alone. Shape (n_frames,).
    i, q
        Spectra of I and of Q at the line, shape (n_frames,).
    moments
        Sums of |I|^2, |Q|^2 and Re(Q I*) over the bins of the line, without the noise's share, shape (3, n_frames).
    """

    centre: IntArray
    size: int
    sample_rate_hz: float
    frequency_hz: FloatArray
    power: FloatArray
    share: FloatArray
    clear: BoolArray
    mixed: BoolArray
    i: ComplexArray
    q: ComplexArray
    moments: FloatArray

    @property
    def steady(self) -> BoolArray:
        """Which clear lines are so narrow that the frame holds one speed."""
        return self.clear & (self.share > STEADY)

    @property
    def resolution_hz(self) -> float:
        """Distance of two bins."""
        return self.sample_rate_hz / self.size

    def counted_from(self, start: int) -> Doppler:
        """Return the same with samples counted from `start` on."""
        return replace(self, centre=self.centre - start)

    def of_samples(self, size: int) -> Doppler:
        """Return the same counted in samples, of which each here is the mean of `size`."""
        centre = self.centre * size + (size - 1) // 2
        return replace(self, centre=centre, size=self.size * size, sample_rate_hz=self.sample_rate_hz * size)

    def between(self, first: int, last: int) -> Doppler:
        """Return the frames whose middle lies in samples first:last."""
        inside = (self.centre >= first) & (self.centre < last)
        rows = {name: getattr(self, name)[..., inside] for name in _BY_FRAME}
        return replace(self, **rows)

    def without_mains(self, lines_hz: Sequence[float]) -> Doppler:
        """Return the same where no line at a multiple of a mains frequency counts, if one of `lines_hz` is one."""
        hum = np.zeros(self.centre.size, dtype=np.bool_)
        for nominal, one in itertools.product(MAINS_HZ, lines_hz):
            order = max(round(one / nominal), 1)
            mains = one / order
            if order <= HARMONICS and abs(mains - nominal) < MAINS_WITHIN_HZ:
                hum |= (
                    np.abs(self.frequency_hz - mains * np.round(self.frequency_hz / mains)) < 0.1 * self.resolution_hz
                )
        return replace(self, clear=self.clear & ~hum, mixed=self.mixed & ~hum)

    @property
    def highest_hz(self) -> float | None:
        """Nearly the fastest of the clear lines (19 of 20 are slower); None without any."""
        return float(np.quantile(self.frequency_hz[self.clear], 0.95)) if self.clear.any() else None


def measure_doppler(
    pair_v: FloatArray, sample_rate_hz: float, noise_v: FloatArray, settings: DopplerSettings = SETTINGS
) -> Doppler:
    """Find the strongest line of I + jQ in overlapping frames.

    The powers at +f and -f are added, so that neither gain nor quadrature error matters; a straight line is taken off
    each frame, so that no offset is a signal.

    Parameters
    ----------
    pair_v
        I and Q in volts, shape (2, n_samples).
    sample_rate_hz
        Rate of each channel.
    noise_v
        White noise of both, shape (2,).
    settings
        How it is measured.
    """
    longest_s = max(pair_v.shape[1] / sample_rate_hz / settings.frames, settings.lengths_s[0])
    lengths_s = [length_s for length_s in settings.lengths_s if length_s <= longest_s]
    # a long frame resolves slow motion, a short one follows a chirp: the longest that shows about as many steady lines
    tried, steady = [], []
    for length_s in lengths_s:
        tried.append(_Frames.of(pair_v, sample_rate_hz, noise_v, length_s, settings))
        steady.append(float((tried[-1].clear & (tried[-1].share > STEADY)).mean()))
        # where they are already too long to follow it, longer ones are too
        if max(steady) > max(settings.few, settings.fewer) and steady[-1] < settings.fewer * max(steady):
            break
    shown = steady if max(steady) > settings.few else [float(one.clear.mean()) for one in tried]
    good = [one for one, much in zip(tried, shown, strict=True) if much >= settings.about * max(shown)]
    return good[-1].doppler(sample_rate_hz, noise_v)


@dataclass(frozen=True, slots=True)
class _Frames:
    """Spectra of overlapping frames and their strongest lines; fields as in `Doppler`."""

    starts: IntArray
    size: int
    spectrum: ComplexArray
    squares: FloatArray
    power: FloatArray
    place: IntArray
    share: FloatArray
    clear: BoolArray
    mixed: BoolArray

    @staticmethod
    def of(
        pair_v: FloatArray, sample_rate_hz: float, noise_v: FloatArray, length_s: float, settings: DopplerSettings
    ) -> _Frames:
        return _frames(pair_v, sample_rate_hz, noise_v, length_s, settings)

    def doppler(self, sample_rate_hz: float, noise_v: FloatArray) -> Doppler:
        """Return what is told of the lines."""
        rows, window = np.arange(self.starts.size), np.square(np.hanning(self.size)).sum()
        return Doppler(
            self.starts + self.size // 2,
            self.size,
            sample_rate_hz,
            _interpolated(self.power, self.place) * sample_rate_hz / self.size,
            self.power[rows, self.place] / float(window * (noise_v**2).sum()),
            self.share,
            self.clear,
            self.mixed,
            self.spectrum[0][rows, self.place].astype(np.complex128),
            self.spectrum[1][rows, self.place].astype(np.complex128),
            _moments(self.spectrum, self.squares, self.place, float(window) * noise_v**2),
        )


def _frames(
    pair_v: FloatArray, sample_rate_hz: float, noise_v: FloatArray, length_s: float, settings: DopplerSettings
) -> _Frames:
    n = pair_v.shape[1]
    size = max(16, min(even_transform_size(length_s * sample_rate_hz), 2 * (n // 2)))
    starts = np.arange(0, n - size + 1, max(1, size // 2))
    # single precision, to 1e-7 of the largest swing: twice as fast
    centred = (pair_v - pair_v.mean(axis=1, keepdims=True)).astype(np.float32)
    frames = np.lib.stride_tricks.sliding_window_view(centred, size, axis=1)[:, starts]
    # drift and offset would leak from bin 0 over the slow lines
    trend = np.stack([np.ones(size), np.linspace(-1.0, 1.0, size)]).astype(np.float32)
    frames -= (frames @ (trend / np.square(trend).sum(axis=1, keepdims=True)).T) @ trend
    # sidelobes of a rectangle, 13 dB down, would be taken for a second line
    window = np.hanning(size)
    spectrum = np.fft.rfft(frames * window.astype(np.float32), axis=2)
    # |I|^2 + |Q|^2: the sum of the powers at +f and -f, whatever the mixer
    squares = spectrum.real**2 + spectrum.imag**2
    power = squares[0] + squares[1]
    noise = float((window**2).sum() * (noise_v**2).sum())
    power[:, : settings.lowest_bin] = 0.0
    # next to half of the rate lies what folds back from beyond it
    power[:, round(0.45 * size) :] = 0.0
    place = np.argmax(power, axis=1)
    rows = np.arange(starts.size)
    strong = power[rows, place] > settings.strong * noise
    # I and Q together are above three times their mean noise in one bin of sixty
    above = np.maximum(power - 3.0 * noise, 0.0)
    bins, inside = _line_bins(place, above.shape[1])
    own = np.where(inside, above[rows[:, None], bins], 0.0).sum(axis=1)
    # the lowest bin looked at may be the flank of what lies below
    strong &= place > settings.lowest_bin
    share = own / np.maximum(above.sum(axis=1, dtype=np.float64), 1e-300)
    alone = share > settings.alone
    clear, mixed = strong & alone, strong & ~alone
    return _Frames(starts, size, spectrum, squares, power, place, np.asarray(share, dtype=np.float64), clear, mixed)


def _line_bins(place: IntArray, count: int) -> tuple[IntArray, BoolArray]:
    """Return the bins of a line around each place, (n, 2 _HALF_LINE + 1), and which are among as many as there are."""
    bins = place[:, None] + np.arange(-_HALF_LINE, _HALF_LINE + 1)
    inside = (bins >= 0) & (bins < count)
    return np.clip(bins, 0, count - 1), inside


def _moments(spectrum: ComplexArray, squares: FloatArray, place: IntArray, noise: FloatArray) -> FloatArray:
    """Return |I|^2, |Q|^2 and Re(Q I*) summed over the bins of each frame's line, less noise, shape (3, n)."""
    bins, inside = _line_bins(place, squares.shape[2])
    rows = np.arange(place.size)[:, None]
    i, q = spectrum[:, rows, bins]
    of_i, of_q = squares[:, rows, bins] - noise[:, None, None]
    products = np.stack([of_i, of_q, i.real * q.real + i.imag * q.imag])
    return np.asarray(np.where(inside, products, 0.0).sum(axis=2))


def _interpolated(power: FloatArray, place: IntArray) -> FloatArray:
    """Return the place of each peak between the bins, by a parabola through the logarithms of three."""
    rows = np.arange(place.size)
    inner = np.clip(place, 1, power.shape[1] - 2)
    around = power[rows, inner + np.array([[-1], [0], [1]])].astype(np.float64)
    left, middle, right = np.log(np.maximum(around, 1e-300))
    bend = left - 2.0 * middle + right
    shift = np.where(np.abs(bend) > 1e-12, 0.5 * (left - right) / np.where(bend == 0.0, 1.0, bend), 0.0)
    return np.asarray(place + np.clip(shift, -0.5, 0.5))
