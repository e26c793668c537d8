"""Recognise interference: lines of constant frequency that are as strong at -f as at +f.

No moving target makes such lines.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, ComplexArray, FloatArray, median
from radargui.signals.hum import HARMONICS, MAINS_HZ, MAINS_WITHIN_HZ
from radargui.signals.rows import even_transform_size


@dataclass(frozen=True, slots=True)
class InterferenceSettings:
    """What counts as a line of interference.

    Attributes
    ----------
    frame_s
        Length of the pieces whose spectra are compared: long enough to resolve a tone, short enough to see a target
        pass.
    frames, min_frames
        Shorter recordings are cut into `frames` pieces of at least 0.1 s. Fewer than `min_frames` do not distinguish
        a line from a target of constant speed.
    min_image
        Least ratio of the powers at -f and +f, in both directions, of the median piece: a mixer of gain 1.6 with 35
        degrees of quadrature error makes an image of 0.16.
    min_share
        Least share of the pieces that must show the line.
    min_coherence
        A source of its own keeps its phase from piece to piece; a plate that goes to and fro within each of them, and
        so has its line on both sides, does not. Of 30 hums and tones of `bench robust` none had less than 0.8, a plate
        0.55.
    mains_coherence
        The same for a line at the mains' own frequency, for which this is the only criterion: a target of just that
        speed throughout is refused with it. Hums added to the real recordings had 0.98 and more (`bench altered`).
    mains_steady
        Least power of the weak pieces of a mains line, divided by that of its median piece.
    stands_out
        Power over the median of its neighbourhood, and over white noise.
    neighbourhood_hz
        Half width of that neighbourhood.
    max_lines
        Strongest lines that are taken off.
    notch_s
        Length of the window in which a line's amplitude is followed.
    lowest_hz
        Below, drift and slow motion live.
    """

    frame_s: float = 0.25
    frames: int = 8
    min_frames: int = 5
    min_image: float = 0.25
    min_share: float = 0.85
    min_coherence: float = 0.7
    mains_coherence: float = 0.95
    mains_steady: float = 0.25
    stands_out: float = 25.0
    neighbourhood_hz: float = 60.0
    max_lines: int = 12
    notch_s: float = 0.4
    lowest_hz: float = 30.0


SETTINGS = InterferenceSettings()


def without_interference(
    volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray
) -> tuple[FloatArray, tuple[float, ...], slice]:
    """Return the voltages less the interference of each receiver, the lines' frequencies in Hz, and where it is sure.

    Near the ends of the record half a window does not determine a line's amplitude. So the result is sure in all
    samples but a window at both ends (a quarter of a short record).

    A moving target turns I + jQ one way: its image at -f is what the mixer's gain and quadrature errors make. Mains and
    other tones that reach the channels directly have any phase between I and Q, in every piece of the record, also
    while nothing moves. Each line is removed within a window of 0.4 s around the demodulated channel, so that a target
    is affected only while its Doppler frequency is within a few hertz of the line.

    Parameters
    ----------
    volts
        Finite, shape (2 n_receivers, n_samples).
    sample_rate_hz
        Rate of each channel.
    noise_v
        White noise of each channel, shape (2 n_receivers,).
    """
    frequencies = find_interference(volts, sample_rate_hz, noise_v)
    if not frequencies:
        return volts, (), slice(None)
    out, n_samples = volts.copy(), volts.shape[1]
    for frequency in frequencies:
        _take_off(out, sample_rate_hz, frequency)
    end = min(round(SETTINGS.notch_s * sample_rate_hz), n_samples // 4)
    return out, frequencies, slice(end, n_samples - end)


def find_interference(volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray) -> tuple[float, ...]:
    """Return the frequencies of interference in Hz, the strongest first; parameters as above."""
    duration_s = volts.shape[1] / sample_rate_hz
    frame_s = max(0.1, min(SETTINGS.frame_s, duration_s / SETTINGS.frames))
    size = even_transform_size(frame_s * sample_rate_hz)
    count = volts.shape[1] // size if size else 0
    if count < SETTINGS.min_frames:
        return ()
    frames = volts[:, : count * size].reshape(volts.shape[0], count, size)
    hz = np.arange(size // 2 + 1) * sample_rate_hz / size
    white = 2.0 * float((np.hanning(size) ** 2).sum())
    at_mains = (np.abs(hz - np.array(MAINS_HZ)[:, None]) <= 2.0 / frame_s).any(axis=0)
    # most records hold none: nothing that stands out in so many pieces, of both directions or at the mains, either way
    missed = count - SETTINGS.min_share * (count - 1)
    for part in (slice(min(count, 2 * int(missed) + 2)), slice(count)):
        spectrum, ahead, back = _directions(frames[:, part], noise_v)
        power = np.minimum(ahead, back)
        shown = np.where(at_mains, np.maximum(ahead, back), power) > SETTINGS.stands_out * white
        # what is missed too often in the first pieces already cannot be in enough of them all
        if not (shown.shape[1] - shown.sum(axis=1) <= missed).any():
            return ()
    image = power / np.maximum(np.maximum(ahead, back), 1e-300)
    width = max(4, round(SETTINGS.neighbourhood_hz * frame_s))
    # in nearly all pieces: a target stays at one frequency in some of them only
    level = np.quantile(power, 1.0 - SETTINGS.min_share, axis=1)
    # 1/f noise is high everywhere near by, a line is not
    around = _local_median(median(np.maximum(ahead, back), axis=1), width)
    tall = (level > SETTINGS.stands_out * white) & (level > SETTINGS.stands_out * 0.2 * around)
    is_interference = (median(image, axis=1) > SETTINGS.min_image) & (_coherence(spectrum) > SETTINGS.min_coherence)
    top = _peaks(level)
    in_band = (hz > SETTINGS.lowest_hz) & (hz < 0.45 * sample_rate_hz)
    certain, bin_hz = hz[(tall & is_interference & top).any(axis=0) & in_band], sample_rate_hz / size
    is_interference |= tall & _of_mains([_refined(volts, sample_rate_hz, float(f), bin_hz) for f in certain[:20]], hz)
    # what keeps to the mains' own frequency throughout is hum, also where its phases in I and Q turn it one way
    power, usual = np.quantile(np.maximum(ahead, back), [1.0 - SETTINGS.min_share, 0.5], axis=1)
    coherent = _peaks(power) & (power > SETTINGS.stands_out * white) & (_coherence(spectrum) > SETTINGS.mains_coherence)
    # a bouncing sphere passes there now and then: hum is there all the time, and as strong
    coherent &= power > SETTINGS.mains_steady * usual
    near = [mains for mains in MAINS_HZ if coherent[:, np.abs(hz - mains) <= bin_hz].any()]
    mains_hz = [_refined(volts, sample_rate_hz, mains, bin_hz) for mains in near]
    mains_hz = [one for one, mains in zip(mains_hz, near, strict=True) if abs(one - mains) < MAINS_WITHIN_HZ]
    is_interference |= tall & _of_mains(mains_hz, hz)
    found = np.flatnonzero((tall & is_interference & top).any(axis=0) & in_band)
    strongest = found[np.argsort(level[:, found].max(axis=0))[::-1]][: SETTINGS.max_lines]
    lines_hz = list(mains_hz)
    for near_hz in hz[strongest]:
        # beside a target a weak harmonic says its frequency less well than the mains do
        orders = [(one, min(round(near_hz / one), HARMONICS)) for one in mains_hz]
        tried = [one * order for one, order in orders if abs(near_hz - one * order) <= bin_hz]
        tried.append(_refined(volts, sample_rate_hz, float(near_hz), bin_hz))
        line = max(tried, key=lambda f: _strength(volts, sample_rate_hz, f)) if len(tried) > 1 else tried[0]
        if all(abs(line - one) > (2.0 if one in mains_hz else 0.5) * bin_hz for one in lines_hz):
            lines_hz.append(line)
    return tuple(lines_hz)


def _directions(frames_v: FloatArray, noise_v: FloatArray) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Return the spectra of pieces (n_channels, n_pieces, size) and the powers at +f and -f of each receiver.

    Both channels are scaled by their noise: a weak channel's line counts as much as a strong one's.
    """
    window = np.hanning(frames_v.shape[2]) / noise_v[:, None]
    spectrum = np.fft.rfft((frames_v - frames_v.mean(axis=2, keepdims=True)) * window[:, None], axis=2)
    # |I + jQ|^2 and |I - jQ|^2
    squares = spectrum.real**2 + spectrum.imag**2
    i, q, both = spectrum[0::2], spectrum[1::2], squares[0::2] + squares[1::2]
    turning = 2.0 * (i.imag * q.real - i.real * q.imag)
    return spectrum, both + turning, both - turning


