"""Rates, medians and differences of populations, each with its 95 % interval."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

Z = 1.959964
"""97.5 % of a normal distribution lie below."""
RESAMPLES = 2000
SEED = 41
"""Of the resampling alone: the same scores give the same interval."""


class Estimate(NamedTuple):
    """A number and the ends of its 95 % interval; NaN where nothing is known."""

    value: float
    low: float
    high: float


UNKNOWN = Estimate(float("nan"), float("nan"), float("nan"))


def share(count: int, of: int) -> Estimate:
    """Return a share of independent scenes, with Wilson's interval (J. Am. Stat. Assoc. 22, 209, 1927)."""
    if not of:
        return UNKNOWN
    p, square = count / of, Z**2 / of
    middle = (p + square / 2.0) / (1.0 + square)
    half = Z * np.sqrt(p * (1.0 - p) / of + square / (4.0 * of)) / (1.0 + square)
    return Estimate(p, max(0.0, float(middle - half)), min(1.0, float(middle + half)))


def clustered_share(hits: ArrayLike, of: ArrayLike) -> Estimate:
    """Return a share of values of which those of one scene hang together: scenes are drawn anew, never their values.

    Where all hit, or none, drawing anew says nothing: then each scene counts as one value of a Wilson interval.

    Parameters
    ----------
    hits, of
        How many values of each scene hit, and how many it has (or shares, and ones), shape (n_scenes,).
    """
    hits, of = np.asarray(hits, float), np.asarray(of, float)
    if not of.sum():
        return UNKNOWN
    if hits.sum() in (0.0, of.sum()):
        n_scenes = int((of > 0.0).sum())
        return share(n_scenes if hits.sum() else 0, n_scenes)
    weights = _times_drawn(hits.size)
    with np.errstate(invalid="ignore"):
        each = (weights @ hits) / (weights @ of)
    return Estimate(float(hits.sum() / of.sum()), *_ends(each))


def quantile(values: ArrayLike, q: float, scene: ArrayLike | None = None) -> Estimate:
    """Return a quantile of values, with its bootstrap interval.

    Parameters
    ----------
    values
        Shape (n,); NaN where there is none.
    q
        0.5: the median.
    scene
        To which of the scenes 0, 1, ... each belongs, shape (n,); None: one value a scene.
    """
    rows, weights = _drawn(scene, values)
    if not rows.size:
        return UNKNOWN
    return Estimate(float(np.quantile(rows[0], q)), *_ends(_weighted_quantile(rows[0], q, weights)))


def ratio_of_medians(above: ArrayLike, below: ArrayLike, scene: ArrayLike | None = None) -> Estimate:
    """Return median(above) / median(below) of pairs of values, with its interval; `scene` as for `quantile`."""
    rows, weights = _drawn(scene, above, below)
    if not rows.size:
        return UNKNOWN
    each = _weighted_quantile(rows[0], 0.5, weights) / _weighted_quantile(rows[1], 0.5, weights)
    return Estimate(float(np.median(rows[0]) / np.median(rows[1])), *_ends(each))


def paired_difference(gained: int, lost: int, of: int) -> Estimate:
    """Return the difference of two shares of the same scenes, (gained - lost) / of.

    Interval of Agresti & Min (Stat. Med. 24, 729, 2005): half a scene is added to each cell of the table, so that it is
    no point where nothing changed.

    Parameters
    ----------
    gained, lost
        Scenes that hit in the first only, in the second only.
    of
        All scenes.
    """
    if not of:
        return UNKNOWN
    b, c, n = gained + 0.5, lost + 0.5, of + 2.0
    half = Z * np.sqrt(b + c - (b - c) ** 2 / n) / n
    middle = (b - c) / n
    return Estimate((gained - lost) / of, float(middle - half), float(middle + half))


def clustered_difference(differences: ArrayLike, of: ArrayLike) -> Estimate:
    """Return the difference of two shares of the same values, of which those of one session hang together.

    Parameters
    ----------
    differences, of
        How many more values of each session hit in the first than in the second, and how many it has, shape (n,).
    """
    differences, of = np.asarray(differences, float), np.asarray(of, float)
    if not differences.any():
        return paired_difference(0, 0, int((of > 0.0).sum()))
    weights = _times_drawn(of.size)
    return Estimate(float(differences.sum() / of.sum()), *_ends((weights @ differences) / (weights @ of)))


def _drawn(scene: ArrayLike | None, *values: ArrayLike) -> tuple[Array, Array]:
    """Return the values that are known, (k, n), and how often each is drawn, (RESAMPLES, n)."""
    rows = np.stack([np.asarray(one, float) for one in values])
    known = np.isfinite(rows).all(axis=0)
    of = np.arange(rows.shape[1]) if scene is None else np.asarray(scene)
    _, place = np.unique(of[known], return_inverse=True)
    if not known.any():
        return rows[:, known], np.zeros((0, 0))
    return rows[:, known], _times_drawn(int(place.max()) + 1)[:, place]


def _weighted_quantile(values: Array, q: float, weights: Array) -> Array:
    """Return the least value below or at which lies a share q of the weight, for each row of weights."""
    order = np.argsort(values)
    below = np.cumsum(weights[:, order], axis=1)
    return np.asarray(values[order][np.argmax(below >= q * below[:, -1:], axis=1)])


def _times_drawn(n: int) -> Array:
    return np.random.default_rng(SEED).multinomial(n, np.full(n, 1.0 / n), RESAMPLES).astype(float)


def _ends(each: Array) -> Sequence[float]:
    low, high = np.nanquantile(each, (0.025, 0.975))
    return float(low), float(high)
