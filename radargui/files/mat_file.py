"""MATLAB files, v5 and 7.3: real vectors, also inside structures (`src1.Data`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from radargui.files import hdf5
from radargui.files.mat_variable import Variable
from radargui.files.refusal import listed, reading, resolved
from radargui.files.signals import TIME_NAME, ChannelInfo, Signal, Signals
from radargui.model.errors import FileError

WHAT = "a MATLAB file"
RATE_NAMES = ("samplefrequency", "samplerate", "sample_rate_hz", "sample_rate", "samplingrate", "rate_hz", "fs")
"""Variables or fields that hold samples per second, small letters."""
UNIT_NAMES = ("unit", "units")
DATE_NAMES = ("datetime", "date_time", "started_at", "start_time", "starttime", "startdate", "start_date", "timestamp")
"""Variables or fields that hold when the recording began."""
_YEAR_ZERO_DAYS = 366
"""Days by which MATLAB's datenum (day 1: 1 January of the year 0) is ahead of Python's ordinal (1 January of 1)."""
_DATESTR = "%d-%b-%Y %H:%M:%S"
"""What MATLAB's `datestr` writes unless told otherwise."""


def list_mat(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the vectors in a MATLAB file.

    Raises
    ------
    FileError
        Unreadable or no MATLAB file.
    """
    variables = _variables(path, ())
    return tuple(
        ChannelInfo(name, variable.shape[0], _rate(variables, name), _unit(variables, name))
        for name, variable in variables.items()
        if variable.is_vector and name != TIME_NAME
    )


def read_mat(path: Path, names: Sequence[str]) -> Signals:
    """Return vectors of a MATLAB file; a vector `time_s` of the same length gives the file's own time.

    The sample rate is a number named `SampleFrequency`, `Fs` or alike beside a vector, or else at the top; the start a
    `DateTime` or alike there: a datenum, a clock vector or a text.

    Raises
    ------
    FileError
        Unreadable, no MATLAB file, a variable missing or no real vector.
    """
    variables = _variables(path, (*names, TIME_NAME))
    vectors = [name for name, variable in variables.items() if variable.is_vector]
    own = resolved(path, names, list(variables), vectors)
    signals = []
    for name in own:
        variable = variables[name]
        if not isinstance(variable.value, np.ndarray):
            shape = " x ".join(str(size) for size in variable.shape) or "a single value"
            raise FileError(
                f"{path}: {name} is no real vector ({shape}).", remedy=f"Vectors in it: {listed(vectors) or 'none'}."
            )
        signals.append(Signal(name, variable.value, unit=_unit(variables, name)))
    rates = {_rate(variables, name) for name in own}
    if len(rates) > 1:
        raise FileError(f"{path}: its vectors have different sample rates.")
    time_s = variables[TIME_NAME].value if TIME_NAME in variables else None
    if not isinstance(time_s, np.ndarray) or time_s.size != signals[0].samples.size:
        time_s = None
    return Signals(tuple(signals), sample_rate_hz=rates.pop(), time_s=time_s, started_at=_started(variables, own[0]))


def _variables(path: Path, wanted: Sequence[str]) -> dict[str, Variable]:
    with reading(path, WHAT):
        if hdf5.is_hdf5(path):
            from radargui.files.mat73 import read_variables

            return read_variables(path, wanted)
        from radargui.files.mat5 import read_variables as read_v5

        return read_v5(path)


def _beside(variables: dict[str, Variable], name: str, keys: Sequence[str]) -> list[Variable]:
    """Return variables of these names beside `name`, then at the top."""
    parents = [name.rpartition(".")[0], ""]
    return [
        variable
        for parent in parents
        for other, variable in variables.items()
        if other.rpartition(".")[0] == parent and other.rpartition(".")[2].lower() in keys
    ]


def _rate(variables: dict[str, Variable], name: str) -> float | None:
    for variable in _beside(variables, name, RATE_NAMES):
        value = variable.value
        if isinstance(value, float) and math.isfinite(value) and value > 0.0:
            return value
    return None


def _unit(variables: dict[str, Variable], name: str) -> str:
    found = _beside(variables, name, UNIT_NAMES)
    return next((variable.value.strip()[:32] for variable in found if isinstance(variable.value, str)), "")


def _started(variables: dict[str, Variable], name: str) -> str:
    for variable in _beside(variables, name, DATE_NAMES):
        try:
            started = _date(variable.value)
        except (ValueError, OverflowError):
            continue
        if started:
            return started
    return ""


def _date(value: object) -> str:
    """Return ISO 8601, without an offset where the file tells none; empty for what is no date."""
    if isinstance(value, str):
        try:
            return datetime.fromisoformat(value.strip()).isoformat()
        except ValueError:
            return datetime.strptime(value.strip(), _DATESTR).isoformat()  # noqa: DTZ007  the file tells no zone
    if isinstance(value, np.ndarray) and value.shape == (6,):
        year, month, day, hour, minute = (int(part) for part in value[:5])
        start = datetime(year, month, day, hour, minute) + timedelta(seconds=float(value[5]))  # noqa: DTZ001
    elif isinstance(value, float) and math.isfinite(value) and value >= _YEAR_ZERO_DAYS + 1:
        start = datetime.fromordinal(int(value) - _YEAR_ZERO_DAYS) + timedelta(days=value % 1.0)
    else:
        return ""
    # a datenum of our days resolves 10 us
    return start.isoformat(timespec="milliseconds")
