"""Export to MATLAB: v5 while it is small, 7.3 (HDF5) piece by piece where it is long."""

import re
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np
from scipy.io import savemat

from radargui.files import run_layout as layout
from radargui.files.export_facts import ExportFacts
from radargui.files.progress import Progress
from radargui.files.run_file import RunStream
from radargui.files.run_header import padded
from radargui.model.arrays import RawArray

LARGEST_V5_BYTES = 200_000_000
"""Volts and codes that are written as v5, for which all of them must be in memory."""
FACTS, CODES, SCALING = "radargui", "codes", "scaling"
"""All facts as TOML text; codes (n_samples, n_channels); coefficients c_k of volts, a row a channel."""
_FIT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")
_USER_BLOCK = 512
_HEADER = b"MATLAB 7.3 MAT-file, written by RadarGUI".ljust(116) + b"\0" * 8 + b"\x00\x02IM"


def write_mat(run: RunStream, path: Path, tell: Progress) -> None:
    """Write vectors `I1`, `Q1`, ... in volts (or the unit), `Fs` in Hz, `unit`, and all facts as TOML in `radargui`.

    A run of codes holds them untouched, too: `codes` (n_samples, n_channels, int16) and `scaling` (n_channels,
    n_coefficients), volts = sum over k of scaling(channel, k + 1) code^k.
    """
    facts = run.facts
    n_bytes = facts.n_samples * facts.digitisation.n_channels * 10
    if n_bytes > LARGEST_V5_BYTES:
        _write_mat73(run, path, tell)
        return
    pieces = list(run.pieces())
    raw = cast("RawArray", np.hstack(pieces) if pieces else np.empty((facts.digitisation.n_channels, 0)))
    volts = facts.digitisation.volts(raw)
    content: dict[str, Any] = dict(zip(_variable_names(facts), volts[:, :, None], strict=True))
    content |= _small_variables(facts)
    if facts.digitisation.scaling is not None:
        content[CODES] = raw.T
        content[SCALING] = padded(facts.digitisation.scaling)
    tell(0.5)
    savemat(path, content, do_compression=True, appendmat=False, long_field_names=True)
    tell(1.0)


def _write_mat73(run: RunStream, path: Path, tell: Progress) -> None:
    """Write the variables that `write_mat` names; arrays lie in the file with their sides exchanged, as MATLAB does."""
    facts = run.facts
    names, n_samples = _variable_names(facts), facts.n_samples
    scaling = facts.digitisation.scaling
    with h5py.File(path, "w", userblock_size=_USER_BLOCK) as file:
        for name, value in _small_variables(facts).items():
            _put_text(file, name, value) if isinstance(value, str) else _put(file, name, np.array([[value]]))
        chunk = min(layout.chunk_length(facts.digitisation.sample_rate_hz), max(n_samples, 1))
        volts = [_make(file, name, (1, n_samples), np.float64, chunk) for name in names]
        codes = _make(file, CODES, (len(names), n_samples), np.int16, chunk) if scaling is not None else None
        if scaling is not None:
            _put(file, SCALING, padded(scaling).T)
        done = 0
        for piece in run.pieces(tell):
            end = done + piece.shape[1]
            for dataset, row in zip(volts, facts.digitisation.volts(piece), strict=True):
                dataset[0, done:end] = row
            if codes is not None:
                codes[:, done:end] = piece
            done = end
    with path.open("rb+") as raw:
        raw.write(_HEADER)


def _make(file: Any, name: str, shape: tuple[int, int], dtype: Any, chunk: int) -> Any:
    dataset = file.create_dataset(name, shape, dtype, chunks=(1, chunk), **layout.COMPRESSION)
    return _marked(dataset, np.dtype(dtype))


def _put(file: Any, name: str, values: Any) -> None:
    _marked(file.create_dataset(name, data=values), values.dtype)


def _put_text(file: Any, name: str, text: str) -> None:
    codes = np.frombuffer(text.encode("utf-16-le", "replace"), dtype="<u2")
    if codes.size:
        dataset = file.create_dataset(name, data=codes[:, None])
    else:
        # What is empty is kept as its size.
        dataset = file.create_dataset(name, data=np.zeros(2, dtype=np.uint64))
        dataset.attrs["MATLAB_empty"] = np.uint8(1)
    dataset.attrs["MATLAB_class"] = np.bytes_("char")
    dataset.attrs["MATLAB_int_decode"] = np.int32(2)


def _marked(dataset: Any, dtype: Any) -> Any:
    dataset.attrs["MATLAB_class"] = np.bytes_("int16" if dtype == np.int16 else "double")
    return dataset


def _variable_names(facts: ExportFacts) -> tuple[str, ...]:
    """Return the names of the channels, ch1, ch2, ... where one cannot be that of a variable."""
    names = facts.digitisation.channel_names
    taken = {*_small_variables(facts), CODES, SCALING}
    if all(_FIT.fullmatch(name) and name not in taken for name in names):
        return names
    return tuple(f"ch{place}" for place in range(1, len(names) + 1))


def _small_variables(facts: ExportFacts) -> dict[str, Any]:
    """Return the variables that hold single values and texts."""
    known = facts.digitisation
    # left out, not NaN, where nobody told it: a script that asks for it shall fail, not compute with nothing
    skew = {} if known.channel_skew_s is None else {"channel_skew_s": known.channel_skew_s}
    return {
        "Fs": known.sample_rate_hz,
        "unit": known.unit,
        **skew,
        "started_at": facts.started_at,
        FACTS: facts.text(),
    }
