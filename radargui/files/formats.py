"""List every format that recordings are read from or runs are written in."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from radargui.files import csv_file as csv, mat_file as mat, sigmf_file as sigmf, tdms_file as tdms
from radargui.files.access import Progress, fresh_files, make_folder, resolved, silent, want_file
from radargui.files.raw_file import EXAMPLE, WHAT, RawLayout, list_raw, read_raw
from radargui.files.run_file import ExportFacts, read_run, read_run_setup, run_stream
from radargui.files.signals import ChannelInfo, Signal, Signals
from radargui.model.arrays import RawArray
from radargui.model.errors import FileError, UsageError, worded
from radargui.model.recording import Digitisation, Recording
from radargui.model.setup import Setup, parse_setup


def list_run(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the channels of a run file.

    Raises
    ------
    FileError
        Unreadable or no run file.
    """
    with run_stream(path) as run:
        known, count = run.facts.digitisation, run.facts.n_samples
    return tuple(ChannelInfo(name, count, known.sample_rate_hz, known.unit) for name in known.channel_names)


def read_run_signals(path: Path, names: Sequence[str]) -> Signals:
    """Return channels of a run file by name.

    Raises
    ------
    FileError
        Unreadable, no run file, or a channel missing.
    """
    recording = read_run(path)
    known = recording.digitisation
    rows = [known.channel_names.index(name) for name in resolved(path, names, known.channel_names)]
    scaling = known.scaling or (None,) * known.n_channels
    signals = [Signal(known.channel_names[row], recording.raw[row], scaling[row], known.unit) for row in rows]
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
        # a code is always a number: what is none beside codes was damaged since
        of_run=known.scaling is None,
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


def _row(name: str, known: Digitisation) -> int:
    """Return which channel of an export a signal is, -1 where it is none."""
    last = name.rpartition("/")[2]
    if last in known.channel_names:
        return known.channel_names.index(last)
    match = _NUMBERED.fullmatch(last)
    return int(match[1]) - 1 if match and int(match[1]) <= known.n_channels else -1


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
    """One kind of file.

    Attributes
    ----------
    name, suffixes
        For people.
    list
        Gives what a file holds.
    read_any
        Reads any file of the format.
    facts
        Gives the facts in a file that RadarGUI exported, None in a foreign one.
    codes
        Gives the codes where the format keeps them beside the values.
    program
        Gives who wrote a file.
    """

    name: str
    suffixes: tuple[str, ...]
    list: Callable[[Path], tuple[ChannelInfo, ...]]
    read_any: Callable[[Path, Sequence[str]], Signals]
    facts: Callable[[Path], ExportFacts | None] = lambda _path: None
    codes: Callable[[Path, ExportFacts], RawArray | None] = lambda _path, _facts: None
    program: Callable[[Path], str] | None = None

    def read(self, path: Path, names: Sequence[str]) -> Signals:
        """Return channels of a file; of one that RadarGUI exported with scaling, unit, skew, gaps, trigger, date.

        Where the samples in the file are no longer those that were exported (another number of them, other names), the
        file is taken for what it says itself.
        """
        signals, facts = self.read_any(path, names), self.facts(path)
        if facts is None or any(signal.samples.size != facts.n_samples for signal in signals.signals):
            return signals
        rows = [_row(signal.name, facts.digitisation) for signal in signals.signals]
        if any(row < 0 for row in rows):
            return signals
        codes = self.codes(path, facts) if facts.digitisation.scaling else None
        whole = [_signal(signal, row, facts, codes) for signal, row in zip(signals.signals, rows, strict=True)]
        return _of_rows(whole, rows, facts, path)


