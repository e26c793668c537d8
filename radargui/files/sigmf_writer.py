"""Export to SigMF: complex samples, one channel a receiver, with the lost samples in the captures."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import numpy as np

from radargui import __version__
from radargui.files.export_facts import ExportFacts
from radargui.files.lost_samples import stored_starts
from radargui.files.progress import Progress
from radargui.files.run_stream import RunStream

NAMESPACE = "radargui"
FACTS = f"{NAMESPACE}:facts"
"""Global field that holds all facts."""
EXTENSION_VERSION = "1.0.0"
_PAIRED = re.compile(r"[IQ]\d+")


def write_sigmf(run: RunStream, meta: Path, data: Path, tell: Progress) -> None:
    """Write the pair of files of a SigMF recording.

    Codes are stored untouched (`ci16_le`), values as `cf64_le`; where the channels are no I and Q, real samples are
    stored. SigMF knows no volts: `radargui:facts` holds the scaling, the unit, the skew and all else.
    """
    facts = run.facts
    names = facts.digitisation.channel_names
    is_paired = len(names) % 2 == 0 and all(_PAIRED.fullmatch(name) for name in names)
    is_code = facts.digitisation.scaling is not None
    kind, dtype = ("i16", "<i2") if is_code else ("f64", "<f8")
    digest = hashlib.sha512()
    with data.open("wb") as file:
        for piece in run.pieces(tell):
            content = np.ascontiguousarray(piece.T, dtype=dtype).tobytes()
            digest.update(content)
            file.write(content)
    metadata = {
        "global": {
            "core:datatype": f"{'c' if is_paired else 'r'}{kind}_le",
            "core:num_channels": len(names) // 2 if is_paired else len(names),
            "core:sample_rate": facts.digitisation.sample_rate_hz,
            "core:version": _specification(),
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


def _specification() -> str:
    from sigmf import __specification__

    return str(__specification__)


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
    lost = stored_starts(facts.gaps, facts.n_samples)
    found = []
    for index, text in sorted(marks):
        stored = next((index - absolute + first for first, absolute in reversed(lost) if index >= absolute), 0)
        if 0 <= stored < facts.n_samples:
            found.append({"core:sample_start": stored, "core:sample_count": 1, "core:comment": text})
    return found
