"""Read and write SigMF files.

Complex channel k becomes I(k+1), Q(k+1); real channels are pairs in their order.
"""

import hashlib
import json
import math
import re
import tarfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from radargui import __version__
from radargui.files.access import Progress, reading, resolved
from radargui.files.run_file import ExportFacts, RunStream, facts_of_table
from radargui.files.signals import MAX_CHANNELS, ChannelInfo, Signal, Signals, scaled_signal
from radargui.model.errors import FileError
from radargui.model.recording import Gap, iq_names, stored_starts

WHAT = "a SigMF recording"
SIGMF_SUFFIXES: tuple[str, ...] = (".sigmf-meta", ".sigmf-data", ".sigmf")
META_SUFFIX, DATA_SUFFIX, ARCHIVE_SUFFIX = SIGMF_SUFFIXES
LARGEST_META = 50_000_000
"""Bytes of metadata that are read: a capture for each of 100 000 gaps fits. Chosen by hand."""
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
    # SigMF: unsigned codes have their zero in the middle of the range
    scale, offset = 1.0 if kind == "f" else 2.0 ** (1 - 8 * size), -1.0 if kind == "u" else 0.0
    return scaled_signal(name, component, scale, offset, FULL_SCALE)


def _load(path: Path) -> _Samples:
    from sigmf.sigmffile import dtype_info

    with reading(path, WHAT):
        metadata, data, first, size = _document(path)
        facts, captures = metadata["global"], metadata["captures"]
        if not data.is_file():
            raise FileError(f"{path}: its samples {data.name} are missing.", remedy="Put that file beside it.")
        stored = np.fromfile(data, dtype=np.uint8, count=size, offset=first)
        wanted = facts.get("core:sha512")
        if wanted is not None and hashlib.sha512(stored.data).hexdigest() != wanted:
            raise ValueError("its hash does not match the one in its metadata")
        header, *between = (int(capture.get("core:header_bytes", 0)) for capture in captures or [{}])
        trailing = int(facts.get("core:trailing_bytes", 0))
        if min(header, trailing) < 0 or any(between):
            raise ValueError("bytes between its samples are not read")
        n_channels, info = facts.get("core:num_channels", 1), dtype_info(facts.get("core:datatype"))
        if not isinstance(n_channels, int) or not 1 <= n_channels <= MAX_CHANNELS:
            raise ValueError(f"core:num_channels = {n_channels}: allowed 1 to {MAX_CHANNELS}")
        n_components = n_channels * (2 if info["is_complex"] else 1)
        size -= header + trailing
        count, rest = divmod(size, n_components * info["component_dtype"].itemsize)
        marks = metadata.get("annotations", [])
        ends = [int(mark["core:sample_start"]) + int(mark.get("core:sample_count", 0)) for mark in marks]
        if rest or size < 0 or max(ends, default=0) > count:
            raise ValueError(f"its samples are {size} bytes, which is not what its metadata say")
        components = stored[header : header + size].view(info["component_dtype"]).reshape(count, n_components)
        names = iq_names(n_components // 2) if n_components % 2 == 0 else tuple(_numbered(n_components))
        return _Samples(names, components, _rate(facts), _started(captures), _gaps(captures))


def _document(path: Path) -> tuple[dict[str, Any], Path, int, int]:
    """Return the metadata, and where the stored bytes are: file, first byte, how many (0 where there is no file)."""
    if path.suffix.lower() == ARCHIVE_SUFFIX:
        return _archived(path)
    meta, data = path.with_suffix(META_SUFFIX), path.with_suffix(DATA_SUFFIX)
    if not meta.is_file():
        raise FileError(f"{path}: its metadata {meta.name} are missing.")
    if meta.stat().st_size > LARGEST_META:
        raise FileError(f"{meta} is larger than metadata can be.")
    metadata = json.loads(meta.read_text(encoding="utf-8"))
    if (named := metadata["global"].get("core:dataset")) is not None:
        # of this folder only: metadata from elsewhere shall not decide which file of this computer is read
        data = path.with_name(Path(str(named)).name)
    return metadata, data, 0, data.stat().st_size if data.is_file() else 0


def _archived(path: Path) -> tuple[dict[str, Any], Path, int, int]:
    """Return the same of an archive, whose members lie in it as they are.

    Raises
    ------
    ValueError
        It is sparse or cut off, its metadata are larger than metadata can be, or a member is missing.
    tarfile.TarError
        It is no archive, or compressed.
    """
    held = path.stat().st_size
    # "r:": not compressed, as the format wants it; nothing can swell
    with tarfile.open(path, "r:") as archive:
        members = list(archive)
    for member in members:
        if member.issparse() or member.offset_data + member.size > held:
            raise ValueError(f"{member.name[:60]} in it claims more than the archive holds")
    meta = _member(members, META_SUFFIX)
    if meta.size > LARGEST_META:
        raise ValueError("its metadata are larger than metadata can be")
    metadata = json.loads(np.fromfile(path, dtype=np.uint8, count=meta.size, offset=meta.offset_data).tobytes())
    data = _member(members, Path(str(metadata["global"].get("core:dataset", DATA_SUFFIX))).name)
    return metadata, path, data.offset_data, data.size


def _member(members: Sequence[tarfile.TarInfo], ending: str) -> tarfile.TarInfo:
    found = next((member for member in members if member.isfile() and member.name.endswith(ending)), None)
    if found is None:
        raise ValueError(f"no {ending[:60]} is in it")
    return found


def _rate(facts: dict[str, Any]) -> float | None:
    rate = facts.get("core:sample_rate")
    if rate is not None and (not isinstance(rate, int | float) or not math.isfinite(rate) or rate <= 0):
        raise ValueError(f"core:sample_rate = {rate!r} is not a rate")
    return None if rate is None else float(rate)


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
            # counted from the first sample of this file, whatever place it had in the stream it was cut from
            gaps.append(Gap(next_index - lost - placed[0][1] + placed[0][0], lost, "told by the SigMF captures"))
    return tuple(gaps)


def sigmf_facts(path: Path) -> ExportFacts | None:
    """Return what `radargui:facts` of a SigMF recording tells; None where it is no export of ours."""
    with reading(path, WHAT):
        return facts_of_table(_document(path)[0]["global"].get(FACTS))


def sigmf_program(path: Path) -> str:
    """Return the program that a SigMF recording says wrote it; empty where it does not say."""
    with reading(path, WHAT):
        recorder = _document(path)[0]["global"].get("core:recorder")
    return recorder[:80] if isinstance(recorder, str) else ""


NAMESPACE = "radargui"
FACTS = f"{NAMESPACE}:facts"
"""Global field that holds all facts."""
EXTENSION_VERSION = "1.0.0"
_PAIRED = re.compile(r"[IQ]\d+")


def write_sigmf(run: RunStream, meta: Path, data: Path, report: Progress) -> None:
    """Write the pair of files of a SigMF recording.

    Codes are stored untouched (`ci16_le`), values as `cf64_le`; where the channels are no I and Q, real samples are
    stored. SigMF knows no volts: `radargui:facts` holds the scaling, the unit, the skew and all else.
    """
    from sigmf import __specification__

    facts = run.facts
    names = facts.digitisation.channel_names
    is_paired = len(names) % 2 == 0 and all(_PAIRED.fullmatch(name) for name in names)
    kind, dtype = ("f64", "<f8") if facts.digitisation.scaling is None else ("i16", "<i2")
    digest = hashlib.sha512()
    with data.open("wb") as file:
        for piece in run.pieces(report):
            content = np.ascontiguousarray(piece.T, dtype=dtype).tobytes()
            digest.update(content)
            file.write(content)
    metadata = {
        "global": {
            "core:datatype": f"{'c' if is_paired else 'r'}{kind}_le",
            "core:num_channels": len(names) // 2 if is_paired else len(names),
            "core:sample_rate": facts.digitisation.sample_rate_hz,
            "core:version": __specification__,
            "core:recorder": f"RadarGUI {__version__}",
            "core:sha512": digest.hexdigest(),
            **_texts(facts),
            "core:extensions": [{"name": NAMESPACE, "version": EXTENSION_VERSION, "optional": True}],
            FACTS: facts.table(),
        },
        "captures": _captures(facts),
        "annotations": _annotations(facts),
    }
    meta.write_text(json.dumps(metadata, indent=2, ensure_ascii=False) + "\n", encoding="utf-8", newline="\n")


def _texts(facts: ExportFacts) -> dict[str, str]:
    texts = {
        "core:description": f"RadarGUI run {facts.name}",
        "core:hw": facts.digitisation.device,
        "core:author": facts.session.get("operator", ""),
    }
    return {key: text for key, text in texts.items() if text}


def _captures(facts: ExportFacts) -> list[dict[str, Any]]:
    captures: list[dict[str, Any]] = [
        {"core:sample_start": stored, "core:global_index": absolute}
        for stored, absolute in stored_starts(facts.gaps, facts.n_samples)
    ]
    if (start := facts.started_utc()) is not None:
        captures[0]["core:datetime"] = start.isoformat(timespec="microseconds") + "Z"
    return captures


def _annotations(facts: ExportFacts) -> list[dict[str, Any]]:
    marks = [(marker.index, marker.text) for marker in facts.markers]
    if facts.trigger_index is not None:
        marks.append((facts.trigger_index, "trigger"))
    starts = stored_starts(facts.gaps, facts.n_samples)
    ends = [first for first, _ in starts[1:]] + [facts.n_samples]
    stretches = list(zip(starts, ends, strict=True))
    found = []
    for index, text in sorted(marks):
        # what lies among lost samples stands at the first one after them
        at = (min(index - absolute + first, end) for (first, absolute), end in reversed(stretches) if index >= absolute)
        stored = next(at, 0)
        if 0 <= stored < facts.n_samples:
            found.append({"core:sample_start": stored, "core:sample_count": 1, "core:comment": text})
    return found
