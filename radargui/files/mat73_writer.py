"""Export to MATLAB 7.3: HDF5 as MATLAB writes it, filled piece by piece."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np

from radargui.files import run_layout as layout
from radargui.files.mat_layout import CODES, SCALING, scaling_table, small_variables, variable_names
from radargui.files.progress import Progress
from radargui.files.run_stream import RunStream

_USER_BLOCK = 512
_HEADER = b"MATLAB 7.3 MAT-file, written by RadarGUI".ljust(116) + b"\0" * 8 + b"\x00\x02IM"


def write_mat73(run: RunStream, path: Path, tell: Progress) -> None:
    """Write the variables that `write_mat` names; arrays lie in the file with their sides exchanged, as MATLAB does."""
    facts = run.facts
    names, n_samples = variable_names(facts), facts.n_samples
    is_code = facts.digitisation.scaling is not None
    with h5py.File(path, "w", userblock_size=_USER_BLOCK) as file:
        for name, value in small_variables(facts).items():
            _put_text(file, name, value) if isinstance(value, str) else _put(file, name, np.array([[value]]))
        chunk = min(layout.chunk_length(facts.digitisation.sample_rate_hz), max(n_samples, 1))
        volts = [_make(file, name, (1, n_samples), np.float64, chunk) for name in names]
        codes = _make(file, CODES, (len(names), n_samples), np.int16, chunk) if is_code else None
        if is_code:
            _put(file, SCALING, scaling_table(facts).T)
        done = 0
        for piece in run.pieces():
            end = done + piece.shape[1]
            for dataset, row in zip(volts, facts.digitisation.volts(piece), strict=True):
                dataset[0, done:end] = row
            if codes is not None:
                codes[:, done:end] = piece
            done = end
            tell(done / max(n_samples, 1))
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
