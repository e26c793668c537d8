"""The facts that an exported file carries, found again when it is read."""

from __future__ import annotations

import json
import re
import tarfile
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files import hdf5
from radargui.files.csv_layout import LONGEST_HEADER
from radargui.files.export_facts import FORMAT, LARGEST_TEXT, ExportFacts, facts_of_table, facts_of_text, uncommented
from radargui.files.mat_writer import CODES
from radargui.files.mat_writer import FACTS as MAT_FACTS
from radargui.files.refusal import reading
from radargui.files.run_file import opened_run
from radargui.files.sigmf_file import ARCHIVE_SUFFIX, LARGEST_META, META_SUFFIX
from radargui.files.sigmf_writer import FACTS as SIGMF_FACTS
from radargui.files.tdms_file import opened_tdms
from radargui.files.tdms_writer import FACTS as TDMS_FACTS
from radargui.model.arrays import RawArray
from radargui.model.errors import FileError

_WRITTEN_BY = re.compile(r"\b(?:written )?by (.+)", re.DOTALL)
"""In the text at the beginning of a MATLAB file, where other programs than MATLAB name themselves."""


def own_setup_toml(path: Path) -> str:
    """Return the setup that a file brings with it as TOML: a run, or one that was exported; empty where it has none.

    Raises
    ------
    FileError
        It cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix in (".h5", ".hdf5"):
        with opened_run(path) as file:
            return hdf5.text(file.attrs, "setup")
    find = {".csv": csv_facts, ".mat": mat_facts, ".tdms": tdms_facts}.get(suffix)
    if find is None and suffix.startswith(ARCHIVE_SUFFIX):
        find = sigmf_facts
    facts = find(path) if find else None
    return facts.setup_toml if facts else ""


def source_program(path: Path) -> str:
    """Return the program that a file says wrote it; empty where it does not say."""
    suffix = path.suffix.lower()
    try:
        if suffix.startswith(ARCHIVE_SUFFIX):
            with reading(path, "a SigMF recording"):
                told = _sigmf_global(path).get("core:recorder")
            return told[:80] if isinstance(told, str) else ""
        if suffix == ".mat":
            with path.open("rb") as file:
                head = file.read(116).decode("ascii", "replace")
            found = _WRITTEN_BY.search(head)
            return found[1].strip(" .\0")[:80] if found else ""
        facts = {".csv": csv_facts, ".tdms": tdms_facts}.get(suffix, lambda _: None)(path)
    except (FileError, OSError):
        return ""
    return "RadarGUI" if facts else ""


def csv_facts(path: Path) -> ExportFacts | None:
    """Return what the comments at the start of a CSV file tell; None where it is no export of ours."""
    lines: list[str] = []
    size = 0
    with reading(path, "CSV"), path.open(encoding="utf-8-sig", errors="replace", newline=None) as file:
        while (line := file.readline(LONGEST_HEADER)).startswith("#") and size <= LARGEST_TEXT:
            if not lines and FORMAT not in line:
                return None
            lines.append(line)
            size += len(line)
    return facts_of_text(uncommented(lines))


def mat_facts(path: Path) -> ExportFacts | None:
    """Return what the variable `radargui` of a MATLAB file tells; None where it is no export of ours."""
    text = _mat_variable(path, MAT_FACTS)
    return facts_of_text(text) if isinstance(text, str) else None


def mat_codes(path: Path, facts: ExportFacts) -> RawArray | None:
    """Return the codes in a MATLAB file, shape (n_channels, n_samples); None where they are not what was exported."""
    codes = _mat_variable(path, CODES)
    shape = (facts.digitisation.n_channels, facts.n_samples)
    if not isinstance(codes, np.ndarray) or codes.dtype != np.int16 or codes.size != shape[0] * shape[1]:
        return None
    return codes.reshape(shape) if codes.ndim == 1 else codes.T if codes.shape == shape[::-1] else None


def tdms_facts(path: Path) -> ExportFacts | None:
    """Return what the property `RadarGUI` of a TDMS file tells; None where it is no export of ours."""
    with opened_tdms(path) as file:
        text = file.properties.get(TDMS_FACTS)
    return facts_of_text(text) if isinstance(text, str) else None


def sigmf_facts(path: Path) -> ExportFacts | None:
    """Return what `radargui:facts` of a SigMF recording tells; None where it is no export of ours."""
    with reading(path, "a SigMF recording"):
        table = _sigmf_global(path)
    return facts_of_table(table.get(SIGMF_FACTS))


def _sigmf_global(path: Path) -> dict[str, Any]:
    metadata = json.loads(_archived_meta(path) if path.suffix.lower() == ARCHIVE_SUFFIX else _meta(path))
    table = metadata.get("global") if isinstance(metadata, dict) else None
    return table if isinstance(table, dict) else {}


def _meta(path: Path) -> str:
    meta = path.with_suffix(META_SUFFIX)
    return meta.read_text(encoding="utf-8") if meta.stat().st_size <= LARGEST_META else "{}"


def _archived_meta(path: Path) -> str:
    # "r:": an archive that is not compressed, as the format wants it; nothing can swell.
    with tarfile.open(path, "r:") as archive:
        for member in archive:
            if member.isfile() and member.name.endswith(META_SUFFIX) and member.size <= LARGEST_META:
                content = archive.extractfile(member)
                return content.read().decode("utf-8") if content else "{}"
    return "{}"


def _mat_variable(path: Path, name: str) -> Any:
    with reading(path, "a MATLAB file"):
        return _mat73_variable(path, name) if hdf5.is_hdf5(path) else _mat5_variable(path, name)


def _mat5_variable(path: Path, name: str) -> Any:
    from scipy.io import loadmat

    from radargui.files.mat5 import sound_variables

    if name not in sound_variables(path):
        return None
    return loadmat(str(path), variable_names=[name], simplify_cells=True).get(name)


def _mat73_variable(path: Path, name: str) -> Any:
    with hdf5.opened(path, "a MATLAB file") as file:
        if name not in file:
            return None
        found = hdf5.dataset(file, name, path)
        if hdf5.text(found.attrs, "MATLAB_class") != "char":
            return found[...].T
        if found.dtype != np.uint16 or found.size > LARGEST_TEXT:
            return None
        return np.ravel(found[...], order="F").astype("<u2").tobytes().decode("utf-16-le", "replace")
