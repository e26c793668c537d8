"""Names for the array types that cross borders."""

from __future__ import annotations

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
