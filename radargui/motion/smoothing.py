"""Weighed sums of neighbouring samples, which interpolation and smoothing of even samples are."""

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from radargui.model.arrays import FloatArray

_SHORT, _FEW, _MANY = 11, 48, 256
"""Weights up to which numpy's `correlate` is several times as fast a weight, up to which it pays to cut them, and from
which Fourier transforms are faster."""
_PARTS = 8  # so many times as long as the weights are pieces that are transformed, at the least; chosen by hand


def weighed_sums(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighed sums of as many samples in turn, out_n = sum over k of w_k values_(n + k).

    Parameters
    ----------
    values
        Shape (n_samples,).
    weights
        Shape (n_weights,), at most n_samples of them.

    Returns
    -------
    FloatArray
        Shape (n_samples - n_weights + 1,).
    """
    count = values.size - weights.size + 1
    if weights.size >= _MANY:
        return _by_transform(values, weights)[:count]
    total = np.zeros(count)
    length = _SHORT if weights.size <= _FEW else weights.size
    for first in range(0, weights.size, length):
        some = weights[first : first + length]
        total += np.correlate(values[first : first + count + some.size - 1], some, "valid")
    return total


def _by_transform(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the sums, and some more behind them, from overlapping pieces (overlap-save, Oppenheim & Schafer 8.7).

    scipy's `oaconvolve` does the same, but loading `scipy.signal` takes half a second.
    """
    length = 1 << int(np.ceil(np.log2(_PARTS * weights.size)))
    step = length - weights.size + 1
    padded = np.zeros((-(-values.size // step) - 1) * step + length)
    padded[: values.size] = values
    pieces = np.lib.stride_tricks.sliding_window_view(padded, length)[::step]
    # sums, not a convolution: the weights are not turned round
    filtered = np.fft.rfft(pieces, axis=1) * np.fft.rfft(weights, length).conj()
    return np.asarray(np.fft.irfft(filtered, length, axis=1)[:, :step].ravel())


def savitzky_golay(x: FloatArray, window: int, *, derivative: int = 0, spacing: float = 1.0) -> FloatArray:
    """Return a least-squares parabola around each sample along the last axis (Savitzky & Golay 1964).

    At the ends that of the first or the last window.

    Parameters
    ----------
    x
        Shape (..., n_samples).
    window
        Odd number of samples, at most n_samples.
    derivative, spacing
        Which derivative to give, and the distance of the samples for it.
    """
    half, unit = window // 2, spacing**derivative
    fit, values = _parabolas(window, derivative)
    weights = np.asarray(values[half] @ fit) / unit
    rows = [weighed_sums(row, weights) for row in x.reshape(-1, x.shape[-1])]
    middle = np.stack(rows).reshape(*x.shape[:-1], -1)
    begin, end = x[..., :window] @ fit.T @ values[:half].T, x[..., -window:] @ fit.T @ values[half + 1 :].T
    return np.asarray(np.concatenate([begin / unit, middle, end / unit], axis=-1), dtype=np.float64)


@lru_cache(maxsize=8)
def _parabolas(window: int, derivative: int) -> tuple[FloatArray, FloatArray]:
    """Return what fits a parabola to a window's samples, (3, window), and its derivative at each of them."""
    half = max(window // 2, 1)
    place = np.arange(-half, half + 1) / half
    # Legendre's: powers of the place would be nearly alike
    columns = legendre.legvander(place, 2)
    slopes = [legendre.legder(unit, derivative) for unit in np.eye(3)]
    values = np.stack([legendre.legval(place, slope) for slope in slopes], axis=1) / half**derivative
    return np.asarray(np.linalg.pinv(columns), dtype=np.float64), np.asarray(values, dtype=np.float64)
