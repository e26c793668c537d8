"""A variable of a MATLAB file, or a field of a structure in it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable, or a field of a structure, by its dotted name.

    Attributes
    ----------
    name
        Such as `src1.Data`.
    shape
        Without sides of length 1; empty for single values.
    is_real
        Whether it holds real numbers.
    value
        Samples (n,), a number, a text; None where it was not read or is none of these.
    """

    name: str
    shape: tuple[int, ...] = ()
    value: FloatArray | float | str | None = field(default=None, repr=False)
    is_real: bool = False

    @property
    def is_vector(self) -> bool:
        """Whether it can be a channel."""
        return self.is_real and len(self.shape) == 1 and self.shape[0] > 0


def variable_of(name: str, value: Any) -> Variable:
    """Return an array, number or text as a variable."""
    if isinstance(value, str):
        return Variable(name, value=value)
    array = np.squeeze(np.asarray(value))
    if array.ndim == 0:
        single = array.item() if array.dtype.kind in "iufb" else None
        return Variable(name, value=None if single is None else float(single))
    is_real = array.dtype.kind in "iufb"
    # A damaged file may hold signalling NaN; that they are no numbers is said where samples are looked at.
    with np.errstate(invalid="ignore"):
        vector = np.ascontiguousarray(array, dtype=np.float64) if is_real and array.ndim == 1 and array.size else None
    return Variable(name, array.shape, vector, is_real)
