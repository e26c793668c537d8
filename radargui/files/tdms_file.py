"""NI TDMS files through npTDMS; int16 codes with a polynomial scaling stay codes."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files.refusal import listed, reading, resolved
from radargui.files.signals import ChannelInfo, Signal, Signals
from radargui.files.tdms_scaling import code_polynomial, is_sound
from radargui.files.time_axis import rate_of_step
from radargui.model.arrays import FloatArray
from radargui.model.errors import FileError

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
            told = ", ".join("none" if rate is None else f"{rate:g} Hz" for rate in rates)
            raise FileError(f"{path}: its channels {listed(names)} have different sample rates: {told}.")
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
        magic = stream.read(4)
        if magic != b"TDSm":
            raise FileError(f"{path} is no TDMS file.")
        stream.seek(0)
        with TdmsFile.open(stream) as file:
            yield file


def _named(file: Any, path: Path) -> dict[str, Any]:
    every = [channel for group in file.groups() for channel in group.channels()]
    for channel in every:
        if not is_sound(channel.properties):
            raise FileError(f"{path}: the scaling of its channel {channel.name} is damaged.")
    channels = [channel for channel in every if _is_numbers(channel)]
    names = [channel.name for channel in channels]
    return {
        channel.name if names.count(channel.name) == 1 else f"{channel.group_name}/{channel.name}": channel
        for channel in channels
    }


def _is_numbers(channel: Any) -> bool:
    return len(channel) > 0 and np.dtype(channel.dtype).kind in "iuf"


def _want_whole(file: Any, path: Path, channels: Sequence[Any]) -> None:
    status = file.file_status
    if status.incomplete_final_segment:
        for one in (status.channel_statuses or {}).values():
            if one.read_length < one.expected_length:
                raise FileError(
                    f"{path} is cut off: {one.read_length} of {one.expected_length} samples are there.",
                    reasons=("it was not copied whole", "the program that wrote it crashed"),
                )
    claimed = sum(len(channel) for channel in channels)
    held = path.stat().st_size
    if claimed > held:
        raise FileError(f"{path} claims {claimed:.3g} samples, far more than it holds.", reasons=("it is damaged",))


def _signal(name: str, channel: Any) -> Signal:
    coefficients = code_polynomial(channel.properties)
    codes = _codes(channel)
    if codes is not None and coefficients is not None:
        # The library knows scalings better than we do: codes are kept only where both agree on the values.
        told = np.asarray(channel.read_data(length=_COMPARED), dtype=np.float64)
        ours = np.polynomial.polynomial.polyval(codes[:_COMPARED].astype(np.float64), coefficients)
        if np.allclose(told, ours, rtol=1e-9, atol=1e-12 * float(np.abs(told).max(initial=0.0))):
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