RUN = Format("RadarGUI run", (".h5", ".hdf5"), list_run, read_run_signals)
FORMATS = (
    RUN,
    Format("CSV", (".csv",), csv.list_csv, csv.read_csv, csv.csv_facts),
    Format("MATLAB", (".mat",), mat.list_mat, mat.read_mat, mat.mat_facts, mat.mat_codes, mat.mat_program),
    Format("TDMS", (".tdms",), tdms.list_tdms, tdms.read_tdms, tdms.tdms_facts),
    Format(
        "SigMF",
        sigmf.SIGMF_SUFFIXES,
        sigmf.list_sigmf,
        sigmf.read_sigmf,
        sigmf.sigmf_facts,
        program=sigmf.sigmf_program,
    ),
)
SUFFIXES: tuple[str, ...] = tuple(suffix for one in FORMATS for suffix in one.suffixes)


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
        if found is not None and suffix != sigmf.DATA_SUFFIX:
            raise UsageError(f"{path} is read as {found.name} and tells its own layout", remedy="Leave --raw out.")
        return Format(WHAT, (), partial(list_raw, layout=raw), partial(read_raw, layout=raw))
    if found is None:
        kind = f"files that end in {suffix} are" if suffix else "a file without a suffix is"
        raise worded(FileError, "unknown_format", path=path, kind=kind, suffixes=", ".join(SUFFIXES), example=EXAMPLE)
    return found


def list_channels(path: Path, raw: RawLayout | None = None) -> tuple[ChannelInfo, ...]:
    """Return the channels that a file holds, for choosing among them.

    Raises
    ------
    FileError
        Unreadable or not of a known format.
    """
    return format_of(path, raw).list(path)


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


def session_facts_of(path: Path) -> Mapping[str, str]:
    """Return what an exported run says of its session (operator, sample, ...); empty where the file says nothing."""
    kind = _by_suffix(path)
    with suppress(FileError, OSError):
        if kind is not None and (facts := kind.facts(path)) is not None:
            return facts.session
    return {}


def source_program(path: Path) -> str:
    """Return the program that a file says wrote it; empty where it does not say."""
    kind = _by_suffix(path)
    with suppress(FileError, OSError):
        if kind is not None:
            return kind.program(path) if kind.program else "RadarGUI" if kind.facts(path) else ""
    return ""


def _by_suffix(path: Path) -> Format | None:
    return next((one for one in FORMATS if path.suffix.lower() in one.suffixes), None)


@dataclass(frozen=True, slots=True)
class ExportFormat:
    """A format that runs are exported to.

    Attributes
    ----------
    name
        As the command line names it.
    title
        For people.
    suffixes
        Of the files that one run becomes.
    write
        Takes the run, one path a suffix, and what takes the share done.
    """

    name: str
    title: str
    suffixes: tuple[str, ...]
    write: Callable[..., None]

    def paths(self, folder: Path, stem: str) -> tuple[Path, ...]:
        """Return the files that a run becomes in a folder."""
        return tuple(folder / (stem + suffix) for suffix in self.suffixes)


EXPORT_FORMATS: Mapping[str, ExportFormat] = {
    one.name: one
    for one in (
        ExportFormat("csv", "CSV", (".csv",), csv.write_csv),
        ExportFormat("mat", "MATLAB", (".mat",), mat.write_mat),
        ExportFormat("tdms", "NI TDMS", (".tdms",), tdms.write_tdms),
        ExportFormat("sigmf", "SigMF", sigmf.SIGMF_SUFFIXES[:2], sigmf.write_sigmf),
    )
}
"""By the name that commands know; of SigMF's suffixes the third is that of archives, which are only read."""


def export_run(
    path: Path,
    kind: ExportFormat,
    folder: Path,
    *,
    session: Mapping[str, str] | None = None,
    force: bool = False,
    report: Progress = silent,
) -> tuple[Path, ...]:
    """Write a run file in another format and return the files made; the run itself is only read.

    Parameters
    ----------
    path
        Run file.
    kind
        One of `EXPORT_FORMATS`.
    folder
        Where the files go, made where it is not there; they are named as the run.
    session
        Facts of its session that shall travel with it.
    force
        Whether files that are there are replaced.
    report
        Called with the share done.

    Raises
    ------
    FileError
        The run cannot be read, the files cannot be written, or one is there already.
    """
    paths = kind.paths(folder, path.stem)
    with run_stream(path, session) as run:
        make_folder(folder)
        with fresh_files(paths, force=force) as partial:
            kind.write(run, *partial, report)
    return paths
