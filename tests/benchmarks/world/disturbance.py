"""What a disturbance of a real room may touch on the way from the echo to the codes; by itself it touches nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from radargui.model.recording import Gap

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Codes = NDArray[np.int16]


class Disturbance:
    """One disturbance; the sphere's true motion is never part of it.

    Echoes are in units of the sphere's echo at the centre, in the frame in which the phase grows with the path.
    """

    def echo(self, receiver: int, time_s: Array, place_m: Array, echo: Complex) -> Complex:
        """Return what a receiver (from 0) gets at times (n,) instead of `echo` (n,), the sphere at places (3, n)."""
        del receiver, time_s, place_m
        return echo

    def volts(self, channel: int, time_s: Array, volts: Array, amplitude_v: float) -> Array:
        """Return a channel's voltage at times (n,) before the multiplexer; `amplitude_v` is the echo's on I."""
        del channel, time_s, amplitude_v
        return volts

    def codes(self, codes: Codes) -> Codes:
        """Return what the computer gets of the converter's codes (n_channels, n)."""
        return codes

    def lost(self, rate_hz: float) -> tuple[Gap, ...]:
        """Return the samples that never come."""
        del rate_hz
        return ()
