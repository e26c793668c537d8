"""A calibration: where the antennas are, with the covariance of all values.

The form in which a calibration is stored: as JSON in its own file, and inside a setup.
"""

import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, WrapValidator, model_validator
from pydantic_core import to_jsonable_python

from radargui.model.arrays import FloatArray
from radargui.model.errors import FileError, worded
from radargui.model.section import ExactWhole, Real, Section, Text
from radargui.model.setup_error import describe

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


SCHEMA = 1
"""Of the file as this version writes it; what a newer one wrote is refused."""
MAXIMUM_BYTES = 10_000_000
"""More is no calibration and is not read into memory. Chosen by hand: correlations of hundreds of unknowns fit."""
MIN_EIGENVALUE = -1e-6
"""Of a matrix of correlations: below it no uncertainties can have it; rounding alone makes -1e-15."""


class CalibrationContent(Section):
    """The part of a calibration that results depend on: values, their covariance and their origin.

    Attributes
    ----------
    made_at
        ISO 8601 date and time.
    operator, verdict, reason
        Who made it; `good`, `usable` or `refused`, and why.
    names
        Keys, receivers counted from 1: `receiver.1.tilt_deg`.
    values, covariance
        Shapes (n,) and (n, n), in the units of the keys.
    """

    made_at: Text
    operator: Text = ""
    verdict: Literal["good", "usable", "refused"]
    reason: Text = ""
    names: tuple[Text, ...]
    values: tuple[Real, ...]
    covariance: tuple[tuple[Real, ...], ...]

    @model_validator(mode="after")
    def _fits_together(self) -> "CalibrationContent":
        # as objects: rows of different lengths make one axis, and are refused below
        n, covariance = len(self.names), np.array(self.covariance, dtype=object)
        if n != len(self.values) or len(set(self.names)) != n or covariance.shape != ((n, n) if n else (0,)):
            raise ValueError(f"covariance, allowed: {n} rows and columns, and a value, for {n} different names")
        if n == 0:
            return self
        matrix = np.array(self.covariance)
        u = np.sqrt(np.abs(np.diag(matrix)))
        # judged as correlations: squares of degrees and of metres have no common size
        whole = matrix / np.outer(u, u).clip(np.finfo(float).tiny)
        if (np.diag(matrix) < 0.0).any() or not np.allclose(whole, whole.T, atol=1e-6, rtol=0.0):
            raise ValueError("covariance, allowed: a symmetric matrix with squares of uncertainties on its diagonal")
        if np.linalg.eigvalsh(0.5 * (whole + whole.T))[0] < MIN_EIGENVALUE:
            raise ValueError("covariance, allowed: no combination may have a variance below 0")
        return self


class CalibrationReference(Section):
    """Where the antennas' values and their covariance come from.

    Attributes
    ----------
    file
        JSON file that `radargui calibrate` wrote, relative to the setup file; its covariance then holds instead of the
        antennas' own u_.
    max_age_days
        An older calibration is flagged.
    content
        What the file said: sessions and runs carry it along, a setup file needs none.
    """

    file: Annotated[Text, Field(min_length=1)] | None = None
    max_age_days: Annotated[Real, Field(gt=0.0, le=36500.0)] = 365.0
    content: CalibrationContent | None = None


class _StoredCalibration(CalibrationContent):
    schema_version: Annotated[Literal[1], ExactWhole, Field(alias="schema")]
    version: Text
    files: dict[str, str]
    known: tuple[str, ...]
    before: tuple[Real, ...]
    u_before: tuple[Known, ...]
    undetermined: tuple[str, ...]
    residuals: tuple[Residual, ...]
    notes: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _has_all_before(self) -> "_StoredCalibration":
        if not len(self.before) == len(self.u_before) == len(self.names):
            raise ValueError("before and u_before, allowed: one number for each name")
        return self


def content_of(calibration: Calibration) -> CalibrationContent:
    """Return what a setup carries of a calibration.

    Raises
    ------
    FileError
        Its values do not fit together.
    """
    try:
        return CalibrationContent.model_validate(_table(calibration, CalibrationContent))
    except ValidationError as error:
        raise FileError(f"the calibration cannot be used: {describe(error, CalibrationContent)}.") from None


def _table(calibration: Calibration, model: type[Section], nan: Literal["constants", "null"] = "constants") -> Any:
    """Return what a model holds of a calibration, in its order; arrays are lists."""
    whole = asdict(calibration)
    whole |= whole["origin"]
    known = {key: whole[key] for key in model.model_fields if key in whole}
    return to_jsonable_python(known, inf_nan_mode=nan, fallback=np.ndarray.tolist)


def calibration_text(calibration: Calibration) -> str:
    """Return a calibration as JSON.

    Raises
    ------
    FileError
        Its values do not fit together, or are no numbers.
    """
    content_of(calibration)
    if not np.isfinite(calibration.before).all():
        raise FileError("the calibration cannot be written: a value before it is no number.")
    whole = {"schema": SCHEMA, **_table(calibration, _StoredCalibration, "null")}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"


def parse_calibration(text: str, name: str) -> Calibration:
    """Return the calibration that a JSON text holds.

    Raises
    ------
    FileError
        Damaged, or written by a newer version.
    """
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{name} is no calibration: {' '.join(str(error).split())}.") from None
    schema = found.get("schema") if isinstance(found, dict) else None
    if isinstance(schema, int) and schema > SCHEMA:
        raise worded(FileError, "newer_version", path=name, format=schema, this="this version", known=SCHEMA)
    try:
        stored = _StoredCalibration.model_validate(found)
    except ValidationError as error:
        raise FileError(f"{name} is damaged: {describe(error, _StoredCalibration)}.") from None
    n, vectors = len(stored.names), (stored.before, stored.values, stored.u_before)
    covariance = np.array(stored.covariance, dtype=np.float64).reshape(n, n)
    before, values, u_before = (np.array(one, dtype=np.float64) for one in vectors)
    origin = Origin(stored.made_at, stored.operator, stored.version, stored.files, stored.known)
    found, said = (stored.undetermined, stored.residuals), (stored.verdict, stored.reason)
    return Calibration(stored.names, before, values, u_before, covariance, *found, *said, origin, stored.notes)


def read_calibration(path: Path) -> Calibration:
    """Return the calibration in a file.

    Raises
    ------
    FileError
        Unreadable, damaged, or written by a newer version.
    """
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise FileError(f"{path} is larger than a calibration can be.")
        return parse_calibration(path.read_text(encoding="utf-8"), str(path))
    except UnicodeDecodeError:
        raise FileError(f"{path} is no calibration: not UTF-8 text.") from None
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}.") from None
