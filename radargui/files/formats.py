"""The formats that are read, by suffix."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from radargui.files import hdf5
from radargui.files.csv_file import csv_facts, list_csv, read_csv
from radargui.files.exported_signals import FindCodes, FindFacts, Read, list_run, read_run_signals, with_own_facts
from radargui.files.mat_file import list_mat, mat_codes, mat_facts, mat_program, read_mat
from radargui.files.raw_file import EXAMPLE, WHAT, RawLayout, list_raw, read_raw
from radargui.files.refusal import want_file
from radargui.files.run_file import opened_run
from radargui.files.sigmf_file import DATA_SUFFIX, list_sigmf, read_sigmf, sigmf_facts, sigmf_program
from radargui.files.signals import ChannelInfo, Signals
from radargui.files.tdms_file import list_tdms, read_tdms, tdms_facts
from radargui.model.errors import FileError, UsageError


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
        told = f"files that end in {suffix} are" if suffix else "a file without a suffix is"
        raise FileError(
            f"{path}: {told} not read.",
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


def own_setup_toml(path: Path) -> str:
    """Return the setup that a file brings with it as TOML: a run, or one that was exported; empty where it has none.

    Raises
    ------
    FileError
        It cannot be read.
    """
    kind = _by_suffix(path)
    if kind is RUN:
        with opened_run(path) as file:
            return hdf5.text(file.attrs, "setup")
    facts = kind.facts(path) if kind else None
    return facts.setup_toml if facts else ""


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
