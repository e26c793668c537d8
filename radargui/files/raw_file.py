"""Read plain binary files: interleaved numbers behind a header, in the layout that the user states."""

import logging
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, ValidationError

from radargui.files.access import reading, resolved
from radargui.files.signals import MAX_CHANNELS, ChannelInfo, Signals, scaled_signal
from radargui.model.arrays import FloatArray
from radargui.model.errors import FileError, UsageError, worded
from radargui.model.section import Section
from radargui.model.setup_error import describe

WHAT = "plain binary"
LARGEST_BYTES = 2**40
"""For header and skip: no file is that long, and what is computed with it stays exact."""
TYPES = ("i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8")
EXAMPLE = "--raw dtype=u2le,channels=5,header=8,rate=31250,scale=8.06e-4,offset=0,skip=300"
_DTYPE = re.compile(rf"({'|'.join(TYPES)})(le|be)?")
_log = logging.getLogger(__name__)


def _stored(dtype: str) -> str:
    """Return a type of number with its order of bytes, in small letters."""
    if not (match := _DTYPE.fullmatch(dtype.lower())):
        raise ValueError(f"allowed: {', '.join(TYPES)}, with le or be behind it for the order of bytes (left out: le)")
    return match[1] + (match[2] or "le")


def _not_zero(scale_v: float) -> float:
    if scale_v == 0.0:
        raise ValueError("allowed: volts of one step, a number other than 0")
    return scale_v


_Rate = Annotated[float, Field(gt=0.0, description="samples per second of each channel, a number above 0")]
_Scale = Annotated[float, AfterValidator(_not_zero), Field(description="volts of one step, a number other than 0")]


class RawLayout(Section):
    """How the samples of a plain binary file lie in it; its keys are those of `--raw`, whose values are texts.

    Attributes
    ----------
    dtype
        Of one number: i1, u1, i2, u2, i4, u4, f4 or f8 (signed, unsigned, floating; bytes), then le or be.
    channels
        Numbers of one sample, one after another.
    header_bytes
        Bytes before the first sample.
    rate_hz
        Samples per second of each channel; None: not stated.
    scale_v, offset_v
        volts = offset + scale x number; a scale of None: the numbers are taken as they are.
    skip
        Samples of each channel left out at the beginning.
    """

    dtype: Annotated[str, AfterValidator(_stored)]
    channels: Annotated[int, Field(ge=1, le=MAX_CHANNELS)]
    header_bytes: Annotated[int, Field(alias="header", ge=0, le=LARGEST_BYTES)] = 0
    rate_hz: Annotated[_Rate | None, Field(alias="rate")] = None
    scale_v: Annotated[_Scale | None, Field(alias="scale")] = None
    offset_v: Annotated[float, Field(alias="offset", description="volts of the number 0, a number")] = 0.0
    skip: Annotated[int, Field(ge=0, le=LARGEST_BYTES)] = 0

    @property
    def numpy_dtype(self) -> np.dtype[Any]:
        """The type of one number with its order of bytes."""
        return np.dtype((">" if self.dtype.endswith("be") else "<") + self.dtype[:2])

    @property
    def text(self) -> str:
        """The layout as `--raw` takes it."""
        return ",".join(
            f"{key}={value}" for key, value in self.model_dump(by_alias=True, exclude_defaults=True).items()
        )


def parse_raw_layout(text: str) -> RawLayout:
    """Return the layout that the value of `--raw` tells.

    Raises
    ------
    UsageError
        A key is unknown, twice there or missing, or a value is not allowed.
    """
    given: dict[str, str] = {}
    for part in text.split(","):
        key, sign, value = (piece.strip() for piece in part.partition("="))
        if not sign or key in given:
            wrong = f"--raw: {key} stands there twice" if sign else f"--raw: {part.strip()!r}, allowed: key=value"
            raise UsageError(wrong, remedy=f"For example {EXAMPLE}.")
        given[key] = value
    try:
        return RawLayout.model_validate(given)
    except ValidationError as error:
        raise UsageError(f"--raw: {describe(error, RawLayout)}", remedy=f"For example {EXAMPLE}.") from None


def list_raw(path: Path, layout: RawLayout) -> tuple[ChannelInfo, ...]:
    """Return the columns of a plain binary file: 0, 1, 2, ...

    Raises
    ------
    FileError
        Unreadable, or no sample lies behind the header and what is skipped.
    """
    with reading(path, WHAT):
        count = _count(path, layout)
    return tuple(ChannelInfo(str(place), count, layout.rate_hz, _unit(layout)) for place in range(layout.channels))


def read_raw(path: Path, names: Sequence[str], layout: RawLayout) -> Signals:
    """Return columns of a plain binary file by number, counted from 0.

    Numbers of 8 and 16 bits stay codes, unsigned ones of 16 bits with 32768 taken off, which the scaling gives back;
    wider ones become values.

    Raises
    ------
    FileError
        Unreadable, too short, or a column missing.
    """
    with reading(path, WHAT):
        count = _count(path, layout)
        own = resolved(path, names, [str(place) for place in range(layout.channels)])
        table = _table(path, layout, count)
        scale = 1.0 if layout.scale_v is None else layout.scale_v
        signals = tuple(scaled_signal(name, table[:, int(name)], scale, layout.offset_v, _unit(layout)) for name in own)
    return Signals(signals, sample_rate_hz=layout.rate_hz)


def first_seconds(path: Path, layout: RawLayout, seconds: float, most: int) -> FloatArray:
    """Return the beginning of a file in volts, shape (channels, n), to look at.

    Parameters
    ----------
    path, layout
        The file and how it is laid out.
    seconds
        How long; where the layout tells no rate `most` samples.
    most
        Samples of each channel at most.

    Raises
    ------
    FileError
        Unreadable or too short.
    """
    with reading(path, WHAT):
        count = min(_count(path, layout), most)
        if layout.rate_hz is not None:
            count = min(count, max(math.ceil(seconds * layout.rate_hz), 2))
        table = _table(path, layout, count)
        with np.errstate(over="ignore", invalid="ignore"):
            return np.ascontiguousarray(table.T, dtype=np.float64) * (layout.scale_v or 1.0) + layout.offset_v


def _count(path: Path, layout: RawLayout) -> int:
    """Return the samples of each channel behind header and skip."""
    frame = layout.channels * layout.numpy_dtype.itemsize
    size = path.stat().st_size
    whole, rest = divmod(size - layout.header_bytes, frame)
    if whole - layout.skip < 1:
        skipped = {"header": layout.header_bytes, "skip": layout.skip}
        raise worded(FileError, "nothing_left", path=path, size=size, frame=frame, **skipped)
    if rest:
        _log.warning(
            "%s: %d bytes at its end are no whole sample of %d bytes and are left out; it was cut off, or header, "
            "channels or dtype are others.",
            path,
            rest,
            frame,
        )
    return whole - layout.skip


def _table(path: Path, layout: RawLayout, count: int) -> Any:
    """Return numbers as stored, shape (count, channels), mapped and not read: often two of many columns are wanted."""
    dtype = layout.numpy_dtype
    start = layout.header_bytes + layout.skip * layout.channels * dtype.itemsize
    return np.memmap(path, dtype=dtype, mode="r", offset=start, shape=(count, layout.channels))


def _unit(layout: RawLayout) -> str:
    return "V" if layout.scale_v is not None or layout.numpy_dtype.kind == "f" else "code"
