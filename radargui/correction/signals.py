"""The scaled samples of a recording: what every estimator starts from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.correction.hum import without_hum
from radargui.correction.noise import noise_deviation
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.recording import Recording
from radargui.motion.segment import find_segment, floor_of_noise, held


@dataclass(frozen=True, slots=True)
class Signals:
    """Samples in about one amplitude, the wiring's sign applied.

    Attributes
    ----------
    time_s
        Of channel 0, shape (n_samples,).
    value
        I1, Q1, I2, ... divided by `scale_v`; Q negated where the wiring inverts it, shape (2 n_receivers, n_samples).
    usable
        False where any channel is clipped or not a number, shape (n_samples,).
    sigma
        White noise of each channel in amplitudes, shape (2 n_receivers,).
    scale_v
        sqrt(2) x standard deviation while moving, one a receiver, shape (n_receivers,).
    delay_s
        Delay of each channel against channel 0, shape (2 n_receivers,).
    rate_hz
        Samples per second.
    phase_sign
        Sign of the wiring.
    """

    time_s: FloatArray
    value: FloatArray
    usable: BoolArray
    sigma: FloatArray
    scale_v: FloatArray
    delay_s: FloatArray
    rate_hz: float
    phase_sign: int

    @property
    def n_receivers(self) -> int:
        """Number of IQ pairs."""
        return int(self.scale_v.size)


def read_signals(recording: Recording, phase_sign: int) -> Signals:
    """Scale a recording's channel pairs to about one amplitude and measure their noise.

    Raises
    ------
    ProcessingError
        Fewer than 64 samples, or a pair that never changes.
    """
    if recording.n_samples < 64:
        raise ProcessingError("The recording is too short.", remedy="Record at least 0.2 s.")
    rate_hz = recording.digitisation.sample_rate_hz
    volts = recording.volts()
    unusable = ~np.isfinite(volts) | recording.clipped()
    volts = held(volts)
    noise_v = floor_of_noise(volts)
    volts = without_hum(volts, rate_hz, find_segment(volts, rate_hz, noise_v), noise_v)
    n_receivers = recording.n_receivers
    pairs = volts[: 2 * n_receivers].reshape(n_receivers, 2, -1)
    scale: FloatArray = np.sqrt(2.0) * np.median(pairs.std(axis=2), axis=1)
    if not (scale > 0).all():
        raise ProcessingError(
            "A receiver's channels never change.", reasons=("a cable is off",), remedy="Look at the scope."
        )
    value = pairs / scale[:, None, None]
    value[:, 1] *= phase_sign
    value = np.asarray(value.reshape(2 * n_receivers, -1), dtype=np.float64)
    delay = recording.digitisation.channel_skew_s * np.arange(2 * n_receivers, dtype=np.float64)
    return Signals(
        recording.time_s(),
        value,
        np.asarray(~unusable[: 2 * n_receivers].any(axis=0)),
        np.asarray(noise_deviation(value), dtype=np.float64),
        np.asarray(scale, dtype=np.float64),
        delay,
        rate_hz,
        phase_sign,
    )
