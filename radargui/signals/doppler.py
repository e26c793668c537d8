"""Measure the Doppler frequency of each receiver from spectra, frame by frame.

No correction takes part in it, so every corrected path can be checked against it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from radargui.model.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from radargui.signals.hum import HARMONICS, MAINS_HZ, MAINS_WITHIN_HZ
from radargui.signals.rows import even_transform_size, order_statistics


@dataclass(frozen=True, slots=True)
class DopplerSettings:
    """How the Doppler frequency is measured. By hand; `bench robust` and `bench real` are the test (decision 20).

    Attributes
    ----------
    lengths_s
        Lengths of frames that are tried.
    frames
        Number of frames that the record should hold: a check needs several.
    about
        Share of the greatest number of steady lines (of any length) that a length must reach.
    few
        Share of steady lines below which the clear ones are compared.
    fewer
        Share of the most steady lines below which longer frames are not tried.
    strong
        Power of a line over white noise: 15 dB, false once in some 10^12 frequencies.
    alone
        Least share of the power above the noise that a clear line holds within three bins (a chirp is broader than a
        tone).
    lowest_bin
        Lowest bin that counts: below it are remains of the trend and slow mismatch.
    """

    lengths_s: tuple[float, ...] = (0.0125, 0.025, 0.05, 0.1, 0.2, 0.5)
    frames: float = 6.0
    about: float = 0.9
    few: float = 0.1
    fewer: float = 0.3
    strong: float = 30.0
    alone: float = 0.6
    lowest_bin: int = 2

    def holding(self, highest_hz: float) -> DopplerSettings:
        """Return the same without frames so short that no line up to a frequency is above their lowest bin."""
        long = tuple(one for one in self.lengths_s if one * highest_hz > self.lowest_bin + 0.5)
        return replace(self, lengths_s=long or self.lengths_s[-1:])


SETTINGS = DopplerSettings()
ALONE = DopplerSettings(
    lengths_s=(0.0125, 0.018, 0.025, 0.035, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.5), frames=5.0, few=1.0
)
"""Of one or two receivers, whose path rests on these frames."""
STEADY = 0.9
"""Share of what is above the noise that the line of one speed holds."""
_HALF_LINE = 3
"""Bins on each side that are the line's: Hann's main lobe has two; one more for a line between bins, a slow chirp."""
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
        Share of the power above the noise that the line holds, shape (n_frames,).
    clear, mixed
        Whether the line exceeds the noise and is the only one; whether it exceeds it and is not. Shape (n_frames,).
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
        """Which clear lines are so narrow that the frame holds one speed, shape (n_frames,)."""
        return self.clear & (self.share > STEADY)

    @property
    def resolution_hz(self) -> float:
        """Distance of two bins."""
        return self.sample_rate_hz / self.size

    def of_samples(self, size: int, first: int) -> Doppler:
        """Return the same counted in samples, of which each here is the mean of `size`; the first of all is `first`."""
        centre = first + self.centre * size + (size - 1) // 2
        return replace(self, centre=centre, size=self.size * size, sample_rate_hz=self.sample_rate_hz * size)

    def between(self, first: int, last: int) -> Doppler:
        """Return the frames whose middle lies in samples first:last."""
        inside = (self.centre >= first) & (self.centre < last)
        rows = {name: getattr(self, name)[..., inside] for name in _BY_FRAME}
        return replace(self, **rows)

    def around(self, frames: BoolArray, n_samples: int) -> BoolArray:
        """Return the samples nearest to some frames, shape (n_samples,)."""
        out = np.zeros(n_samples, dtype=np.bool_)
        reach = self.size // 4 + 1
        for centre in self.centre[frames]:
            out[max(centre - reach, 0) : centre + reach] = True
        return out

    def without_mains(self, lines_hz: Sequence[float]) -> Doppler:
        """Return the same where no line at a multiple of a mains frequency counts, if one of `lines_hz` is one."""
        hum = np.zeros(self.centre.size, dtype=np.bool_)
        for nominal, one in itertools.product(MAINS_HZ, lines_hz):
            order = max(round(one / nominal), 1)
            mains = one / order
            if order <= HARMONICS and abs(mains - nominal) < MAINS_WITHIN_HZ:
                away_hz = self.frequency_hz - mains * np.round(self.frequency_hz / mains)
                hum |= np.abs(away_hz) < 0.1 * self.resolution_hz
        return replace(self, clear=self.clear & ~hum, mixed=self.mixed & ~hum)

    @property
    def highest_hz(self) -> float | None:
        """Nearly the fastest of the clear lines (19 of 20 are slower); None without any."""
        return float(order_statistics(self.frequency_hz[self.clear], 0.95)[0]) if self.clear.any() else None


def measure_doppler(
    pair_v: FloatArray, sample_rate_hz: float, noise_v: FloatArray, settings: DopplerSettings = SETTINGS
) -> Doppler:
    """Find the strongest line of one receiver, I and Q of shape (2, n_samples); parameters as below."""
    return measure_dopplers(pair_v, sample_rate_hz, noise_v, settings)[0]


def measure_dopplers(
    volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray, settings: DopplerSettings = SETTINGS
) -> tuple[Doppler, ...]:
    """Find the strongest line of I + jQ in overlapping frames, of each receiver.

    The powers at +f and -f are added, so that gain and quadrature error do not matter; a straight line is subtracted
    from each frame, so that an offset does not count.

    Parameters
    ----------
    volts
        I1, Q1, I2, ... shape (2 n_receivers, n_samples).
    sample_rate_hz
        Rate of each channel.
    noise_v
        White noise of each, shape (2 n_receivers,).
    settings
        How it is measured.
    """
    longest_s = max(volts.shape[1] / sample_rate_hz / settings.frames, settings.lengths_s[0])
    # single precision, to 1e-7 of the largest swing: half of the memory
    centred = (volts - volts.mean(axis=1, keepdims=True)).astype(np.float32)
    # a long frame resolves slow motion, a short one follows a chirp: the longest that shows about as many steady lines
    tried, steady = list[_Frames](), list[FloatArray]()
    last = np.full(volts.shape[0] // 2, len(settings.lengths_s))
    for length_s in settings.lengths_s:
        if length_s > longest_s or (last <= len(tried)).all():
            break
        tried.append(_frames(centred, sample_rate_hz, noise_v, length_s, settings))
        steady.append((tried[-1].clear & (tried[-1].share > STEADY)).mean(axis=1))
        # where they are already too long to follow it, longer ones are too
        most = np.max(steady, axis=0)
        too_long = (most > max(settings.few, settings.fewer)) & (steady[-1] < settings.fewer * most)
        last = np.where(too_long, np.minimum(last, len(tried)), last)
    out = []
    for k, count in enumerate(last.tolist()):
        frames = _longest(tried[:count], k, [float(one[k]) for one in steady[:count]], settings)
        out.append(frames.doppler(k, sample_rate_hz, noise_v[2 * k : 2 * k + 2]))
    return tuple(out)


@dataclass(frozen=True, slots=True)
class _Frames:
    """Spectra of overlapping frames of all receivers and their strongest lines; fields as in `Doppler`."""

    starts: IntArray
    size: int
    spectrum: ComplexArray
    squares: FloatArray
    power: FloatArray
    place: IntArray
    share: FloatArray
    clear: BoolArray
    mixed: BoolArray

    def doppler(self, number: int, sample_rate_hz: float, noise_v: FloatArray) -> Doppler:
        """Return what is measured of the lines of one receiver."""
        pair, power, place = slice(2 * number, 2 * number + 2), self.power[number], self.place[number]
        rows, window = np.arange(self.starts.size), _window(self.size).square
        spectrum = self.spectrum[pair]
        i, q = spectrum[:, rows, place].astype(np.complex128)
        centre, hz = self.starts + self.size // 2, _interpolated(power, place) * sample_rate_hz / self.size
        # over what white noise of I and Q together leaves in one bin under this window
        over_noise = power[rows, place] / float(window * (noise_v**2).sum())
        share, clear, mixed = self.share[number], self.clear[number], self.mixed[number]
        moments = _moments(spectrum, self.squares[pair], place, window * noise_v**2)
        return Doppler(centre, self.size, sample_rate_hz, hz, over_noise, share, clear, mixed, i, q, moments)


def _longest(tried: list[_Frames], number: int, steady: list[float], settings: DopplerSettings) -> _Frames:
    """Return the longest frames that show about as many steady lines of a receiver as any."""
    shown = steady if max(steady) > settings.few else [float(one.clear[number].mean()) for one in tried]
    return [one for one, much in zip(tried, shown, strict=True) if much >= settings.about * max(shown)][-1]


class _Window:
    """What frames of one size are weighed with.

    A straight line is taken off, for drift and offset would leak from bin 0 over the slow lines; the window is Hann's,
    for sidelobes of a rectangle, 13 dB down, would be taken for a second line.
    """

    def __init__(self, size: int) -> None:
        hann = np.hanning(size)
        self.square = float((hann**2).sum())
        self.hann = hann.astype(np.float32)
        self.line = np.stack([np.ones(size), np.linspace(-1.0, 1.0, size)]).astype(np.float32)
        self.fit = (self.line / np.square(self.line).sum(axis=1, keepdims=True)).T


_window = lru_cache(maxsize=64)(_Window)
"""They depend on nothing that was recorded."""


def _frames(
    centred_v: FloatArray, sample_rate_hz: float, noise_v: FloatArray, length_s: float, settings: DopplerSettings
) -> _Frames:
    n = centred_v.shape[1]
    size = max(16, min(even_transform_size(length_s * sample_rate_hz), 2 * (n // 2)))
    starts, window = np.arange(0, n - size + 1, max(1, size // 2)), _window(size)
    frames = np.lib.stride_tricks.sliding_window_view(centred_v, size, axis=1)[:, starts]
    frames -= (frames @ window.fit) @ window.line
    frames *= window.hann
    # numpy transforms single precision up to six times slower
    spectrum = np.fft.rfft(frames.astype(np.float64), axis=2)
    # |I|^2 + |Q|^2: the sum of the powers at +f and -f, whatever the mixer
    squares = spectrum.real**2 + spectrum.imag**2
    power = squares[0::2] + squares[1::2]
    # white noise of variance s^2 has s^2 sum(w^2) in each bin
    noise = (window.square * (noise_v**2).reshape(-1, 2).sum(axis=1)).astype(np.float32)[:, None]
    power[:, :, : settings.lowest_bin] = 0.0
    # next to half of the rate lies what folds back from beyond it
    power[:, :, round(0.45 * size) :] = 0.0
    place = np.argmax(power, axis=2)
    strong = power.max(axis=2) > settings.strong * noise
    # I and Q together are above three times their mean noise in one bin of sixty
    above = np.maximum(power - 3.0 * noise[..., None], 0.0)
    bins, inside = _line_bins(place, above.shape[2])
    own = np.where(inside, np.take_along_axis(above, bins, axis=2), 0.0).sum(axis=2)
    # the lowest bin looked at may be the flank of what lies below
    strong &= place > settings.lowest_bin
    share = own / np.maximum(above.sum(axis=2, dtype=np.float64), 1e-300)
    alone = share > settings.alone
    clear, mixed = strong & alone, strong & ~alone
    return _Frames(starts, size, spectrum, squares, power, place, np.asarray(share, dtype=np.float64), clear, mixed)


def _line_bins(place: IntArray, count: int) -> tuple[IntArray, BoolArray]:
    """Return the bins of a line around each place, shape (..., 2 _HALF_LINE + 1), and which of them there are."""
    bins = place[..., None] + np.arange(-_HALF_LINE, _HALF_LINE + 1)
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
    # beyond half a bin the neighbour would have been the highest
    return np.asarray(place + np.clip(shift, -0.5, 0.5))
