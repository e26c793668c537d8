"""Statistics of repeated values: mean, scatter against the stated uncertainties, and what stands out."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.rounding import concise, plain, quantity

CONFIDENCE = 0.95
"""Of every interval stated (Student's t, two-sided)."""
OUTLIER_LEVEL = 0.01
"""Share of clean series in which the test for outliers flags one: what ISO 5725-2 calls an outlier."""
OUTLIER_RULE = "generalised ESD test at 1 % (Rosner 1983; for one suspect Grubbs' test)"


def student(dof: float) -> float:
    """Return the factor of a two-sided 95 % interval of Student's t; infinite without a degree of freedom."""
    from scipy.special import stdtrit

    return float(stdtrit(dof, 0.5 + 0.5 * CONFIDENCE)) if dof > 0.0 else math.inf


@dataclass(frozen=True, slots=True)
class Consistency:
    """Scatter of values against their own statistical uncertainties.

    Attributes
    ----------
    weighted_mean
        Weights 1 / u^2.
    u_weighted_mean
        1 / sqrt(sum of weights), times the Birge ratio where that is above 1.
    chi2, degrees_of_freedom, p
        Sum of ((x - weighted mean) / u)^2, n - 1, and how often chance alone gives as much or more.
    birge_ratio
        sqrt(chi2 / (n - 1)), 1 where the scatter is as large as stated (Birge 1932).
    """

    weighted_mean: float
    u_weighted_mean: float
    chi2: float
    degrees_of_freedom: int
    p: float
    birge_ratio: float

    @property
    def words(self) -> str:
        """What the comparison says."""
        said = "as large as the stated uncertainties"
        if self.p < 1.0 - CONFIDENCE:
            said = "larger than the stated uncertainties: the drops themselves differ, or u is too small"
        elif self.p > CONFIDENCE:
            said = "smaller than the stated uncertainties"
        return (
            f"The scatter is {said} (χ² = {self.chi2:.3g} of {freedom(self.degrees_of_freedom)}, "
            f"p {probability(self.p)}, Birge ratio {self.birge_ratio:.2f})"
        )


@dataclass(frozen=True, slots=True)
class Statistics:
    """Of n repeated values, in their unit.

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
    u_single
        Standard uncertainty of the only value, for n = 1; None where there is none.
    combined
        Of the mean, with what all runs on one setup share: calibration and sphere do not average out. None where the
        runs do not say it.
    shared
        That part alone.
    interval_low, interval_high
        95 % of the mean from the scatter alone, Student's t with n - 1: what compares with another mean on the same
        setup. None for n < 2.
    expanded
        Half of the 95 % interval with the shared part, t of Welch and Satterthwaite's degrees of freedom times
        `combined` (GUM G.4.1). None where `combined` or the scatter is.
    consistency
        Scatter against the stated uncertainties; None where not all are known, or n < 2.
    outliers
        Places of the values that stand out by `OUTLIER_RULE`, counted from 0 among those given. They stay in the mean.
    """

    n: int
    mean: float | None = None
    standard_deviation: float | None = None
    standard_error: float | None = None
    u_single: float | None = None
    combined: float | None = None
    shared: float | None = None
    interval_low: float | None = None
    interval_high: float | None = None
    expanded: float | None = None
    consistency: Consistency | None = None
    outliers: tuple[int, ...] = ()

    @property
    def u(self) -> float | None:
        """Standard uncertainty that stands behind the mean: combined where it is known, else the standard error."""
        own = self.u_single if self.standard_error is None else self.standard_error
        return own if self.combined is None else self.combined

    def words(self) -> str:
        """Return the mean with its uncertainty `u`."""
        return quantity(self.mean, self.u)

    def brief(self) -> str:
        """Return the same in the concise form, 0.8012(23)."""
        return concise(self.mean, self.u)


NO_VALUE = Statistics(0)  # of no values


def statistics_of(
    values: Iterable[float | None], uncertainties: Iterable[float | None] = (), combined: Iterable[float | None] = ()
) -> Statistics:
    """Return the statistics of the values that are known and finite.

    Parameters
    ----------
    values
        One a run.
    uncertainties, combined
        Their statistical and their combined standard uncertainties, as many, or none.
    """
    given = list(values)
    rows = zip(given, [*uncertainties] or [None] * len(given), [*combined] or [None] * len(given), strict=True)
    known = [(place, *row) for place, row in enumerate(rows) if row[0] is not None and math.isfinite(row[0])]
    if not known:
        return NO_VALUE
    array = np.array([x for _, x, _, _ in known], dtype=np.float64)
    mean = float(array.mean())
    own = [u for _, _, u, _ in known if u is not None and u > 0.0]
    # fully correlated between runs on one setup: the shares add, not their squares (JCGM 100, 5.2.2, note 1)
    parts = [math.sqrt(max(both**2 - u**2, 0.0)) for *_, u, both in known if u is not None and both is not None]
    shared = sum(parts) / len(parts) if len(parts) == len(known) else None
    n = int(array.size)
    if n == 1:
        return Statistics(1, mean, u_single=known[0][2], combined=known[0][3], shared=shared)
    # type A: the scatter between drops, whatever each says of itself (GUM 4.2.2)
    deviation = float(array.std(ddof=1))
    error = deviation / math.sqrt(n)
    half = student(n - 1) * error
    whole = None if shared is None else math.hypot(error, shared)
    # Welch and Satterthwaite: the shared part counts as exactly known (GUM G.4.2)
    dof = (n - 1) * (whole / error) ** 4 if whole is not None and error else math.inf
    return Statistics(
        n,
        mean,
        deviation,
        error,
        combined=whole,
        shared=shared,
        interval_low=mean - half,
        interval_high=mean + half,
        expanded=None if whole is None else student(min(dof, 1e9)) * whole,
        consistency=_consistency(array, np.array(own)) if len(own) == n else None,
        outliers=tuple(known[place][0] for place in outliers_of(array)),
    )


def _consistency(values: FloatArray, u: FloatArray) -> Consistency:
    from scipy.special import chdtrc

    weights = u**-2.0
    mean = float(np.average(values, weights=weights))
    chi2, dof = float(np.sum(weights * (values - mean) ** 2)), values.size - 1
    ratio = math.sqrt(chi2 / dof)
    widened = max(ratio, 1.0) / math.sqrt(float(weights.sum()))
    return Consistency(mean, widened, chi2, dof, float(chdtrc(dof, chi2)), ratio)


def outliers_of(values: FloatArray, level: float = OUTLIER_LEVEL) -> tuple[int, ...]:
    """Return the places of the values that stand out, the farthest first.

    Rosner's generalised extreme studentised deviate for at most a fifth of them: one hidden by another is found
    (Technometrics 25, 165, 1983; NIST/SEMATECH e-Handbook 1.3.5.17.3). With one suspect it is Grubbs' test.

    Parameters
    ----------
    values
        Shape (n,), finite; of fewer than three none stands out.
    level
        Share of clean series in which one is found.
    """
    from scipy.special import stdtrit

    left, removed, found = list(range(values.size)), [], 0
    for _ in range(max(1, values.size // 5)):
        m, x = len(left), values[left]
        deviation = float(x.std(ddof=1)) if m > 2 else 0.0
        # differences of rounding are no scatter
        if deviation <= 1e-12 * float(np.abs(x).max(initial=0.0)):
            break
        distance = np.abs(x - x.mean()) / deviation
        # two-sided, and any of the m may be it (Bonferroni)
        t = float(stdtrit(m - 2, 1.0 - level / (2.0 * m)))
        removed.append(left.pop(int(distance.argmax())))
        if distance.max() > (m - 1) * t / math.sqrt((m - 2 + t * t) * m):
            found = len(removed)
    return tuple(removed[:found])


def freedom(degrees: int) -> str:
    """Return so many degrees of freedom in words."""
    return f"{degrees} degree{'' if degrees == 1 else 's'} of freedom"


def probability(p: float) -> str:
    """Return what stands behind the letter of a p-value, two digits: "= 0.030", "< 0.0001", "> 0.99"."""
    # no test tells that something is certain
    return "< 0.0001" if p < 1e-4 else "> 0.99" if p >= 0.995 else f"= {plain(p, 2)}"
