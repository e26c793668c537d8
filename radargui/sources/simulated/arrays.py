"""Small array helpers: dot products and phasors without temporary copies."""

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray


def dot(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the dot products of vectors along axis 0, shape (3, n) each (or (3, 1))."""
    return np.asarray(first[0] * second[0] + first[1] * second[1] + first[2] * second[2])


def phasor(phase_rad: FloatArray, amplitude: FloatArray | float = 1.0) -> ComplexArray:
    """Return amplitude exp(j phase), shape (n,); real sine and cosine are much faster than the complex exponential."""
    out = np.empty(phase_rad.shape, dtype=np.complex128)
    np.multiply(np.cos(phase_rad), amplitude, out=out.real)
    np.multiply(np.sin(phase_rad), amplitude, out=out.imag)
    return out
