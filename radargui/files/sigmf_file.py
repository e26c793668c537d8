"""SigMF recordings: complex channel k becomes I(k+1), Q(k+1); real channels are pairs in their order."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files.refusal import reading, resolved
from radargui.files.signals import ChannelInfo, Signal, Signals
from radargui.model.block import Gap
from radargui.model.digitisation import iq_names
from radargui.model.errors import FileError

WHAT = "a SigMF recording"
MOST_CHANNELS = 64
FULL_SCALE = "full scale"
"""SigMF knows no volts: fixed-point codes are parts of full scale."""


@dataclass(frozen=True, slots=True)
class _Samples:
    """Components as stored, shape (n_samples, n_components), and what the metadata say of them."""

    names: tuple[str, ...]
    components: Any
    sample_rate_hz: float | None
    started_at: str
    gaps: tuple[Gap, ...]


def list_sigmf(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the channels of a SigMF recording (its metadata, its data file or its archive).

    Raises
    ------
    FileError
        Unreadable, damaged, or no SigMF recording.
    """
    found = _load(path)
    count = int(found.components.shape[0])
    return tuple(ChannelInfo(name, count, found.sample_rate_hz, FULL_SCALE) for name in found.names)


def read_sigmf(path: Path, names: Sequence[str]) -> Signals:
    """Return channels of a SigMF recording; ch1, ch2, ... name its components in stored order, too.

    Raises
    ------
    FileError
        Unreadable, damaged, no SigMF recording, or a channel missing.
    """
    found = _load(path)
    places = {**{name: place for place, name in enumerate(found.names)}, **_numbered(len(found.names))}
    own = resolved(path, names, list(places))
    return Signals(
        tuple(_signal(name, found.components[:, places[name]]) for name in own),
        sample_rate_hz=found.sample_rate_hz,
        gaps=found.gaps,
        started_at=found.started_at,
    )


def _numbered(count: int) -> dict[str, int]:
    return {f"ch{place + 1}": place for place in range(count)}


def _signal(name: str, component: Any) -> Signal:
    kind, size = component.dtype.kind, component.dtype.itemsize
    if kind == "f":
        return Signal(name, np.ascontiguousarray(component, dtype=np.float64), unit=FULL_SCALE)
    half = 2.0 ** (8 * size - 1)
    if kind == "i" and size <= 2:
        return Signal(name, np.ascontiguousarray(component, dtype=np.int16), (0.0, 1.0 / half), FULL_SCALE)
    # SigMF: unsigned codes have their zero in the middle of the range
    zero = half if kind == "u" else 0.0
    values = (np.ascontiguousarray(component, dtype=np.float64) - zero) / half
    return Signal(name, values, unit=FULL_SCALE)


def _load(path: Path) -> _Samples:
    import sigmf
    from sigmf.sigmffile import SigMFFile, dtype_info

    with reading(path, WHAT), warnings.catch_warnings():
        # The library warns of data that do not fit their metadata; here that is a refusal.
        warnings.simplefilter("error", UserWarning)
        handle = sigmf.fromfile(str(path), autoscale=False)
        if not isinstance(handle, SigMFFile):
            raise FileError(f"{path} is a collection; give one of its recordings.")
        if handle.data_file is None and handle.data_buffer is None:
            raise FileError(f"{path}: its data file is missing.", remedy="Put the .sigmf-data file beside it.")
        facts = handle.get_global_info()
        info = dtype_info(facts.get("core:datatype"))
        n_components = _n_channels(facts, path) * (2 if info["is_complex"] else 1)
        components = _components(handle, info["component_dtype"], n_components)
        captures = handle.get_captures()
        names = iq_names(n_components // 2) if n_components % 2 == 0 else tuple(_numbered(n_components))
        return _Samples(names, components, _rate(facts, path), _started(captures), _gaps(captures))


def _n_channels(facts: dict[str, Any], path: Path) -> int:
    count = facts.get("core:num_channels", 1)
    if not isinstance(count, int) or not 1 <= count <= MOST_CHANNELS:
        raise FileError(f"{path}: core:num_channels = {count}: allowed 1 to {MOST_CHANNELS}.")
    return count


def _components(handle: Any, dtype: Any, n_components: int) -> Any:
    size = handle.sample_count * n_components * dtype.itemsize
    if handle.data_file is not None:
        count = size // dtype.itemsize
        flat = np.fromfile(handle.data_file, dtype=dtype, count=count, offset=int(handle.data_offset))
    else:
        start = int(handle.data_offset)
        flat = np.frombuffer(bytes(handle.data_buffer.getbuffer()[start : start + size]), dtype=dtype)
    return flat.reshape(-1, n_components)


def _rate(facts: dict[str, Any], path: Path) -> float | None:
    rate = facts.get("core:sample_rate")
    if rate is None:
        return None
    if not isinstance(rate, int | float) or not math.isfinite(rate) or rate <= 0:
        raise FileError(f"{path}: core:sample_rate = {rate!r} is not a rate.")
    return float(rate)


def _started(captures: list[dict[str, Any]]) -> str:
    text = captures[0].get("core:datetime") if captures else None
    return text[:40].replace("Z", "+00:00") if isinstance(text, str) else ""


def _gaps(captures: list[dict[str, Any]]) -> tuple[Gap, ...]:
    """Return the samples that `core:global_index` of the captures says were lost."""
    gaps = []
    placed = [
        (capture["core:sample_start"], capture["core:global_index"])
        for capture in captures
        if isinstance(capture.get("core:global_index"), int) and isinstance(capture.get("core:sample_start"), int)
    ]
    for (start, index), (next_start, next_index) in pairwise(placed):
        lost = (next_index - index) - (next_start - start)
        if lost > 0:
            gaps.append(Gap(next_index - lost - placed[0][1] + placed[0][0], lost, "told by the SigMF captures"))
    return tuple(gaps)
