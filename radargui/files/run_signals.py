"""A run file as a list of channels, for maps that choose among them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from radargui.files.refusal import resolved
from radargui.files.run_file import read_run
from radargui.files.signals import ChannelInfo, Signal, Signals
from radargui.model.errors import FileError


def list_run(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the channels of a run file.

    Raises
    ------
    FileError
        Unreadable or no run file.
    """
    recording = read_run(path)
    known = recording.digitisation
    return tuple(
        ChannelInfo(name, recording.n_samples, known.sample_rate_hz, known.unit) for name in known.channel_names
    )


def read_run_signals(path: Path, names: Sequence[str]) -> Signals:
    """Return channels of a run file by name.

    Raises
    ------
    FileError
        Unreadable, no run file, or a channel missing.
    """
    recording = read_run(path)
    known = recording.digitisation
    signals, rows = [], []
    for name in resolved(path, names, known.channel_names):
        row = known.channel_names.index(name)
        scaling = None if known.scaling is None else known.scaling[row]
        rows.append(row)
        signals.append(Signal(name, recording.raw[row], scaling, known.unit))
    return Signals(
        tuple(signals),
        sample_rate_hz=known.sample_rate_hz,
        gaps=recording.gaps,
        channel_skew_s=skew_of_rows(known.channel_skew_s, rows, path),
        started_at=recording.started_at,
        device=known.device,
        trigger_index=recording.trigger_index,
    )


def skew_of_rows(skew_s: float | None, rows: Sequence[int], path: Path) -> float | None:
    """Return the delay of each chosen channel against the one chosen before; None where it cannot be known.

    Raises
    ------
    FileError
        They do not follow one another in steps of the same length.
    """
    steps = {later - earlier for earlier, later in pairwise(rows)}
    if not skew_s:
        return skew_s
    if not steps:
        return None
    if len(steps) > 1 or min(steps) < 1:
        raise FileError(f"{path}: its channels were sampled one after another and cannot be put in this order.")
    return skew_s * steps.pop()
