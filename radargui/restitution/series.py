"""A series of drops: which of them count, how they are numbered, and the statistics of what they gave."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from radargui.model.drop import Drop, RunKind, RunOrigin
from radargui.model.rounding import UNKNOWN, quantity

KINDS: tuple[RunKind, ...] = ("measured", "simulated", "replay")
"""From the best: a series is of one kind, the best that it has; a replay is no measurement, and a simulation none."""


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
    u_single
        Standard uncertainty of the only value, for n = 1; None where there is none.
    combined
        Of the mean, with what all runs on one setup share: calibration and sphere do not average out. None where the
        runs do not say it.
    """

    n: int
    mean: float | None = None
    standard_deviation: float | None = None
    standard_error: float | None = None
    u_single: float | None = None
    combined: float | None = None

    def words(self, scale: float = 1.0) -> str:
        """Return the mean with its combined uncertainty; where that is not known the standard error, or its own."""
        u = self.u_single if self.standard_error is None else self.standard_error
        u = u if self.combined is None else self.combined
        return UNKNOWN if self.mean is None else quantity(self.mean, u, scale=scale)


def statistics_of(
    values: Iterable[float | None],
    uncertainties: Iterable[float | None] = (),
    combined: Iterable[float | None] = (),
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
    known = [row for row in rows if row[0] is not None and math.isfinite(row[0])]
    if not known:
        return Statistics(0)
    array = np.array([x for x, _, _ in known], dtype=np.float64)
    mean = float(array.mean())
    # fully correlated between runs on one setup: the shares add, not their squares (JCGM 100, 5.2.2, note 1)
    shared = [math.sqrt(max(both**2 - own**2, 0.0)) for _, own, both in known if own is not None and both is not None]
    common = sum(shared) / len(shared) if len(shared) == len(known) else None
    if array.size == 1:
        return Statistics(1, mean, u_single=known[0][1], combined=known[0][2])
    # type A: the scatter between drops, whatever each says of itself (GUM 4.2.2)
    deviation = float(array.std(ddof=1))
    error = deviation / math.sqrt(array.size)
    return Statistics(
        int(array.size), mean, deviation, error, combined=None if common is None else math.hypot(error, common)
    )


@dataclass(frozen=True, slots=True)
class Series:
    """What a series gave.

    Attributes
    ----------
    kind
        Of the drops that count; None without any.
    left_out
        Drops that do not count, by name, each with the reason.
    e, g_m_s2, drop_height_m
        Over the drops that count and whose release was seen: of the first bounce, of the fall.
    """

    kind: RunKind | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)
    e: Statistics = Statistics(0)
    g_m_s2: Statistics = Statistics(0)
    drop_height_m: Statistics = Statistics(0)

    @property
    def words(self) -> str:
        """What people read: the mean of e, of how many drops, and how many were left out."""
        many = f"mean of {self.e.n} drops" if self.e.n > 1 else "1 drop"
        said = f"{self.e.words()} ({many})" if self.e.n else ""
        mark = "" if self.kind in (None, "measured") else f"{self.kind}"
        left = f"{len(self.left_out)} left out" if self.left_out else ""
        return ", ".join(filter(None, (said, mark, left)))


def series_of(drops: Sequence[Drop]) -> Series:
    """Return the statistics of a series: of the best kind of its drops, each drop once.

    Parameters
    ----------
    drops
        In order, without those that were set aside.
    """
    kinds = {drop.origin.kind for drop in drops}
    kind = next((one for one in KINDS if one in kinds), None)
    left_out: dict[str, str] = {}
    counted: list[Drop] = []
    for drop in drops:
        # a file imported or played twice would make the standard error smaller than it is
        twin = next((one for one in counted if one.origin.is_same_drop(drop.origin)), None)
        if drop.origin.kind != kind:
            left_out[drop.name] = "a replay is no drop of its own" if drop.origin.kind == "replay" else "simulated"
        elif twin is not None:
            left_out[drop.name] = f"the same drop as {twin.name}"
        else:
            counted.append(drop)
    # without the rest before it the first impact seen may be the third, and e depends on the speed
    seen = [drop for drop in counted if drop.from_rest]
    return Series(
        kind,
        left_out,
        statistics_of([one.e for one in seen], [one.u_e for one in seen], [one.u_e_combined for one in seen]),
        statistics_of(
            [one.g_m_s2 for one in seen], [one.u_g_m_s2 for one in seen], [one.u_g_combined_m_s2 for one in seen]
        ),
        statistics_of([drop.drop_height_m for drop in seen]),
    )


def drop_labels(runs: Iterable[tuple[str, RunOrigin | None, bool]]) -> dict[str, str]:
    """Return what each run is called, by name: drops are counted from 1, replays apart, as R1, R2, ...

    Parameters
    ----------
    runs
        In the order of their numbers: name, origin (None where not known: counted as a drop), and whether it is a
        drop at all. One that is not has no number of its own.
    """
    labels: dict[str, str] = {}
    n_drops = n_replays = 0
    for name, origin, is_drop in runs:
        if not is_drop:
            labels[name] = UNKNOWN
        elif origin is not None and origin.kind == "replay":
            n_replays += 1
            labels[name] = f"R{n_replays}"
        else:
            n_drops += 1
            labels[name] = str(n_drops)
    return labels