def _strength(volts: FloatArray, rate_hz: float, frequency_hz: float) -> float:
    """Return the power at a frequency over the whole record, whose resolution is finer than the frames'."""
    turn = np.hanning(volts.shape[1]) * np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(volts.shape[1]))
    return float((np.abs(volts @ turn) ** 2).sum())


def _peaks(power: FloatArray) -> BoolArray:
    """Return which bins are no lower than their neighbours, same shape."""
    padded = np.pad(power, ((0, 0), (1, 1)))
    return np.asarray((power >= padded[:, :-2]) & (power >= padded[:, 2:]))


def _coherence(spectrum: ComplexArray) -> FloatArray:
    """Return how well each bin's phase goes on evenly from piece to piece, 0 to 1, shape (n_receivers, n_bins).

    |sum a_k+1 a_k*| over sum |a_k+1 a_k|, in the channel where it is larger: a target may pass in the other.
    """
    step = spectrum[:, 1:] * spectrum[:, :-1].conj()
    share = np.abs(step.sum(axis=1)) / np.maximum(np.abs(step).sum(axis=1), 1e-300)
    return np.asarray(np.maximum(share[0::2], share[1::2]))


def _of_mains(found_hz: list[float], hz: FloatArray) -> BoolArray:
    """Return which frequencies are multiples of a mains frequency, one of which a line was found at."""
    step = hz[1] - hz[0]
    out = np.zeros(hz.size, dtype=np.bool_)
    for mains in MAINS_HZ:
        if any(abs(one - mains * max(round(one / mains), 1)) < MAINS_WITHIN_HZ for one in found_hz):
            out |= np.abs(hz - mains * np.maximum(np.round(hz / mains), 1.0)) <= step
    return out


