"""Read and write NI TDMS files through npTDMS; int16 codes with a polynomial scaling remain codes."""

import io
import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from radargui.files.access import Progress, listed, reading, resolved
from radargui.files.run_file import ExportFacts, RunStream, facts_of_text
from radargui.files.signals import ChannelInfo, Signal, Signals, rate_of_step
from radargui.model.arrays import FloatArray
from radargui.model.errors import FileError, worded

_RAW = 0xFFFFFFFF
"""Input of a scale that takes the samples as they are stored."""
_HIGHEST_DEGREE = 12
"""NI devices store polynomials of degree 1 to 3; linear scales chained to one do not raise it. Chosen by hand."""
_MAX_SCALES = 64
"""A chain of that many is damage; each costs a step. Chosen by hand."""
_KINDS = frozenset(
    ["Linear", "Polynomial", "RTD", "Strain", "Table", "Thermistor", "Thermocouple", "Add", "Subtract", "AdvancedAPI"]
)
_LINEAR, _POLYNOMIAL = "Linear", "Polynomial"


def is_sound(properties: Mapping[str, Any]) -> bool:
    """Return whether the scales of a channel can be true: not too many, each of a kind that TDMS knows.

    The reading library leaves out a scale of an unknown kind, which would make codes pass for volts.
    """
    count = properties.get("NI_Number_Of_Scales", 0)
    if not isinstance(count, int | np.integer) or not 0 <= count <= _MAX_SCALES:
        return False
    kinds = [properties.get(f"NI_Scale[{index}]_Scale_Type") for index in range(int(count))]
    return not kinds or (kinds[-1] is not None and all(kind is None or kind in _KINDS for kind in kinds))


def code_polynomial(properties: Mapping[str, Any]) -> tuple[float, ...] | None:
    """Return c_k of value = sum c_k code^k, or None where the scaling is not a polynomial.

    Scale i takes the output of another scale or the codes; the last scale gives the values. A scale without
    properties is the device's own and passes the codes on.
    """
    if not is_sound(properties):
        return None
    codes = Polynomial([0.0, 1.0])
    outputs: dict[int, Polynomial] = {}
    last = codes
    for index in range(int(properties.get("NI_Number_Of_Scales", 0))):
        prefix = f"NI_Scale[{index}]"
        kind = properties.get(f"{prefix}_Scale_Type")
        if kind is None:
            outputs[index] = codes
            continue
        source = properties.get(f"{prefix}_{kind}_Input_Source", _RAW)
        inner = codes if source == _RAW else outputs.get(int(source))
        outer = _coefficients(properties, prefix, kind)
        if inner is None or outer is None or (len(outer) - 1) * inner.degree() > _HIGHEST_DEGREE:
            return None
        last = outputs[index] = Polynomial(outer)(inner)
    return tuple(last.coef.tolist()) if np.isfinite(last.coef).all() else None


def _coefficients(properties: Mapping[str, Any], prefix: str, kind: str) -> list[float] | None:
    if kind == _LINEAR:
        keys = [f"{prefix}_Linear_Y_Intercept", f"{prefix}_Linear_Slope"]
    elif kind == _POLYNOMIAL:
        count = properties.get(f"{prefix}_Polynomial_Coefficients_Size", 4)
        if not 1 <= int(count) <= _HIGHEST_DEGREE + 1:
            return None
        keys = [f"{prefix}_Polynomial_Coefficients[{order}]" for order in range(int(count))]
    else:
        return None
    return [float(properties[key]) for key in keys] if all(key in properties for key in keys) else None


WHAT = "an NI TDMS file"
_VOLTS = {"volts": "V", "volt": "V"}
_COMPARED = 4096
"""Values on which our scaling must agree with the library's: enough to meet most codes of a signal."""


