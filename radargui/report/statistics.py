"""Statistics of a series of runs: mean, scatter and how well the mean is known."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Statistics:
    """Of n repeated values.

    Attributes
    ----------
    n
        How many runs gave a value.
    mean
        Arithmetic mean; None for n = 0.
    standard_deviation
        Of one value, with n - 1; None for n < 2.
    standard_error
        Of the mean, standard deviation / sqrt(n) (GUM 4.2.3); None for n < 2.
    """

    n: int
    mean: float | None = None
    standard_deviation: float | None = None
    standard_error: float | None = None


def statistics_of(values: Iterable[float | None]) -> Statistics:
    """Return the statistics of the values that are known and finite."""
    known = np.array([value for value in values if value is not None and math.isfinite(value)], dtype=np.float64)
    if known.size == 0:
        return Statistics(0)
    mean = float(known.mean())
    if known.size == 1:
        return Statistics(1, mean)
    deviation = float(known.std(ddof=1))
    return Statistics(int(known.size), mean, deviation, deviation / math.sqrt(known.size))
