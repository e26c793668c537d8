"""The offset of I and Q along a record, from the frames whose Doppler line lies clear of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solveh_banded

from radargui.conditioning.doppler import Doppler
from radargui.model.arrays import ComplexArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class OffsetSettings:
    """How the curve is drawn.

    Attributes
    ----------
    least_bins
        Doppler frequency in bins from which the mean under a Hann window holds less than 1 % of the echo.
    knots_s
        Distance of the knots, and the time over which the curve is smooth: drifts are slower than 1 Hz.
    most_scatter
        Of the frames about the curve, in amplitudes; with more it is made more supple, down to one knot a frame.
    """

    least_bins: float = 2.5
    knots_s: float = 0.15
    most_scatter: float = 0.1


SETTINGS = OffsetSettings()


def offset_curve(wave: ComplexArray, doppler: Doppler) -> tuple[ComplexArray, FloatArray]:
    """Return the offset at each sample and how far it may have drifted since it was last seen, shapes (n_samples,).

    Means of frames under a Hann window, joined by the curve of least curvature through knots: an echo that turns fast
    has no mean, and what a second reflection adds at twice its frequency has none either.

    Parameters
    ----------
    wave
        X + jY without front end, shape (n_samples,).
    doppler
        Lines of its frames; some of them clear.
    """
    seen = doppler.clear & (doppler.frequency_hz >= SETTINGS.least_bins * doppler.resolution_hz)
    centre, half = doppler.centre[seen], doppler.size // 2
    # its zeros lie on whole bins: an echo of 2.5 bins and more averages out
    window = np.hanning(doppler.size)
    mean = np.array([window @ wave[at - half : at - half + doppler.size] for at in centre]) / window.sum()
    # <|z|^2> under the window, by Parseval
    amplitude = np.sqrt(4.0 * np.median(doppler.moments[0, seen]) / (doppler.size * (window**2).sum()))
    step = max(round(SETTINGS.knots_s * doppler.sample_rate_hz), half)
    knots, curve, apart = _curve(centre, mean, step, half, wave.size)
    while apart > SETTINGS.most_scatter * amplitude and step > half:
        step = max(step // 2, half)
        knots, curve, apart = _curve(centre, mean, step, half, wave.size)
    sample = np.arange(wave.size)
    offset = np.interp(sample, knots, curve[:, 0]) + 1j * np.interp(sample, knots, curve[:, 1])
    # where nothing was seen an offset may have gone on as it went before
    slopes = np.hypot(*np.diff(curve, axis=0).T) / step
    speed = np.maximum(np.median(slopes), slopes[np.minimum(sample // step, slopes.size - 1)])
    after = np.searchsorted(centre, sample)
    before, behind = centre[np.maximum(after - 1, 0)], centre[np.minimum(after, centre.size - 1)]
    return offset, speed * np.minimum(np.abs(sample - before), np.abs(sample - behind))


def _curve(
    centre: IntArray, mean: ComplexArray, step: int, half: int, n_samples: int
) -> tuple[IntArray, FloatArray, float]:
    """Return knots, the curve's X and Y at them, shape (n_knots, 2), and the root mean square of what it misses."""
    knots = np.arange(0, n_samples + step, step)
    place, share = np.divmod(centre / step, 1.0)
    rows, place = np.arange(centre.size), place.astype(np.intp)
    design = np.zeros((centre.size, knots.size))
    design[rows, place], design[rows, np.minimum(place + 1, knots.size - 1)] = 1.0 - share, share
    normal, frames = design.T @ design, step / half
    # curvature costs as much as the frames between two knots; slope a little, so that the ends do not run away
    for order, cost in ((2, frames), (1, 0.01 * frames)):
        if knots.size > order:
            difference = np.diff(np.eye(knots.size), order, axis=0)
            normal += cost * difference.T @ difference
    bands = [np.pad(np.diagonal(normal, k), (k, 0)) for k in range(min(3, knots.size))]
    value = np.stack([mean.real, mean.imag], axis=1)
    curve = solveh_banded(np.array(bands[::-1]), design.T @ value)
    return knots, curve, float(np.sqrt(np.mean((design @ curve - value) ** 2)))