def list_tdms(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the channels of numbers in a TDMS file: by name, or group/name where a name stands in several groups.

    Raises
    ------
    FileError
        Unreadable or no TDMS file.
    """
    with opened_tdms(path) as file:
        return tuple(
            ChannelInfo(name, len(channel), _rate(channel), _unit(channel))
            for name, channel in _named(file, path).items()
        )


def read_tdms(path: Path, names: Sequence[str]) -> Signals:
    """Return channels of a TDMS file; group/name is understood for all.

    Raises
    ------
    FileError
        Unreadable, no TDMS file, cut off, a channel missing, channels of different rates.
    """
    with opened_tdms(path) as file:
        named = _named(file, path)
        known = {**named, **{f"{one.group_name}/{one.name}": one for one in named.values()}}
        chosen = [known[name] for name in resolved(path, names, list(known), list(named))]
        _want_whole(file, path, chosen)
        rates = {_rate(channel) for channel in chosen}
        if len(rates) > 1:
            rates_text = ", ".join("none" if rate is None else f"{rate:g} Hz" for rate in rates)
            raise FileError(f"{path}: its channels {listed(names)} have different sample rates: {rates_text}.")
        signals = tuple(_signal(name, channel) for name, channel in zip(names, chosen, strict=True))
        started_at = next(filter(None, map(_started, chosen)), "")
        return Signals(signals, sample_rate_hz=rates.pop() if rates else None, started_at=started_at)


class _BoundedFile(io.BufferedReader):
    """A file for parsers that believe sizes in headers: its `read` allocates what is left in it at most.

    Python makes room for all that is asked for before it reads; a damaged size of four gigabytes would fill memory.

    Parameters
    ----------
    path
        File to open.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path, "r"))
        self._size = path.stat().st_size

    def read(self, size: int | None = -1, /) -> bytes:
        """Return the next bytes, at most `size`; all that is left where it is negative or None."""
        left = max(self._size - self.tell(), 0)
        return super().read(left if size is None or size < 0 else min(size, left))


@contextmanager
def opened_tdms(path: Path) -> Iterator[Any]:
    """Open a TDMS file with the library, its samples unread; a FileError where it is none or damaged."""
    from nptdms import TdmsFile
    from nptdms.log import log_manager

    # Its notes on damaged bytes would go to the terminal; what matters of them is said by a FileError.
    log_manager.set_level(logging.CRITICAL)
    # An opened file and not its path: the library would believe an index file that lies beside it.
    with reading(path, WHAT), _BoundedFile(path) as stream:
        if stream.read(4) != b"TDSm":
            raise FileError(f"{path} is no TDMS file.")
        stream.seek(0)
        with TdmsFile.open(stream) as file:
            yield file


def _named(file: Any, path: Path) -> dict[str, Any]:
    every = [channel for group in file.groups() for channel in group.channels()]
    for channel in every:
        if not is_sound(channel.properties):
            raise FileError(f"{path}: the scaling of its channel {channel.name} is damaged.")
    channels = [channel for channel in every if len(channel) and np.dtype(channel.dtype).kind in "iuf"]
    names = [channel.name for channel in channels]
    return {
        channel.name if names.count(channel.name) == 1 else f"{channel.group_name}/{channel.name}": channel
        for channel in channels
    }


def _want_whole(file: Any, path: Path, channels: Sequence[Any]) -> None:
    status = file.file_status
    if status.incomplete_final_segment:
        for one in (status.channel_statuses or {}).values():
            if one.read_length < one.expected_length:
                raise worded(FileError, "cut_off", path=path, there=one.read_length, expected=one.expected_length)
    if (claimed := sum(map(len, channels))) > path.stat().st_size:
        raise FileError(f"{path} claims {claimed:.3g} samples, far more than it holds.", reasons=("it is damaged",))


def _signal(name: str, channel: Any) -> Signal:
    coefficients = code_polynomial(channel.properties)
    codes = _codes(channel)
    if codes is not None and coefficients is not None:
        # The library knows scalings better than we do: codes are kept only where both agree on the values.
        theirs = np.asarray(channel.read_data(length=_COMPARED), dtype=np.float64)
        ours = np.polynomial.polynomial.polyval(codes[:_COMPARED].astype(np.float64), coefficients)
        if np.allclose(theirs, ours, rtol=1e-9, atol=1e-12 * float(np.abs(theirs).max(initial=0.0))):
            return Signal(name, codes, coefficients, _unit(channel))
    values: FloatArray = np.ascontiguousarray(channel.read_data(), dtype=np.float64)
    return Signal(name, values, unit=_unit(channel))


