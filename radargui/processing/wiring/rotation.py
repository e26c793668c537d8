"""Which way the phase of a pair of channels turns while the tracer moves away."""

from __future__ import annotations

import numpy as np

from radargui.correction.ellipse import fit_ellipse
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError

CLEAR = 0.3
"""Least difference between the power that turns one way and the other, relative to their sum."""
SAME = 0.98
"""Correlation from which two channels carry the same signal."""

_SLOWEST_HZ, _FASTEST_HZ = 0.5, 200.0


def turning(pair_v: FloatArray, rate_hz: float) -> float:
    """Return the power of I + jQ at positive minus that at negative frequencies over their sum, -1 to 1.

    A phase that rises turns the positive way. Offset, unequal gains and a quadrature error only add an image of less
    power on the other side. 0 where there is nothing.

    Parameters
    ----------
    pair_v
        I and Q in volts, shape (2, n_samples).
    rate_hz
        Samples per second.
    """
    known = pair_v[:, np.isfinite(pair_v).all(axis=0)]
    if known.shape[1] < 8:
        return 0.0
    signal = known - known.mean(axis=1, keepdims=True)
    spectrum = np.abs(np.fft.fft((signal[0] + 1j * signal[1]) * np.hanning(signal.shape[1]))) ** 2
    frequency = np.fft.fftfreq(signal.shape[1], 1.0 / rate_hz)
    wanted = (np.abs(frequency) >= _SLOWEST_HZ) & (np.abs(frequency) <= _FASTEST_HZ)
    up, down = spectrum[wanted & (frequency > 0)].sum(), spectrum[wanted & (frequency < 0)].sum()
    return float((up - down) / (up + down)) if up + down > 0.0 else 0.0


def is_same_signal(pair_v: FloatArray) -> bool:
    """Return whether two channels, shape (2, n_samples), carry the same signal, be it with the other sign."""
    known = pair_v[:, np.isfinite(pair_v).all(axis=0)]
    if known.shape[1] < 8 or (known.std(axis=1) == 0.0).any():
        return False
    return bool(abs(float(np.asarray(np.corrcoef(known))[0, 1])) >= SAME)


def turns(pair_v: FloatArray) -> float | None:
    """Return by how many turns the phase of a pair, shape (2, n_samples), went on; None where it is no ellipse."""
    known = pair_v[:, np.isfinite(pair_v).all(axis=0)]
    try:
        x, y = fit_ellipse(known).apply(known)
    except ProcessingError:
        return None
    phase = np.unwrap(np.arctan2(y, x))
    return float((phase[-1] - phase[0]) / (2.0 * np.pi)) if np.isfinite(phase).all() else None
