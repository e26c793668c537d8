"""The formats that are read, by suffix."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from radargui.files.csv_file import list_csv, read_csv
from radargui.files.exported_signals import with_own_facts
from radargui.files.mat_file import list_mat, read_mat
from radargui.files.own_facts import csv_facts, mat_codes, mat_facts, sigmf_facts, tdms_facts
from radargui.files.run_signals import list_run, read_run_signals
from radargui.files.sigmf_file import list_sigmf, read_sigmf
from radargui.files.signals import ChannelInfo, Signals
from radargui.files.tdms_file import list_tdms, read_tdms
from radargui.model.errors import FileError


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


def format_of(path: Path) -> Format:
    """Return the format of a file.

    Raises
    ------
    FileError
        No such file, or a suffix that is not read.
    """
    if path.is_dir():
        raise FileError(f"{path} is a folder, not a file.")
    if not path.is_file():
        raise FileError(f"{path}: no such file.", remedy="Check the path.")
    suffix = path.suffix.lower()
    found = next((one for one in FORMATS if suffix in one.suffixes), None)
    if found is None:
        raise FileError(
            f"{path}: files of this kind are not read.",
            remedy=f"Give one of {', '.join(SUFFIXES)}.",
        )
    return found


def list_channels(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the channels that a file holds, for choosing among them.

    Raises
    ------
    FileError
        Unreadable or not of a known format.
    """
    return format_of(path).list(path)


def read_signals(path: Path, names: Sequence[str]) -> Signals:
    """Return channels of a file by the names that `list_channels` gives.

    Raises
    ------
    FileError
        Unreadable, not of a known format, or a channel missing.
    """
    return format_of(path).read(path, names)