def _codes(channel: Any) -> Any:
    raw = channel.read_data(scaled=False)
    if isinstance(raw, dict):
        raw = next(iter(raw.values())) if len(raw) == 1 else None
    if raw is None or np.asarray(raw).dtype.kind != "i" or np.asarray(raw).dtype.itemsize != 2:
        return None
    return np.ascontiguousarray(raw, dtype=np.int16)


def _rate(channel: Any) -> float | None:
    step_s = channel.properties.get("wf_increment")
    return rate_of_step(float(step_s)) if isinstance(step_s, int | float | np.number) else None


def _unit(channel: Any) -> str:
    unit = channel.properties.get("unit_string") or channel.properties.get("NI_UnitDescription") or ""
    text = str(unit).strip()[:32]
    return _VOLTS.get(text.lower(), text)


def _started(channel: Any) -> str:
    for key in ("wf_start_time", "NI_ExpStartTimeStamp"):
        start = channel.properties.get(key)
        # 1904 is the zero of LabVIEW's clock: no date was set.
        if isinstance(start, np.datetime64) and start >= np.datetime64("1970-01-02"):
            return f"{np.datetime_as_string(start, unit='us')}+00:00"
    return ""


def tdms_facts(path: Path) -> ExportFacts | None:
    """Return what the property `RadarGUI` of a TDMS file tells; None where it is no export of ours."""
    with opened_tdms(path) as file:
        return facts_of_text(file.properties.get(FACTS))


FACTS = "RadarGUI"
"""Property of the file that holds all facts as TOML."""


def write_tdms(run: RunStream, path: Path, report: Progress) -> None:
    """Write one group of the run's name with one channel each; LabVIEW and DIAdem show volts at their times.

    NI_Scale properties turn codes into volts, wf_increment and wf_start_time give the times. TDMS has no record of
    lost samples: they stand in the property `RadarGUI` of the file, as all facts do.
    """
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

    facts = run.facts
    group, names = facts.name, facts.digitisation.channel_names
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                RootObject({"name": facts.name, FACTS: facts.text()}),
                GroupObject(group, dict(facts.session)),
                *(ChannelObject(group, name, None, _properties(facts, place)) for place, name in enumerate(names)),
            ]
        )
        for piece in run.pieces(report):
            writer.write_segment(
                [ChannelObject(group, name, np.ascontiguousarray(row)) for name, row in zip(names, piece, strict=True)]
            )


def _properties(facts: ExportFacts, place: int) -> dict[str, Any]:
    known = facts.digitisation
    properties: dict[str, Any] = {
        "wf_increment": 1.0 / known.sample_rate_hz,
        "wf_start_offset": 0.0,
        "wf_samples": 1,
        "unit_string": known.unit,
    }
    if known.channel_skew_s is not None:
        properties["channel_skew_s"] = known.channel_skew_s
    if (start := facts.started_utc()) is not None:
        properties["wf_start_time"] = np.datetime64(start, "us")
    if known.scaling is not None:
        properties |= _scale(known.scaling[place])
    return properties


def _scale(coefficients: tuple[float, ...]) -> dict[str, Any]:
    terms: dict[str, Any]
    if len(coefficients) <= 2:
        offset, slope = (*coefficients, 0.0)[:2]
        kind, terms = _LINEAR, {"Slope": slope, "Y_Intercept": offset}
    else:
        kind, terms = _POLYNOMIAL, {"Coefficients_Size": np.uint32(len(coefficients))}
        terms |= {f"Coefficients[{order}]": value for order, value in enumerate(coefficients)}
    terms["Input_Source"] = np.uint32(_RAW)
    scale = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": kind}
    return scale | {f"NI_Scale[0]_{kind}_{key}": value for key, value in terms.items()}
