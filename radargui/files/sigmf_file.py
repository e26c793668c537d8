"""SigMF recordings: complex channel k becomes I(k+1), Q(k+1); real channels are pairs in their order."""

from __future__ import annotations

import json
import math
import tarfile
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
META_SUFFIX, DATA_SUFFIX, ARCHIVE_SUFFIX = ".sigmf-meta", ".sigmf-data", ".sigmf"
LARGEST_META = 50_000_000
"""Bytes of metadata that are read: a capture for each of 100 000 gaps fits. Chosen by hand."""
MOST_CHANNELS = 64
"""As many as a large board has; a damaged number of channels would make as many columns. Chosen by hand."""
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
    own = resolved(path, names, list(places), found.names)
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
    with reading(path, WHAT):
        handle = _opened(path)
        facts = handle.get_global_info()
        components = _components(handle, facts)
        captures = handle.get_captures()
        n_components = components.shape[1]
        names = iq_names(n_components // 2) if n_components % 2 == 0 else tuple(_numbered(n_components))
        return _Samples(names, components, _rate(facts), _started(captures), _gaps(captures))


def _opened(path: Path) -> Any:
    """Return the library's handle, checked against the checksum in the metadata where there is one."""
    import sigmf
    from sigmf.sigmffile import SigMFFile

    if path.suffix.lower() == ARCHIVE_SUFFIX:
        _want_plain_archive(path)
        return sigmf.fromarchive(str(path), autoscale=False)
    meta = path.with_suffix(META_SUFFIX)
    if not meta.is_file():
        raise FileError(f"{path}: its metadata {meta.name} are missing.")
    if meta.stat().st_size > LARGEST_META:
        raise FileError(f"{meta} is larger than metadata can be.")
    metadata = json.loads(meta.read_text(encoding="utf-8"))
    data = path.with_suffix(DATA_SUFFIX)
    named = metadata["global"].get("core:dataset")
    if named is not None:
        data = path.with_name(Path(str(named)).name)
    if not data.is_file():
        raise FileError(f"{path}: its samples {data.name} are missing.", remedy="Put that file beside it.")
    facts = metadata["global"]
    skipped = int(facts.get("core:trailing_bytes", 0))
    skipped += sum(int(capture.get("core:header_bytes", 0)) for capture in metadata["captures"])
    _count(facts, metadata.get("annotations", []), data.stat().st_size - skipped)
    return SigMFFile(metadata=metadata, data_file=str(data), autoscale=False)


def _want_plain_archive(path: Path) -> None:
    """Refuse an archive that is compressed, sparse, cut off, or whose metadata are larger than metadata can be.

    The library reads all metadata into memory and takes any compression, which can swell without end.

    Raises
    ------
    ValueError
        It is so.
    tarfile.TarError
        It is no archive, or compressed.
    """
    held = path.stat().st_size
    with tarfile.open(path, "r:") as archive:
        for member in archive:
            if member.issparse() or member.offset_data + member.size > held:
                raise ValueError(f"{member.name[:60]} in it claims more than the archive holds")
            if member.name.endswith(".sigmf-meta") and member.size > LARGEST_META:
                raise ValueError("its metadata are larger than metadata can be")


def _count(facts: dict[str, Any], annotations: list[dict[str, Any]], size: int) -> tuple[int, int]:
    """Return number of samples and of components of each; what the metadata tell must be what is there."""
    from sigmf.sigmffile import dtype_info

    n_channels = facts.get("core:num_channels", 1)
    if not isinstance(n_channels, int) or not 1 <= n_channels <= MOST_CHANNELS:
        raise ValueError(f"core:num_channels = {n_channels}: allowed 1 to {MOST_CHANNELS}")
    info = dtype_info(facts.get("core:datatype"))
    n_components = n_channels * (2 if info["is_complex"] else 1)
    count, rest = divmod(size, n_components * info["component_dtype"].itemsize)
    ends = [int(one["core:sample_start"]) + int(one.get("core:sample_count", 0)) for one in annotations]
    if rest or size < 0 or max(ends, default=0) > count:
        raise ValueError(f"its samples are {size} bytes, which is not what its metadata tell")
    return count, n_components


def _components(handle: Any, facts: dict[str, Any]) -> Any:
    from sigmf.sigmffile import dtype_info

    dtype = dtype_info(facts["core:datatype"])["component_dtype"]
    start, trailing = int(handle.data_offset), int(facts.get("core:trailing_bytes", 0))
    # Within an archive the samples are a part of the file.
    size = getattr(handle, "data_size_bytes", None)
    if size is None:
        held = (
            len(handle.data_buffer.getbuffer()) if handle.data_file is None else Path(handle.data_file).stat().st_size
        )
        size = held - start - trailing
    count, n_components = _count(facts, handle.get_annotations(), size)
    if handle.data_file is None:
        content = bytes(handle.data_buffer.getbuffer()[start : start + size])
        flat = np.frombuffer(content, dtype=dtype, count=count * n_components)
    else:
        flat = np.fromfile(handle.data_file, dtype=dtype, count=count * n_components, offset=start)
    return flat.reshape(count, n_components)


def _rate(facts: dict[str, Any]) -> float | None:
    rate = facts.get("core:sample_rate")
    if rate is None:
        return None
    if not isinstance(rate, int | float) or not math.isfinite(rate) or rate <= 0:
        raise ValueError(f"core:sample_rate = {rate!r} is not a rate")
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
