"""Names for the array types of arguments and results; work on long ones in pieces."""

from collections.abc import Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
"""Real numbers; NaN means unknown."""
ComplexArray: TypeAlias = NDArray[np.complex128]
"""Complex numbers: phasors, scattering amplitudes."""
BoolArray: TypeAlias = NDArray[np.bool_]
IntArray: TypeAlias = NDArray[np.intp]
RawArray: TypeAlias = NDArray[np.int16] | NDArray[np.float64]
"""Samples as the device gave them: int16 codes or volts, shape (n_channels, n_samples)."""

_PIECE = 1 << 14
"""Samples: so many stay in the processor's cache, and need little memory beside their result."""


def pieces(count: int, size: int = _PIECE) -> Iterator[slice]:
    """Yield slices of at most `size` that cover `count` samples."""
    for first in range(0, count, size):
        yield slice(first, min(first + size, count))