def _local_median(values: FloatArray, width: int) -> FloatArray:
    padded = np.pad(values, ((0, 0), (width, width)), mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * width + 1, axis=1)
    return np.asarray(median(windows, axis=2))


def _refined(volts: FloatArray, rate_hz: float, near_hz: float, width_hz: float) -> float:
    """Return the frequency of a line from the turn of its demodulated amplitude, in two rounds."""
    time = np.arange(volts.shape[1]) / rate_hz
    centred = volts - volts.mean(axis=1, keepdims=True)
    frequency, size = near_hz, round(rate_hz / width_hz)
    for _ in range(2):
        amplitude = centred * np.exp(-2j * np.pi * frequency * time)
        count = amplitude.shape[1] // size
        blocks = amplitude[:, : count * size].reshape(amplitude.shape[0], count, size).mean(axis=2)
        step = float(np.angle((blocks[:, 1:] * blocks[:, :-1].conj()).sum()))
        frequency += step / (2.0 * np.pi) * rate_hz / size
    return frequency


def _take_off(volts: FloatArray, rate_hz: float, frequency_hz: float) -> None:
    """Subtract from each channel, in place, the part that keeps to a frequency over `SETTINGS.notch_s`."""
    # half a second to load, for the few records that hold a line
    from scipy.signal import oaconvolve

    size = min(2 * round(0.5 * SETTINGS.notch_s * rate_hz) + 1, volts.shape[1])
    weight = np.hanning(size + 2)[1:-1]
    time = np.arange(volts.shape[1]) / rate_hz
    turn = np.exp(-2j * np.pi * frequency_hz * time)
    # at the ends the window holds fewer samples: so it is weighed by what it holds
    held = oaconvolve(np.ones(volts.shape[1]), weight, mode="same")
    for channel in volts:
        amplitude = oaconvolve((channel - channel.mean()) * turn, weight, mode="same") / held
        channel -= 2.0 * (amplitude * turn.conj()).real
