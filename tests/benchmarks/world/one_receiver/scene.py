"""A one-receiver scene and what can be known of it, fixed before any processing sees it.

The rule, from physics only. A moment (20 ms) is knowable where all of these hold:

* noise: the echo's power is 10 dB above the noise within the band that its Doppler needs, `2 max|f_d| + 100 Hz` (the
  100 Hz let the speed change within a moment). Clicks of the phase come at `B / sqrt(12) * erfc(sqrt(SNR))` a second
  (Rice 1963, FM threshold): at 10 dB and 1 kHz one in eight minutes, at 3 dB one a second.
* capture: hum, tone and other echoes together, seen through the perfectly corrected mixer, stay below half of the
  echo. The phase of a sum follows its strongest phasor: the others turn it by at most asin(1/2) = 30 degrees and can
  neither add nor take a fringe.
* range: at most 20 % of its samples are at the end of the range.
* motion: it is no part of a rest of 0.3 s or more. At rest an echo cannot be told from an offset: what is said there
  is judged, but nobody has to say it.

A scene is knowable (`ok` is expected) where the knowable moments last 0.3 s together and one run of them without a
break spans 5 wavelengths of path: a circle seen five times over tells its centre, axes and tilt (5 numbers) though the
amplitude changes. Where nothing moves, `refused` is expected (rejected or no_motion). All else is `either`: refused, or
right.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.recording import Recording
from radargui.model.setup import Setup

Expected = Literal["ok", "refused", "either"]

MOMENT_S = 0.02
SNR_IN_BAND = 10.0
ADDED_BAND_HZ = 100.0
CAPTURE = 0.5
CLIPPED = 0.2
REST_S = 0.3
REST_HZ = 2.0
MIN_S = 0.3
MIN_FRINGES = 5.0


@dataclass(frozen=True, slots=True)
class Echo:
    """One target: path in m and amplitude in V, shape (n_samples,)."""

    path_m: FloatArray
    amplitude_v: FloatArray


@dataclass(frozen=True, slots=True)
class Scene:
    """What is processed and the truth about it; `knowable` and `judged` have one entry a moment.

    `judged` is where the truth is known to the judge: everywhere (None) in a simulation.
    """

    name: str
    kind: str
    recording: Recording
    setup: Setup
    echoes: tuple[Echo, ...]
    knowable: BoolArray
    expected: Expected
    gain_ratio: float
    quadrature_error_deg: float
    judged: BoolArray | None = None

    @property
    def step(self) -> int:
        """Samples of a moment."""
        return moment_samples(self.recording.digitisation.sample_rate_hz)


def moment_samples(rate_hz: float) -> int:
    """Return how many samples a moment has."""
    return max(2, round(MOMENT_S * rate_hz))


def by_moment(values: FloatArray, step: int) -> FloatArray:
    """Return values (n_samples,) as (n_moments, step); the rest at the end is left out."""
    count = len(values) // step
    return values[: count * step].reshape(count, step)


def knowable_moments(
    echo: Echo, interference_v: FloatArray, clipped: BoolArray, noise_v: float, wavelength_m: float, rate_hz: float
) -> BoolArray:
    """Return which moments of an echo can be known, shape (n_moments,); the rule stands above.

    `interference_v` is the magnitude of all that is no echo of it, through the inverse mixer, shape (n_samples,);
    `noise_v` the standard deviation of one channel, quantisation included.
    """
    step = moment_samples(rate_hz)
    doppler_hz = np.gradient(echo.path_m) * rate_hz / wavelength_m
    band_hz = min(rate_hz, 2.0 * float(np.abs(doppler_hz).max()) + ADDED_BAND_HZ)
    weakest_v = by_moment(echo.amplitude_v, step).min(axis=1)
    strong = weakest_v**2 * rate_hz / (2.0 * noise_v**2 * band_hz) >= SNR_IN_BAND
    captured = by_moment(interference_v, step).max(axis=1) <= CAPTURE * weakest_v
    in_range = by_moment(clipped.astype(float), step).mean(axis=1) <= CLIPPED
    still = np.abs(by_moment(doppler_hz, step)).max(axis=1) < REST_HZ
    return strong & captured & in_range & ~_long_runs(still, round(REST_S / MOMENT_S))


def expectation(echo: Echo | None, knowable: BoolArray, wavelength_m: float, rate_hz: float) -> Expected:
    """Return what is expected of a scene; the rule stands above."""
    if echo is None:
        return "refused"
    step = moment_samples(rate_hz)
    spans = [np.ptp(echo.path_m[first * step : last * step]) / wavelength_m for first, last in runs(knowable)]
    enough = knowable.sum() * MOMENT_S >= MIN_S and max(spans, default=0.0) >= MIN_FRINGES
    return "ok" if enough else "either"


def runs(flags: BoolArray) -> list[tuple[int, int]]:
    """Return the ranges first:last over which flags are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return [(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def _long_runs(flags: BoolArray, least: int) -> BoolArray:
    kept = np.zeros_like(flags)
    for first, last in runs(flags):
        kept[first:last] = last - first >= least
    return kept
