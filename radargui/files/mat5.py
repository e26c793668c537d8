"""MATLAB v5 files through scipy."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from radargui.files.mat5_claims import sound_variables
from radargui.files.mat_variable import Variable, variable_of


def read_variables(path: Path) -> dict[str, Variable]:
    """Return all variables and fields of structures by dotted name; whatever scipy raises on damage passes.

    Objects, functions and sparse matrices are left out: they are no samples.
    """
    names = sound_variables(path)
    content = loadmat(str(path), variable_names=names, simplify_cells=True) if names else {}
    named = {name: content[name] for name in names if name in content}
    return {name: variable_of(name, value) for name, value in _leaves("", named)}


def _leaves(prefix: str, content: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _leaves(f"{prefix}{name}.", value)
        elif isinstance(value, str | int | float | np.ndarray | np.generic):
            yield f"{prefix}{name}", value
