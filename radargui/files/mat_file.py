"""MATLAB files, v5 and 7.3: real vectors, also inside structures (`src1.Data`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
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

    The sample rate is a number named `SampleFrequency`, `Fs` or alike beside a vector, or else at the top.

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
    return Signals(tuple(signals), sample_rate_hz=rates.pop(), time_s=time_s)


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
