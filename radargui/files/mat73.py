"""MATLAB 7.3 files: HDF5 with MATLAB's habits (vectors are 2-D, text is uint16, structures are groups)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from radargui.files import hdf5
from radargui.files.mat_variable import Variable, variable_of

_SMALL = 64
"""Values of an array that is read unasked: single numbers and dates stand in such, samples do not."""
_LONGEST_TEXT = 256
"""Characters of a text that is read unasked: a unit or a date is shorter."""
_DEEPEST = 16
_MOST = 10_000
"""Groups within groups, and arrays in all, that are looked at: damaged files hold loops. Chosen by hand."""


def read_variables(path: Path, wanted: Sequence[str]) -> dict[str, Variable]:
    """Return all variables and fields by dotted name; of long vectors only the wanted ones with their samples.

    Raises
    ------
    FileError
        Damaged, or a wanted vector claims more than the file holds.
    """
    with hdf5.opened(path, "a MATLAB file") as file:
        found: dict[str, Variable] = {}
        for name, item in _datasets(file, "", 0):
            if len(found) >= _MOST:
                break
            found[name] = _variable(file, path, name, item, name in wanted)
        return found


def _datasets(group: Any, prefix: str, depth: int) -> Iterator[tuple[str, Any]]:
    for name in group:
        # Beside the variables, MATLAB keeps the content of cells in #refs#; links out of the file are not followed.
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        item = group[name]
        if isinstance(item, h5py.Dataset):
            yield f"{prefix}{name}", item
        elif isinstance(item, h5py.Group) and depth < _DEEPEST and "MATLAB_sparse" not in item.attrs:
            yield from _datasets(item, f"{prefix}{name}.", depth + 1)


def _variable(file: Any, path: Path, name: str, item: Any, wanted: bool) -> Variable:
    shape = tuple(int(size) for size in item.shape if size != 1)
    if "MATLAB_empty" in item.attrs or item.shape is None or item.ndim > 2 or item.dtype.kind not in "iufb":
        return Variable(name, shape)
    is_text = hdf5.text(item.attrs, "MATLAB_class") == "char"
    read = item.size <= _LONGEST_TEXT and item.dtype == np.uint16 if is_text else wanted or item.size <= _SMALL
    if not read:
        return Variable(name, shape, is_real=not is_text)
    values = hdf5.dataset(file, name.replace(".", "/"), path, (0, 1, 2))[...]
    if is_text:
        return Variable(name, value="".join(chr(code) for code in np.ravel(values, order="F")))
    return variable_of(name, values)
