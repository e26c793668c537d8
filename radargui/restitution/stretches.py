"""Stretches of a sampled curve, one after the other: sums and fits over all of them at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray

MIN_RESIDUALS = 8
"""Of fewer samples neither a correlation nor a third difference tells anything."""


@dataclass(frozen=True, slots=True)
class Stretches:
    """Samples of stretches that may overlap, laid one after the other.

    Attributes
    ----------
    place
        Index of each sample in the curve, shape (n_samples,).
    first, count
        Where each stretch begins among these, and how many it has, shape (n_stretches,); none is empty.
    origin_s
        Mean time of each, shape (n_stretches,).
    away_s
        Time of each sample less its stretch's origin, shape (n_samples,).
    """

    place: IntArray
    first: IntArray
    count: IntArray
    origin_s: FloatArray
    away_s: FloatArray

    @staticmethod
    def between(time_s: FloatArray, begin: IntArray, end: IntArray) -> Stretches:
        """Return samples begin:end of a curve at times (n,); every stretch has one at least."""
        count = end - begin
        first = np.cumsum(count) - count
        place = np.arange(int(count.sum())) + np.repeat(begin - first, count)
        time = time_s[place]
        origin = np.add.reduceat(time, first) / count if count.size else np.zeros(0)
        return Stretches(place, first, count, origin, time - np.repeat(origin, count))

    def chosen(self, which: BoolArray) -> Stretches:
        """Return some of the stretches, `which` of shape (n_stretches,)."""
        if which.all():
            return self
        kept, count = np.repeat(which, self.count), self.count[which]
        return Stretches(self.place[kept], np.cumsum(count) - count, count, self.origin_s[which], self.away_s[kept])

    @property
    def size(self) -> int:
        """Number of stretches."""
        return int(self.count.size)

    def of(self, curve: FloatArray) -> FloatArray:
        """Return the samples of a curve (..., n), shape (..., n_samples)."""
        return np.asarray(curve[..., self.place])

    def sums(self, samples: FloatArray) -> FloatArray:
        """Return the sum over each stretch of samples (..., n_samples), shape (..., n_stretches)."""
        return np.asarray(np.add.reduceat(samples, self.first, axis=-1))

    def means(self, samples: FloatArray) -> FloatArray:
        """Return the mean over each stretch of samples (..., n_samples), shape (..., n_stretches)."""
        return self.sums(samples) / self.count

    def spread(self, values: FloatArray) -> FloatArray:
        """Return a value of each stretch (..., n_stretches) at its samples, shape (..., n_samples)."""
        return np.repeat(values, self.count, axis=-1)

    def lines(self, samples: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return height at the origin and slope of least-squares lines, shapes (..., n_stretches)."""
        return self.means(samples), self.sums(samples * self.away_s) / self.sums(self.away_s**2)

    def correlation_lengths(self, residual: FloatArray) -> FloatArray:
        """Return 1 + 2 sum of the autocorrelation up to its first zero, in samples, at least 1.

        Parameters
        ----------
        residual
            Shape (..., n_samples).

        Returns
        -------
        FloatArray
            Shape (..., n_stretches).
        """
        residual = residual - self.spread(self.means(residual))
        out = np.ones((*residual.shape[:-1], self.size))
        # stretches of about one length go together: padded to a common one they are one Fourier transform
        magnitude = np.ceil(np.log2(self.count))
        for power in set(magnitude[self.count >= MIN_RESIDUALS].tolist()):
            own = np.flatnonzero(magnitude == power)
            longest = int(self.count[own].max())
            inside = np.arange(longest) < self.count[own, None]
            place = np.minimum(self.first[own, None] + np.arange(longest), residual.shape[-1] - 1)
            rows = np.where(inside, residual[..., place], 0.0)
            out[..., own] = _correlation_lengths(rows, self.count[own])
        return out


def _correlation_lengths(rows: FloatArray, count: IntArray) -> FloatArray:
    """Return the correlation lengths of rows (..., n_rows, n) without mean, zero beyond their count, (..., n_rows)."""
    half = max(int(count.max()) // 2, 1)
    # so long that no lag up to half of a row wraps round
    size = _transform_size(rows.shape[-1] + half)
    spectrum = np.fft.rfft(rows, size)
    correlation = np.fft.irfft(spectrum.real**2 + spectrum.imag**2, size)[..., :half]
    # up to the first zero: beyond it the sum is noise, over all of it exactly zero
    past = (correlation <= 0.0) | (np.arange(half) >= count[:, None] // 2)
    summed = np.where(np.logical_or.accumulate(past, axis=-1), 0.0, correlation).sum(axis=-1)
    level = correlation[..., 0]
    known = (level > 0.0) & (summed > 0.0)
    return np.where(known, np.maximum(1.0, 2.0 * summed / np.where(known, level, 1.0) - 1.0), 1.0)


def _transform_size(least: int) -> int:
    """Return 2^k, 3 2^k or 5 2^k samples: Fourier transforms of these are fast."""
    return min(factor << max(0, (-(-least // factor) - 1).bit_length()) for factor in (1, 3, 5))
