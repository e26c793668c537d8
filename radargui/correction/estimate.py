"""What every accurate estimator hands on: motion, corrected IQ, uncertainties, constants, quality."""

from __future__ import annotations

from dataclasses import dataclass, field

from radargui.correction.hardware import HardwareConstants
from radargui.correction.verdict import WORST_MISFIT
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.quality import ChannelQuality


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

    @property
    def fits(self) -> bool:
        """Whether the misfit is small enough in every receiver: else a simpler correction must stand in."""
        return bool((self.chi_square <= WORST_MISFIT).all())
