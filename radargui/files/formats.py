"""The formats that are read, by suffix."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from radargui.files.csv_file import list_csv, read_csv
from radargui.files.exported_signals import with_own_facts
from radargui.files.mat_file import list_mat, read_mat
from radargui.files.own_facts import csv_facts, mat_codes, mat_facts, sigmf_facts, tdms_facts
from radargui.files.raw_file import EXAMPLE, WHAT, RawLayout, list_raw, read_raw
from radargui.files.refusal import want_file
from radargui.files.run_signals import list_run, read_run_signals
from radargui.files.sigmf_file import DATA_SUFFIX, list_sigmf, read_sigmf
from radargui.files.signals import ChannelInfo, Signals
from radargui.files.tdms_file import list_tdms, read_tdms
from radargui.model.errors import FileError, UsageError


@dataclass(frozen=True, slots=True)
class Format:
    """One kind of file: what it is called, its suffixes, how it is listed and read."""

    name: str
    suffixes: tuple[str, ...]
    list: Callable[[Path], tuple[ChannelInfo, ...]]
    read: Callable[[Path, Sequence[str]], Signals]


RUN = Format("RadarGUI run", (".h5", ".hdf5"), list_run, read_run_signals)
FORMATS = (
    RUN,
    Format("CSV", (".csv",), list_csv, with_own_facts(read_csv, csv_facts)),
    Format("MATLAB", (".mat",), list_mat, with_own_facts(read_mat, mat_facts, mat_codes)),
    Format("TDMS", (".tdms",), list_tdms, with_own_facts(read_tdms, tdms_facts)),
    Format("SigMF", (".sigmf-meta", ".sigmf-data", ".sigmf"), list_sigmf, with_own_facts(read_sigmf, sigmf_facts)),
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
    suffix = path.suffix.lower()
    found = next((one for one in FORMATS if suffix in one.suffixes), None)
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
