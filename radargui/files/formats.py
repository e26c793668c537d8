"""The formats that are read, by suffix; a run, and a file that we exported, with all that the format cannot say."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from radargui.files.csv_file import csv_facts, list_csv, read_csv
from radargui.files.export_facts import ExportFacts
from radargui.files.mat_file import list_mat, mat_codes, mat_facts, mat_program, read_mat
from radargui.files.raw_file import EXAMPLE, WHAT, RawLayout, list_raw, read_raw
from radargui.files.refusal import resolved, want_file
from radargui.files.run_file import read_run, read_run_setup
from radargui.files.sigmf_file import DATA_SUFFIX, list_sigmf, read_sigmf, sigmf_facts, sigmf_program
from radargui.files.signals import ChannelInfo, Signal, Signals
from radargui.files.tdms_file import list_tdms, read_tdms, tdms_facts
from radargui.model.arrays import RawArray
from radargui.model.digitisation import Digitisation
from radargui.model.errors import FileError, UsageError
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.model.setup_file import parse_setup


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
    return _of_rows(signals, rows, recording, path)


def _of_rows(signals: Sequence[Signal], rows: Sequence[int], source: Recording | ExportFacts, path: Path) -> Signals:
    """Return signals with all that a run, or one that was exported, says of its rows."""
    known = source.digitisation
    return Signals(
        tuple(signals),
        sample_rate_hz=known.sample_rate_hz,
        gaps=source.gaps,
        channel_skew_s=skew_of_rows(known.channel_skew_s, rows, path),
        started_at=source.started_at,
        device=known.device,
        trigger_index=source.trigger_index,
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
        whole = [_signal(signal, row, facts, codes) for signal, row in zip(signals.signals, known, strict=True)]
        return _of_rows(whole, known, facts, path)

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


@dataclass(frozen=True, slots=True)
class Format:
    """One kind of file: its name and suffixes, how it is listed and read, its facts where it is ours, who wrote it."""

    name: str
    suffixes: tuple[str, ...]
    list: Callable[[Path], tuple[ChannelInfo, ...]]
    read: Callable[[Path, Sequence[str]], Signals]
    facts: FindFacts = lambda _path: None
    program: Callable[[Path], str] | None = None


def _own(read: Read, facts: FindFacts, codes: FindCodes | None = None) -> tuple[Read, FindFacts]:
    return with_own_facts(read, facts, codes), facts


RUN = Format("RadarGUI run", (".h5", ".hdf5"), list_run, read_run_signals)
FORMATS = (
    RUN,
    Format("CSV", (".csv",), list_csv, *_own(read_csv, csv_facts)),
    Format("MATLAB", (".mat",), list_mat, *_own(read_mat, mat_facts, mat_codes), mat_program),
    Format("TDMS", (".tdms",), list_tdms, *_own(read_tdms, tdms_facts)),
    Format(
        "SigMF", (".sigmf-meta", ".sigmf-data", ".sigmf"), list_sigmf, *_own(read_sigmf, sigmf_facts), sigmf_program
    ),
)
SUFFIXES = tuple(suffix for one in FORMATS for suffix in one.suffixes)


def format_of(path: Path, raw: RawLayout | None = None) -> Format:
    """Return the format of a file.

    Parameters
    ----------
    path
        The file.
    raw
        How it is laid out where it is plain binary; None: its suffix tells what it is.

    Raises
    ------
    FileError
        No such file, or a suffix that is not read.
    UsageError
        A layout is given for a file that tells its own.
    """
    want_file(path)
    suffix, found = path.suffix.lower(), _by_suffix(path)
    if raw is not None:
        if found is not None and suffix != DATA_SUFFIX:
            raise UsageError(f"{path} is read as {found.name} and tells its own layout", remedy="Leave --raw out.")
        return Format(WHAT, (), partial(list_raw, layout=raw), partial(read_raw, layout=raw))
    if found is None:
        kind = f"files that end in {suffix} are" if suffix else "a file without a suffix is"
        raise FileError(
            f"{path}: {kind} not read.",
            remedy=f"Give one of {', '.join(SUFFIXES)}; plain binary with its layout: {EXAMPLE}.",
        )
    return found


def list_channels(path: Path, raw: RawLayout | None = None) -> tuple[ChannelInfo, ...]:
    """Return the channels that a file holds, for choosing among them.

    Raises
    ------
    FileError
        Unreadable or not of a known format.
    """
    return format_of(path, raw).list(path)


def read_signals(path: Path, names: Sequence[str], raw: RawLayout | None = None) -> Signals:
    """Return channels of a file by the names that `list_channels` gives.

    Raises
    ------
    FileError
        Unreadable, not of a known format, or a channel missing.
    """
    return format_of(path, raw).read(path, names)


def own_setup_of(path: Path) -> Setup | None:
    """Return the setup that a file brings with it: a run, or one that RadarGUI exported; None where it has none.

    Raises
    ------
    FileError
        It cannot be read.
    SetupError
        The setup in it is not valid for this version.
    """
    kind = _by_suffix(path)
    if kind is RUN:
        return read_run_setup(path)
    facts = kind.facts(path) if kind else None
    return parse_setup(facts.setup_toml, f"setup in {path}") if facts and facts.setup_toml.strip() else None


def source_program(path: Path) -> str:
    """Return the program that a file says wrote it; empty where it does not say."""
    kind = _by_suffix(path)
    try:
        if kind is not None and kind.program is not None:
            return kind.program(path)
        return "RadarGUI" if kind and kind.facts(path) else ""
    except (FileError, OSError):
        return ""


def _by_suffix(path: Path) -> Format | None:
    return next((one for one in FORMATS if path.suffix.lower() in one.suffixes), None)
