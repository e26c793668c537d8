"""The card of a run: what lists and searches need of it, read in one go."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.run_file import markers_in
from radargui.files.run_header import is_run
from radargui.files.run_health import health_in
from radargui.files.summary import summary_in
from radargui.model.drop import RunOrigin


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
    origin
        Where the samples come from.
    """

    started_at: str = ""
    finished: bool = True
    recovered_at: str = ""
    n_samples: int = 0
    sample_rate_hz: float = 0.0
    summary: dict[str, object] = field(default_factory=dict)
    markers: tuple[str, ...] = ()
    origin: RunOrigin = field(default_factory=RunOrigin)


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
        is_processed = layout.RESULTS in file and hdf5.is_sound(file[layout.RESULTS].attrs)
        return RunCard(
            started_at=hdf5.text(raw.attrs, "started_at"),
            finished=finished,
            recovered_at=hdf5.text(file.attrs, "recovered_at"),
            n_samples=int(raw.shape[1]),
            sample_rate_hz=hdf5.number(raw.attrs, "sample_rate_hz") or 0.0,
            summary=summary_in(file[layout.RESULTS]) if is_processed else {},
            markers=tuple(marker.text for marker in markers_in(file, path)),
            origin=_origin(file),
        )


def origin_attributes(source: str, file: Path | None) -> dict[str, str]:
    """Return what a run file says of its source, see `RunOrigin`; `file`: what is replayed."""
    return {"source": source, **({"replay_of": str(file.resolve())} if file is not None else {})}


def read_run_origin(path: Path) -> RunOrigin:
    """Return where the samples of a run come from.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        return _origin(file)


def _origin(file: Any) -> RunOrigin:
    attributes = file.attrs
    crcs = np.ravel(attributes["crc32"]).tolist() if "crc32" in attributes else []
    samples = ":".join(map(str, [int(hdf5.number(attributes, "n_samples") or 0), *crcs])) if crcs else ""
    if hdf5.text(attributes, "source") == "replay":
        first = (health_in(file) or {}).get("first_sample")
        return RunOrigin(
            "replay", samples, hdf5.text(attributes, "replay_of"), first if isinstance(first, int) else None
        )
    # 0.1 said so only of the device, and an imported simulation says no more
    simulated = hdf5.text(attributes, "device").startswith("simulated") or layout.TRUTH in file
    return RunOrigin("simulated" if simulated else "measured", samples)


def read_origin(path: Path) -> str:
    """Return where an imported run comes from, file, format and program, for people; empty for a recorded one.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        name, kind, program, layout_text = (
            hdf5.text(file.attrs, f"imported_{key}") for key in ("from", "format", "program", "layout")
        )
    if not name:
        return ""
    kind = f"{kind}: {layout_text}" if layout_text else kind
    return f"{name} ({kind})" + (f", written by {program}" if program else "")
