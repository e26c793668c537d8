"""The correction in the Doppler band: front end from the spectra, offset and disturbances filtered away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import butter, sosfiltfilt

from radargui.conditioning.conditioned import Conditioned
from radargui.conditioning.doppler import Doppler
from radargui.correction.phase import unwrap, wrapped_phase
from radargui.correction.quality import assess
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.front_end import FrontEnd
from radargui.model.front_end_equations import point_of
from radargui.model.quality import ChannelQuality


@dataclass(frozen=True, slots=True)
class BandSettings:
    """How the band is cut out.

    Attributes
    ----------
    lower, upper
        Corners of the band as shares of the slowest and of the fastest clear line (one in ten is slower, one in twenty
        faster). Order 3, there and back, keeps the phase.
    lowest_hz
        Least lower corner.
    envelope_s
        Over which the strength of the echo is averaged, and at least two periods.
    least_frames
        Clear frames without which there is no band.
    least_u
        Standard uncertainties of ln gain and quadrature error (rad) below which spectra are not believed: runs of one
        receiver differ by this.
    """

    lower: float = 0.5
    upper: float = 1.5
    lowest_hz: float = 4.0
    envelope_s: float = 0.02
    least_frames: int = 6
    least_u: float = 0.004


SETTINGS = BandSettings()


@dataclass(frozen=True, slots=True)
class InBand:
    """One receiver's echo in its Doppler band.

    Attributes
    ----------
    iq
        On the unit circle, shape (2, n_samples).
    phase_rad, u_phase_rad
        Unwrapped, and its standard uncertainty, shape (n_samples,).
    valid
        Where the target is within the band, shape (n_samples,).
    lower_hz
        Below, nothing is known.
    front_end
        Gain ratio and quadrature error from the spectra.
    quality
        Of the receiver.
    """

    iq: FloatArray
    phase_rad: FloatArray
    u_phase_rad: FloatArray
    valid: BoolArray
    lower_hz: float
    front_end: FrontEnd
    quality: ChannelQuality


def front_end_of(doppler: Doppler, settings: BandSettings = SETTINGS) -> FrontEnd | None:
    """Return gain ratio and quadrature error from the lines of I and Q, None with too few clear frames.

    At a line Q / I = g exp(-+ j (90 degrees - eps)), whatever the offset; the sign is that of the motion. Medians over
    the frames; their uncertainty from the spread, half of the frames being independent (they overlap).
    """
    clear = doppler.clear
    count = int(clear.sum())
    if count < settings.least_frames:
        return None
    log_gain = np.log(np.maximum(np.abs(doppler.q[clear]), 1e-300) / np.maximum(np.abs(doppler.i[clear]), 1e-300))
    eps = 0.5 * np.pi - np.abs(np.angle(doppler.q[clear] * doppler.i[clear].conj()))
    values, spreads = [], []
    for one in (log_gain, eps):
        middle = float(np.median(one))
        values.append(middle)
        deviation = 1.4826 * float(np.median(np.abs(one - middle)))
        spreads.append(float(np.hypot(1.25 * deviation / np.sqrt(0.5 * count), settings.least_u)))
    gain = float(np.exp(values[0]))
    return FrontEnd(gain, gain * spreads[0], float(np.degrees(values[1])), float(np.degrees(spreads[1])))


def correct_in_band(conditioned: Conditioned, number: int, settings: BandSettings = SETTINGS) -> InBand | None:
    """Correct one receiver in the band of its Doppler frequencies; None where there is no such band.

    What is slower than the target (offset, drift, bias of standing reflections) and what is faster (tones, noise) are
    filtered away; the front end comes from the spectra. Right wherever the target moves faster than the band's lower
    corner, and unknown where it does not.

    Parameters
    ----------
    conditioned
        All receivers.
    number
        The one, from 0.
    settings
        How the band is cut out.
    """
    doppler, rate_hz = conditioned.doppler[number], conditioned.sample_rate_hz
    front_end = front_end_of(doppler, settings)
    if front_end is None:
        return None
    slow, fast = np.quantile(doppler.frequency_hz[doppler.clear], [0.1, 0.95])
    lower, upper = max(settings.lower * float(slow), settings.lowest_hz), settings.upper * float(fast)
    pair = conditioned.at_one_time()[2 * number : 2 * number + 2]
    if upper < 0.4 * rate_hz:
        sos = butter(3, [lower, upper], "bandpass", fs=rate_hz, output="sos")
    else:
        sos = butter(3, lower, "highpass", fs=rate_hz, output="sos")
    filtered = sosfiltfilt(sos, pair, axis=1)
    eps = float(np.radians(front_end.quadrature_error_deg))
    point = point_of(filtered[0], filtered[1], front_end.gain_ratio, eps)
    window = max(3, round(max(settings.envelope_s, 2.0 / float(slow)) * rate_hz))
    power = uniform_filter1d((point**2).sum(axis=0), window, mode="nearest")
    amplitude = np.sqrt(np.maximum(power, 1e-300))
    iq = point / amplitude
    noise_v = float(np.sqrt(np.mean(conditioned.noise_v[2 * number : 2 * number + 2] ** 2)))
    band_share = min(1.0, 2.0 * (min(upper, 0.5 * rate_hz) - lower) / rate_hz)
    noise = noise_v * np.sqrt(band_share) / amplitude
    valid = conditioned.valid[number] & _in_band(doppler, conditioned.n_samples, lower)
    phase = unwrap(wrapped_phase(iq[None, 0], iq[None, 1]))[0]
    moving = slice(conditioned.segment.first, conditioned.segment.last)
    quality = assess(
        str(number + 1),
        iq=iq[:, moving],
        phase_rad=phase[moving],
        valid=valid[moving],
        noise=float(np.median(noise[valid])) / np.sqrt(band_share) if valid.any() else 1.0,
        counted_noise=float(np.median(noise[valid])) if valid.any() else 1.0,
        fraction_clipped=float(conditioned.unusable_share[number]),
        gain_ratio=front_end.gain_ratio,
        quadrature_error_deg=front_end.quadrature_error_deg,
        u_gain_ratio=front_end.u_gain_ratio,
        u_quadrature_error_deg=front_end.u_quadrature_error_deg,
    )
    mismatch = quality.circularity or 0.0
    return InBand(iq, phase, np.hypot(noise, mismatch), valid, lower, front_end, quality)


def _in_band(doppler: Doppler, n_samples: int, lower_hz: float) -> BoolArray:
    """Return where a line is seen above a frequency, each sample judged by the frame around it."""
    out = np.zeros(n_samples, dtype=np.bool_)
    reach = doppler.size // 4 + 1
    seen = (doppler.clear | doppler.mixed) & (doppler.frequency_hz > lower_hz)
    for centre in doppler.centre[seen]:
        out[max(centre - reach, 0) : centre + reach] = True
    if seen.any() and seen[0]:
        out[max(int(doppler.centre[0]) - 2 * reach, 0) : int(doppler.centre[0])] = True
    if seen.any() and seen[-1]:
        out[int(doppler.centre[-1]) : int(doppler.centre[-1]) + 2 * reach] = True
    return out
