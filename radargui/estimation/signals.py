"""Scale the conditioned voltages of each receiver to an amplitude of about one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.finding import error_of
from radargui.model.front_end import FrontEnd, noise_across, point_of, with_phase_sign
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.signals.conditioned import Conditioned
from radargui.signals.doppler import Doppler
from radargui.signals.spectral_front_end import front_end_of


@dataclass(frozen=True, slots=True)
class ScaledSignals:
    """Samples in about one amplitude.

    Attributes
    ----------
    time_s
        Of channel 0, shape (n_samples,).
    value
        I1, Q1, I2, ... divided by `scale_v`, shape (2 n_receivers, n_samples).
    usable
        False where any channel is clipped or not a number, or the echo of one or two receivers is lost, shape
        (n_samples,).
    valid
        Where a receiver's channels can be used and its echo is there, shape (n_receivers, n_samples).
    unusable_share
        Share of such samples of each receiver, shape (n_receivers,).
    sigma
        White noise of each channel in amplitudes, shape (2 n_receivers,).
    scale_v
        sqrt(2) x standard deviation, one a receiver, shape (n_receivers,).
    delay_s
        Delay of each channel against channel 0, shape (2 n_receivers,).
    mixers
        What is taken off each receiver already, where its gain ratio or quadrature error is too large for a start from
        a circle; else None.
    before
        What a volt of the channel before is in units of each channel, for the multiplexer's crosstalk; None where
        mixers are taken off already, shape (2 n_receivers,).
    rate_hz
        Samples per second.
    rest_end_s
        Until here the tracer rests for sure; the first sample's time where it begins in motion.
    onset_s
        Last time at which it still looks at rest; the first sample's time where it begins in motion.
    spread_s
        Standard deviation of the times that each sample is the mean of; 0 where it is none.
    """

    time_s: FloatArray
    value: FloatArray
    usable: BoolArray
    valid: BoolArray
    unusable_share: FloatArray
    sigma: FloatArray
    scale_v: FloatArray
    delay_s: FloatArray
    mixers: tuple[FrontEnd | None, ...]
    before: FloatArray | None
    rate_hz: float
    rest_end_s: float
    onset_s: float
    spread_s: float = 0.0

    @property
    def n_receivers(self) -> int:
        """Number of IQ pairs."""
        return int(self.scale_v.size)

    @property
    def has_rest(self) -> bool:
        """Whether the record begins at rest."""
        return self.onset_s > float(self.time_s[0])


def scaled_signals(
    conditioned: Conditioned, front_end: Callable[[Doppler], FrontEnd | None] = front_end_of
) -> ScaledSignals:
    """Scale conditioned channel pairs to about one amplitude.

    Parameters
    ----------
    conditioned
        The channels.
    front_end
        Says what a receiver's Doppler signal tells of its front end, None where it tells nothing.

    Raises
    ------
    ProcessingError
        A pair never changes.
    """
    n_receivers = conditioned.n_receivers
    mixers = tuple(_mixer(front_end(own)) for own in conditioned.doppler)
    volts, noise_v, delay_s = conditioned.volts.copy(), conditioned.noise_v.copy(), conditioned.delay_s.copy()
    usable = (conditioned.usable if n_receivers >= MIN_RECEIVERS else conditioned.valid).all(axis=0)
    for k, mixer in enumerate(mixers):
        if mixer is not None:
            pair = slice(2 * k, 2 * k + 2)
            gain, eps = mixer.gain_ratio, float(np.radians(mixer.quadrature_error_deg))
            i, q = conditioned.at_one_time_v[pair]
            # before a channel's first sample there is nothing to interpolate: extrapolated, it was 48 deviations off
            usable &= conditioned.time_s >= conditioned.time_s[0] + delay_s[pair].max()
            volts[pair], delay_s[pair] = point_of(i, q, gain, eps), 0.0
            noise_v[2 * k + 1] = noise_across(noise_v[2 * k], noise_v[2 * k + 1], gain, eps)
    pairs = volts.reshape(n_receivers, 2, -1)
    # a sine has the amplitude sqrt(2) of its deviation; I and Q share one scale, or their gain ratio would be lost in
    # it
    scale: FloatArray = np.sqrt(2.0) * np.median(pairs.std(axis=2), axis=1)
    if not (scale > 0).all():
        raise error_of(
            ProcessingError, "channels_never_change", reasons=("a cable is off",), remedy="Look at the scope."
        )
    return ScaledSignals(
        conditioned.time_s,
        np.asarray((pairs / scale[:, None, None]).reshape(2 * n_receivers, -1)),
        np.asarray(usable),
        conditioned.valid,
        conditioned.unusable_share,
        np.asarray(noise_v / np.repeat(scale, 2)),
        scale,
        delay_s,
        mixers,
        None if any(mixers) else _before(scale, conditioned.phase_sign),
        conditioned.sample_rate_hz,
        conditioned.rest_end_s,
        max(conditioned.onset_s, float(conditioned.time_s[0])),
        # n times a step apart have a variance of (n^2 - 1) / 12 squared steps, and n steps are one sample here
        float(np.sqrt((1.0 - 1.0 / conditioned.size**2) / 12.0)) / conditioned.sample_rate_hz,
    )


def _before(scale_v: FloatArray, phase_sign: int) -> FloatArray:
    """Return unit and sign of the channel before over those of each channel, shape (2 n_receivers,)."""
    unit = with_phase_sign(np.repeat(scale_v, 2), phase_sign)
    return np.asarray(np.roll(unit, 1) / unit)


LARGE_LOG_GAIN, LARGE_ERROR_DEG = 0.25, 18.0
"""From here on the front end is taken off first: the estimates' priors hold ln g and eps to about 0.15 of zero."""


def _mixer(found: FrontEnd | None) -> FrontEnd | None:
    """Return a front end that is far from a perfect one, None for one that is near."""
    if found is None:
        return None
    return found if is_far(float(np.log(found.gain_ratio)), float(np.radians(found.quadrature_error_deg))) else None


def is_far(log_gain: float, quadrature_error_rad: float) -> bool:
    """Return whether a front end is far from a perfect one."""
    return abs(log_gain) >= LARGE_LOG_GAIN or abs(np.degrees(quadrature_error_rad)) >= LARGE_ERROR_DEG


def composed(constants: Sequence[FrontEnd], signals: ScaledSignals) -> tuple[FrontEnd, ...]:
    """Return the front ends' constants, those that were taken off first included."""
    pairs = zip(constants, signals.mixers, strict=True)
    return tuple(own if mixer is None else own.after(mixer) for own, mixer in pairs)


def remaining(constants: Sequence[FrontEnd], signals: ScaledSignals) -> tuple[FrontEnd, ...]:
    """Return what is left of known constants in the signals: the inverse of `composed`."""
    pairs = zip(constants, signals.mixers, strict=True)
    return tuple(own if mixer is None else own.less(mixer) for own, mixer in pairs)
