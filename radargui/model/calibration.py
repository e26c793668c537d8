"""A calibration: where the antennas are, with the covariance of all values."""

import math
from dataclasses import dataclass, field
from typing import Annotated

from pydantic import WrapValidator

from radargui.model.arrays import FloatArray
from radargui.model.section import Real

Known = Annotated[Real, WrapValidator(lambda value, check: math.nan if value is None else check(value))]
"""A number that may be unknown: NaN here, null in a file, for JSON has no NaN."""


@dataclass(frozen=True, slots=True)
class Residual:
    """What a fitted recording leaves.

    Attributes
    ----------
    file
        Name of the recording.
    receiver
        From 1; 0 for all together.
    rms_m
        Root mean square of path length minus fitted path length.
    rms_before_m
        The same with the setup as it was.
    left_out_rms_m
        The same where this recording took no part in the fit (cross-validation); NaN where not tried.
    """

    file: str
    receiver: int
    rms_m: Known
    rms_before_m: Known
    left_out_rms_m: Known


@dataclass(frozen=True, slots=True)
class Origin:
    """Where a calibration comes from.

    Attributes
    ----------
    made_at
        ISO 8601 date and time.
    operator
        Who made it; may be empty.
    version
        Of the program.
    files
        Recordings by name, each with the SHA-256 of its content.
    known
        What was known of each recording's motion, in words: "fall", "turntable, radius 50 mm".
    """

    made_at: str
    operator: str
    version: str
    files: dict[str, str]
    known: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Calibration:
    """Values of the antennas with their covariance.

    Attributes
    ----------
    names
        Keys of the setup file, receivers counted from 1: `receiver.1.tilt_deg`, `receiver.3.distance_m`,
        `transmitter.distance_m`, `transmitter.position_m.x`, `receiver.2.polarization_deg`.
    before, values
        Shape (n,): in the setup that was there, and found; in the units of their keys.
    u_before
        Shape (n,): standard uncertainties that the setup gave.
    covariance
        Shape (n, n), of the values.
    undetermined
        Combinations that the data cannot tell, in words.
    residuals
        By recording and receiver.
    verdict
        `good`, `usable` (some parameters are known no better than the setup says) or `refused`.
    reason
        One sentence: why the verdict.
    origin
        Where it comes from.
    """

    names: tuple[str, ...]
    before: FloatArray
    values: FloatArray
    u_before: FloatArray
    covariance: FloatArray
    undetermined: tuple[str, ...]
    residuals: tuple[Residual, ...]
    verdict: str
    reason: str
    origin: Origin
    notes: tuple[str, ...] = field(default=())
