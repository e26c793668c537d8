"""How e of the drops of a series is distributed: quantiles, skewness, histogram, density, where the next one lies."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from radargui.model.rounding import plain
from radargui.restitution.statistics import student

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)
"""Shares of the drops below the quantiles that are told."""
_FEWEST = 4
"""A skewness and its standard error want three values; a shape wants more than it has parameters."""
_MAX_BINS = 40  # one value far away would want thousands of the width that suits the others
_POINTS, _REACH = 121, 3.0
"""Of the density: places, and how many widths of a kernel beyond the outermost values."""


@dataclass(frozen=True, slots=True)
class Distribution:
    """Of e of n drops, the first impact of each.

    Attributes
    ----------
    n
        How many drops.
    quantiles
        At `LEVELS`, median unbiased whatever the distribution (Hyndman & Fan, Am. Stat. 50, 361, 1996, type 8).
    skewness, u_skewness
        Adjusted Fisher-Pearson coefficient G1, and its standard error of n normal values (Joanes & Gill, The
        Statistician 47, 183, 1998).
    edges, counts
        Histogram by numpy's rule `auto`, shapes (n_bins + 1,) and (n_bins,).
    at, density
        p(e) by Gaussian kernels of Silverman's width (Density Estimation, 1986, eq. 3.31), shape (m,).
    prediction_low, prediction_high
        Where e of one more drop lies with 95 % if e is normal: mean ± t s sqrt(1 + 1/n).
    measured
        Root mean square of the stated statistical u: as much of the scatter is the measurement's. None where a drop
        does not say it.
    """

    n: int
    quantiles: tuple[float, ...]
    skewness: float
    u_skewness: float
    edges: tuple[float, ...]
    counts: tuple[int, ...]
    at: tuple[float, ...]
    density: tuple[float, ...]
    prediction_low: float
    prediction_high: float
    measured: float | None

    @property
    def words(self) -> str:
        """What is said of it in one sentence."""
        places = max(0, 2 - math.floor(math.log10(self.prediction_high - self.prediction_low)))
        low, first, median, third, high = (f"{one:.{places}f}" for one in self.quantiles)
        lean = "skewed" if abs(self.skewness) > 2.0 * self.u_skewness else "not skewed beyond chance"
        own = "" if self.measured is None else f"; u of each {plain(self.measured, 2)}"
        return (
            f"median {median}, quartiles {first} and {third}, 5 and 95 % {low} and {high}; skewness "
            f"{self.skewness:+.2f} ± {self.u_skewness:.2f} ({lean}); one more drop with 95 % from "
            f"{self.prediction_low:.{places}f} to {self.prediction_high:.{places}f}{own}"
        )


def distribution_of(values: Iterable[float | None], u: Iterable[float | None] = ()) -> Distribution | None:
    """Return how values that are known are distributed; None of fewer than four, or of equal ones.

    Parameters
    ----------
    values
        One a drop.
    u
        Their statistical standard uncertainties, as many, or none.
    """
    given = list(values)
    pairs = [
        (x, own)
        for x, own in zip(given, [*u] or [None] * len(given), strict=True)
        if x is not None and math.isfinite(x)
    ]
    x, n = np.array([one for one, _ in pairs], dtype=np.float64), len(pairs)
    deviation = float(x.std(ddof=1)) if n >= _FEWEST else 0.0
    # differences of rounding have no shape
    if deviation <= 1e-12 * float(np.abs(x).max(initial=0.0)):
        return None
    centred = x - x.mean()
    g1 = float((centred**3).mean() / (centred**2).mean() ** 1.5)
    quantiles = np.quantile(x, LEVELS, method="median_unbiased")
    edges = np.histogram_bin_edges(x, "auto")
    counts, edges = np.histogram(x, min(edges.size - 1, _MAX_BINS))
    quarters = float(np.subtract(*np.quantile(x, (0.75, 0.25)))) / 1.34
    width = 0.9 * (min(deviation, quarters) or deviation) * n**-0.2
    at = np.linspace(x.min() - _REACH * width, x.max() + _REACH * width, _POINTS)
    kernels = np.exp(-0.5 * ((at[:, None] - x) / width) ** 2)
    half = student(n - 1) * deviation * math.sqrt(1.0 + 1.0 / n)
    own = [one for _, one in pairs if one is not None and math.isfinite(one)]
    return Distribution(
        n,
        tuple(quantiles.tolist()),
        math.sqrt(n * (n - 1.0)) / (n - 2.0) * g1,
        math.sqrt(6.0 * n * (n - 1.0) / ((n - 2.0) * (n + 1.0) * (n + 3.0))),
        tuple(edges.tolist()),
        tuple(counts.tolist()),
        tuple(at.tolist()),
        tuple((kernels.mean(axis=1) / (width * math.sqrt(2.0 * math.pi))).tolist()),
        float(x.mean()) - half,
        float(x.mean()) + half,
        math.sqrt(float(np.mean(np.square(own)))) if len(own) == n else None,
    )
