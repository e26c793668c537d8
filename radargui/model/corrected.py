"""Corrected IQ: each receiver's I and Q brought onto the unit circle."""

from dataclasses import dataclass

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.quality import ChannelQuality


@dataclass(frozen=True, slots=True)
class CorrectedIQ:
    """I and Q without mismatch.

    Attributes
    ----------
    time_s
        Shape (n_samples,).
    i, q
        In amplitudes (unit circle), shape (n_receivers, n_samples); NaN where unknown.
    valid
        Shape (n_receivers, n_samples).
    u_phase_rad
        Standard uncertainty of the phase, shape (n_receivers, n_samples).
    method
        Correction used: joint, adaptive, published, ellipse or none
    channels
        Quality of each receiver.
    steps
        What the correction found on its way, one entry a receiver, for display: PublishedSteps, Ellipse or None.
    """

    time_s: FloatArray
    i: FloatArray
    q: FloatArray
    valid: BoolArray
    u_phase_rad: FloatArray
    method: str
    channels: tuple[ChannelQuality, ...]
    steps: tuple[object, ...] = ()
