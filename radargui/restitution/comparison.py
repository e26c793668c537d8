"""Groups of drops against each other: do samples differ, and how well do sessions repeat each other."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from radargui.restitution.statistics import CONFIDENCE, probability, student


@dataclass(frozen=True, slots=True)
class Comparison:
    """Means of groups compared, without the assumption that all scatter alike.

    Attributes
    ----------
    groups
        Names, each with at least two drops.
    test
        What was tested: Welch's t-test of two groups, Welch's analysis of variance of more (Welch 1947, 1951).
    statistic, p
        t or F, and how often groups with one mean give as much or more.
    scatter_p
        Of Levene's test about the medians (Brown & Forsythe 1974): whether the groups scatter alike; None where pairs
        cannot tell.
    difference, difference_low, difference_high
        First less second of two groups, and its 95 % interval; None for more.
    """

    groups: tuple[str, ...]
    test: str
    statistic: float
    p: float
    scatter_p: float | None
    difference: float | None = None
    difference_low: float | None = None
    difference_high: float | None = None

    @property
    def differ(self) -> bool:
        """Whether the means differ at 5 %."""
        return self.p < 1.0 - CONFIDENCE

    @property
    def words(self) -> str:
        """What the test says."""
        said = "differ" if self.differ else "are not shown to differ"
        alike = "" if self.scatter_p is None else f"; equal scatter, Levene: p {probability(self.scatter_p)}"
        letter = "t" if self.difference is not None else "F"
        return (
            f"The means of {', '.join(self.groups)} {said} at 5 % ({self.test}: {letter} = {self.statistic:.3g}, "
            f"p {probability(self.p)}{alike})"
        )


def compare(groups: Mapping[str, Sequence[float]]) -> Comparison | None:
    """Return the comparison of e of groups by name; None with fewer than two groups of two, or without any scatter.

    It compares scatters: what the groups share (the calibration, on one setup) is in no group's scatter.
    """
    known = {name: np.asarray(values, dtype=np.float64) for name, values in groups.items() if len(values) > 1}
    if len(known) < 2 or any(np.ptp(values) == 0.0 for values in known.values()):
        return None
    # a second of loading that nobody else needs
    from scipy.stats import f_oneway, levene, ttest_ind

    # both values of a pair are as far from its median
    with np.errstate(invalid="ignore", divide="ignore"):
        levenes = float(levene(*known.values()).pvalue)
    scatter_p = levenes if math.isfinite(levenes) else None
    apart: tuple[float, ...] = ()
    if len(known) > 2:
        test, found = "Welch's analysis of variance", f_oneway(*known.values(), equal_var=False)
    else:
        first, second = known.values()
        test, found = "Welch's t-test", ttest_ind(first, second, equal_var=False)
        apart = (float(first.mean() - second.mean()), *map(float, found.confidence_interval(CONFIDENCE)))
    return Comparison(tuple(known), test, float(found.statistic), float(found.pvalue), scatter_p, *apart)


@dataclass(frozen=True, slots=True)
class Repeatability:
    """Scatter within and between sessions, in the unit of the values: one-way random model (ISO 5725-2:2019, 7.4).

    Attributes
    ----------
    n_groups, n
        Sessions and drops.
    repeatability_sd
        s_r, of drops of one session.
    between_sd
        s_L, of the sessions beside it; 0 where the sessions differ no more than their drops let expect.
    reproducibility_sd
        s_R = sqrt(s_r^2 + s_L^2), of one drop in any session.
    f, p
        Mean square between over within, and how often sessions without a scatter of their own give as much or more.
    mean, u_mean, interval_low, interval_high
        Mean of the sessions' means, its standard error from their scatter, and 95 % by Student's t with one degree of
        freedom fewer than sessions.
    """

    n_groups: int
    n: int
    repeatability_sd: float
    between_sd: float
    reproducibility_sd: float
    f: float
    p: float
    mean: float
    u_mean: float
    interval_low: float
    interval_high: float


def repeatability_of(groups: Sequence[Sequence[float]]) -> Repeatability | None:
    """Return the scatter within and between groups; None with fewer than two groups or without repeated drops."""
    known = [np.asarray(values, dtype=np.float64) for values in groups if len(values)]
    k, sizes = len(known), np.array([values.size for values in known])
    n = int(sizes.sum())
    if k < 2 or n <= k:
        return None
    means = np.array([values.mean() for values in known])
    from scipy.special import fdtrc

    within = sum(float(np.sum((values - values.mean()) ** 2)) for values in known) / (n - k)
    between = float(np.sum(sizes * (means - np.average(means, weights=sizes)) ** 2)) / (k - 1)
    # drops of a session as they count where not all have equally many
    size = (n - float(np.sum(sizes**2)) / n) / (k - 1)
    # below zero by chance alone: then there is none (ISO 5725-2)
    own = max(between - within, 0.0) / size
    f = between / within if within else math.inf
    # of the sessions' means: drops of one day share what differs from day to day
    u = float(means.std(ddof=1)) / math.sqrt(k)
    mean, half, p = float(means.mean()), student(k - 1) * u, float(fdtrc(k - 1, n - k, f))
    repeated, apart, reproduced = (math.sqrt(variance) for variance in (within, own, within + own))
    return Repeatability(k, n, repeated, apart, reproduced, f, p, mean, u, mean - half, mean + half)
