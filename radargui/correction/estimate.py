"""What every accurate estimator hands on: motion, corrected IQ, uncertainties, hardware constants, quality."""

from __future__ import annotations

from dataclasses import dataclass, field

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.quality import ChannelQuality


@dataclass(frozen=True, slots=True)
class HardwareConstants:
    """Constants of one receiver's front end with standard uncertainties.

    Attributes
    ----------
    gain_ratio, u_gain_ratio
        Amplitude of Q over amplitude of I.
    quadrature_error_deg, u_quadrature_error_deg
        Departure of Q from 90 degrees after I.
    offset_v, u_offset_v
        Mean offsets of I and Q while moving.
    """

    gain_ratio: float
    u_gain_ratio: float
    quadrature_error_deg: float
    u_quadrature_error_deg: float
    offset_v: tuple[float, float]
    u_offset_v: tuple[float, float]


@dataclass(frozen=True, slots=True)
class MotionEstimate:
    """The motion and the corrected IQ of one recording.

    Attributes
    ----------
    method
        adaptive or joint.
    time_s
        Shape (n_samples,).
    change_m, u_change_m
        Change of each path length against the rest, shape (n_receivers, n_samples); NaN where unknown.
    i, q
        On the unit circle, at the time of channel 0, shape (n_receivers, n_samples).
    valid
        Shape (n_receivers, n_samples).
    position_m, u_position_m
        Shape (3, n_samples); None with fewer than three receivers.
    onset_s
        End of the rest.
    impact_s, u_impact_s
        Shape (n_impacts,).
    constants, channels
        One a receiver.
    chi_square
        Mean squared residual in units of the measured noise, one a receiver, shape (n_receivers,).
    choices
        What the evidence chose, one sentence each.
    """

    method: str
    time_s: FloatArray = field(repr=False)
    change_m: FloatArray = field(repr=False)
    u_change_m: FloatArray = field(repr=False)
    i: FloatArray = field(repr=False)
    q: FloatArray = field(repr=False)
    valid: BoolArray = field(repr=False)
    position_m: FloatArray | None = field(repr=False)
    u_position_m: FloatArray | None = field(repr=False)
    onset_s: float
    impact_s: FloatArray
    u_impact_s: FloatArray
    constants: tuple[HardwareConstants, ...]
    channels: tuple[ChannelQuality, ...]
    chi_square: FloatArray
    choices: tuple[str, ...]
