"""A series of drops: which of them count, how they are numbered, and the statistics of what they gave."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from radargui.model.drop import Drop, RunKind, RunOrigin
from radargui.model.rounding import UNKNOWN
from radargui.restitution.statistics import NO_VALUE, Statistics, statistics_of

KINDS: tuple[RunKind, ...] = ("measured", "simulated", "replay")
"""From the best: a series is of one kind, the best that it has; a replay is no measurement, and a simulation none."""


PRELIMINARY = "the final result is still to be computed"
"""Why a drop does not count that has only a preliminary result."""


@dataclass(frozen=True, slots=True)
class Series:
    """What a series gave: means of final results alone.

    Attributes
    ----------
    kind
        Of the drops that count; None without any.
    left_out
        Drops that do not count, by name, each with the reason.
    e, g_m_s2, drop_height_m, impact_speed_m_s
        Over the drops that count and whose release was seen: of the first bounce, of the fall.
    seen
        Names of these drops.
    outliers
        Names of those whose e stands out, see `statistics.OUTLIER_RULE`; they count like the others.
    mark
        What is said of drops that are no measurements, see `RunOrigin`; empty of measured ones.
    """

    kind: RunKind | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)
    e: Statistics = NO_VALUE
    g_m_s2: Statistics = NO_VALUE
    drop_height_m: Statistics = NO_VALUE
    impact_speed_m_s: Statistics = NO_VALUE
    seen: tuple[str, ...] = ()
    outliers: tuple[str, ...] = ()
    mark: str = ""

    @property
    def words(self) -> str:
        """What people read: the mean of e, of how many drops, and how many were left out."""
        many = f"mean of {self.e.n} drops" if self.e.n > 1 else "1 drop"
        said = f"{self.e.words()} ({many})" if self.e.n else ""
        n_preliminary = sum(why == PRELIMINARY for why in self.left_out.values())
        preliminary = f"{n_preliminary} preliminary" if n_preliminary else ""
        n_left = len(self.left_out) - n_preliminary
        return ", ".join(filter(None, (said, self.mark, preliminary, f"{n_left} left out" if n_left else "")))


def series_of(drops: Sequence[Drop]) -> Series:
    """Return the statistics of a series: of the best kind of its drops, each drop once.

    Parameters
    ----------
    drops
        In order, without those that were set aside.
    """
    kinds = {drop.origin.kind for drop in drops}
    # a file that cannot be read says nothing of the others
    kind = next((one for one in KINDS if one in kinds), "measured" if kinds else None)
    left_out: dict[str, str] = {}
    counted: list[Drop] = []
    for drop in drops:
        # a file imported or played twice would make the standard error smaller than it is
        twin = next((one for one in counted if one.origin.is_same_drop(drop.origin)), None)
        if drop.origin.kind not in (kind, "unknown"):
            left_out[drop.name] = "a replay is no drop of its own" if drop.origin.kind == "replay" else "simulated"
        elif twin is not None:
            left_out[drop.name] = f"the same drop as {twin.name}"
        elif drop.preliminary:
            # its u holds less than that of the final result, which would make the mean look better than it is
            left_out[drop.name] = PRELIMINARY
        else:
            counted.append(drop)
    # without the rest before it the first impact seen may be the third, and e depends on the speed
    seen = [drop for drop in counted if drop.from_rest]

    def of(*names: str) -> Statistics:
        """Return the statistics of a value of the drops, by its name and those of its u."""
        return statistics_of(*([getattr(one, name) for one in seen] for name in names))

    e, g = of("e", "u_e", "u_e_combined"), of("g_m_s2", "u_g_m_s2", "u_g_combined_m_s2")
    names = tuple(drop.name for drop in seen)
    outliers = tuple(names[place] for place in e.outliers)
    mark = ", ".join(dict.fromkeys(drop.origin.mark for drop in drops if drop.origin.kind == kind and drop.origin.mark))
    return Series(kind, left_out, e, g, of("drop_height_m"), of("impact_speed_m_s"), names, outliers, mark)


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
