"""The card of a run: what lists and searches need of it, read in one go."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.run_header import is_run
from radargui.files.seal import is_sound


@dataclass(frozen=True, slots=True)
class RunCard:
    """What a run file says about itself, without its samples.

    Attributes
    ----------
    started_at
        ISO 8601; empty where unknown.
    finished
        False after a crash, a failure, or while it is being recorded.
    recovered_at
        ISO 8601 date and time at which it was finished after a crash; empty for others.
    n_samples, sample_rate_hz
        Of each channel.
    summary
        See `files.summary.summarise`; empty where not processed.
    markers
        The operator's notes.
    """

    started_at: str = ""
    finished: bool = True
    recovered_at: str = ""
    n_samples: int = 0
    sample_rate_hz: float = 0.0
    summary: dict[str, object] = field(default_factory=dict)
    markers: tuple[str, ...] = ()


def read_run_card(path: Path) -> RunCard:
    """Return the card of a run.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        raw = hdf5.dataset(file, layout.RAW, path, (2,))
        finished = hdf5.number(file.attrs, "complete") != 0.0
        # the header's own checksum is left to those who read samples: it would double the time
        summary: object = {}
        if layout.RESULTS in file and is_sound(file[layout.RESULTS].attrs):
            summary = json.loads(hdf5.text(file[layout.RESULTS].attrs, "summary") or "{}")
        markers: tuple[str, ...] = ()
        if layout.MARKERS in file and file[layout.MARKERS].shape[0]:
            rows = hdf5.dataset(file, layout.MARKERS, path, (1,))[:]
            markers = tuple(bytes(row["text"]).decode("utf-8", "replace") for row in rows)
        return RunCard(
            started_at=hdf5.text(raw.attrs, "started_at"),
            finished=finished,
            recovered_at=hdf5.text(file.attrs, "recovered_at"),
            n_samples=int(raw.shape[1]),
            sample_rate_hz=hdf5.number(raw.attrs, "sample_rate_hz") or 0.0,
            summary=summary if isinstance(summary, dict) else {},
            markers=markers,
        )
