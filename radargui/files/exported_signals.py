"""Signals of a file that we exported, with everything that the format itself cannot say."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from radargui.files.export_facts import ExportFacts
from radargui.files.run_signals import skew_of_rows
from radargui.files.signals import Signal, Signals
from radargui.model.arrays import RawArray
from radargui.model.digitisation import Digitisation

_NUMBERED = re.compile(r"ch([0-9]{1,4})")
Read = Callable[[Path, Sequence[str]], Signals]
FindFacts = Callable[[Path], ExportFacts | None]
FindCodes = Callable[[Path, ExportFacts], RawArray | None]


def with_own_facts(read: Read, find_facts: FindFacts, find_codes: FindCodes | None = None) -> Read:
    """Return a reader that knows scaling, unit, skew, gaps, trigger and date of files that were exported by RadarGUI.

    Where the samples in the file are no longer those that were exported (another number of them, other names), the
    file is taken for what it says itself.

    Parameters
    ----------
    read
        Reads any file of the format.
    find_facts
        Gives the facts in a file, None in a foreign one.
    find_codes
        Gives the codes where the format keeps them beside the values.
    """

    def read_with_facts(path: Path, names: Sequence[str]) -> Signals:
        signals = read(path, names)
        facts = find_facts(path)
        if facts is None or any(signal.samples.size != facts.n_samples for signal in signals.signals):
            return signals
        rows = [_row(signal.name, facts.digitisation) for signal in signals.signals]
        if None in rows:
            return signals
        known = [row for row in rows if row is not None]
        codes = find_codes(path, facts) if find_codes and facts.digitisation.scaling else None
        return Signals(
            tuple(_signal(signal, row, facts, codes) for signal, row in zip(signals.signals, known, strict=True)),
            sample_rate_hz=facts.digitisation.sample_rate_hz,
            gaps=facts.gaps,
            channel_skew_s=skew_of_rows(facts.digitisation.channel_skew_s, known, path),
            started_at=facts.started_at,
            device=facts.digitisation.device,
            trigger_index=facts.trigger_index,
        )

    return read_with_facts


def _row(name: str, known: Digitisation) -> int | None:
    last = name.rpartition("/")[2]
    if last in known.channel_names:
        return known.channel_names.index(last)
    match = _NUMBERED.fullmatch(last)
    place = int(match[1]) - 1 if match else -1
    return place if 0 <= place < known.n_channels else None


def _signal(signal: Signal, row: int, facts: ExportFacts, codes: RawArray | None) -> Signal:
    known = facts.digitisation
    scaling = None if known.scaling is None else known.scaling[row]
    if scaling is not None and signal.samples.dtype == np.int16:
        return replace(signal, scaling=scaling, unit=known.unit)
    # Values that somebody changed after the export count, not the codes beside them.
    if scaling is not None and codes is not None and _are_values(codes[row], scaling, signal.samples):
        return Signal(signal.name, np.ascontiguousarray(codes[row]), scaling, known.unit)
    return replace(signal, unit=known.unit)


def _are_values(codes: RawArray, scaling: tuple[float, ...], values: RawArray) -> bool:
    return np.array_equal(np.polynomial.polynomial.polyval(codes.astype(np.float64), scaling), values)
