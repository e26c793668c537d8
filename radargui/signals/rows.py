"""Rows of samples: the pairs of channels, values by their order, sizes of quick Fourier transforms."""

from functools import lru_cache

import numpy as np

from radargui.model.arrays import FloatArray


def pairs_of(volts: FloatArray) -> list[slice]:
    """Return the channels of each receiver, of rows I1, Q1, I2, ..."""
    return [slice(first, first + 2) for first in range(0, volts.shape[0], 2)]


def held_beyond(inner: FloatArray, first: int, n: int) -> FloatArray:
    """Return values that begin at sample `first` of n, the first and the last of them held before and after."""
    out = np.empty(n)
    out[:first], out[first : first + inner.size], out[first + inner.size :] = inner[0], inner, inner[-1]
    return out


def order_statistics(values: FloatArray, *shares: float) -> FloatArray:
    """Return those of the last axis (..., n) that shares of the others lie below, shape (..., n_shares).

    numpy's quantiles interpolate between two values, which takes most of their time for some thousand values.
    """
    place = [round(share * (values.shape[-1] - 1)) for share in shares]
    return np.asarray(np.partition(values, place, axis=-1)[..., place])


@lru_cache(maxsize=64)
def even_transform_size(wanted: float) -> int:
    """Return the even number nearest to the one wanted whose Fourier transform is fast: factors 2, 3 and 5 alone."""
    near = range(2 * int(0.45 * wanted), 2 * int(0.55 * wanted) + 4, 2)
    return min((size for size in near if size and _is_smooth(size)), key=lambda size: abs(size - wanted))


def _is_smooth(size: int) -> bool:
    for factor in (2, 3, 5):
        while size % factor == 0:
            size //= factor
    return size == 1
