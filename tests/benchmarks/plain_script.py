"""The published procedure as a plain script would have it: numpy and scipy, at the full rate, nothing else checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d
from scipy.signal import find_peaks

from radargui.model.setup import Setup

Array = NDArray[np.float64]
BLOCK_S, SMOOTHING_S, SHARE = 0.005, 0.0008, 0.35


def plain_track(volts: Array, rate_hz: float, setup: Setup) -> tuple[Array, slice]:
    """Return positions by the plane-wave T in the motion, shape (3, n), and where it is (Rech & Huang 2019)."""
    moving = motion_of(volts, rate_hz)
    inside = volts[:, moving]
    corrected = np.stack([rescaled(channel, rate_hz) for channel in inside])
    phase = np.unwrap(setup.radar.phase_sign * np.arctan2(corrected[1::2], corrected[0::2]), axis=1)
    change_m = (phase - phase[:, :1]) * setup.radar.wavelength_m / (2.0 * np.pi)
    tilt, azimuth = np.radians([(one.tilt_deg, one.azimuth_deg) for one in setup.receiver]).T
    rows = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), 1.0 + np.cos(tilt)], axis=1)
    position = np.asarray(setup.tracer.release_position_m)[:, None] - np.linalg.solve(rows, change_m)
    return position, moving


def motion_of(volts: Array, rate_hz: float) -> slice:
    """Return the samples between the first and the last block that scatters more than three times the quiet ones."""
    size = round(BLOCK_S * rate_hz)
    count = volts.shape[1] // size
    scatter = volts[:, : count * size].reshape(volts.shape[0], count, size).std(axis=2).max(axis=0)
    loud = np.flatnonzero(scatter > 3.0 * np.quantile(scatter, 0.1))
    return slice(int(loud[0]) * size, (int(loud[-1]) + 1) * size)


def rescaled(channel: Array, rate_hz: float) -> Array:
    """Return a channel less the mean of its envelopes, over its local extreme between zero crossings."""
    smooth = uniform_filter1d(channel, max(1, round(SMOOTHING_S * rate_hz)))
    # extremes at a tenth of a millisecond: every wiggle of the noise costs
    step = max(1, round(1e-4 * rate_hz))
    thin = smooth[::step]
    least = SHARE * np.ptp(thin)
    peaks, valleys = (step * find_peaks(sign * thin, prominence=least)[0] for sign in (1.0, -1.0))
    at = np.arange(channel.size)
    bias = 0.5 * (CubicSpline(peaks, smooth[peaks])(at) + CubicSpline(valleys, smooth[valleys])(at))
    first, last = max(peaks[0], valleys[0]), min(peaks[-1], valleys[-1])
    bias[:first], bias[last:] = bias[first], bias[last]
    centred = channel - bias
    edges = np.concatenate([[0], np.flatnonzero(np.diff(np.signbit(smooth - bias))) + 1])
    height = np.maximum.reduceat(np.abs(smooth - bias), edges)
    # between wiggles round zero there is no extreme of the circle
    whole = np.flatnonzero(height > 0.5 * np.median(height))
    height = np.interp(np.arange(height.size), whole, height[whole])
    return np.asarray(centred / np.repeat(height, np.diff(np.append(edges, channel.size))))
