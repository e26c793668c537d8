"""What a population says, as Markdown: rates, coverage, errors, times; and two versions beside one another."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from benchmarks.gate.score import OUTCOMES, Score, Value
from benchmarks.gate.statistics import (
    Estimate,
    clustered_difference,
    clustered_share,
    paired_difference,
    quantile,
    ratio_of_medians,
    share,
)

T = TypeVar("T")
Scenes = Sequence[Sequence[Score]]
"""Scores of a population: of each scene one, or those of the drops of each session."""
SHARP = 1.48
"""Median of |error| is 0.67 u of a normal distribution."""
MIN_RIGHT, MAX_SILENT, MAX_ERROR = -0.03, 1, 1.05
"""Not worse: right within 3 points for sure, one silent scene more, medians of errors 5 % larger."""


def tables(populations: Mapping[str, Scenes]) -> str:
    """Return three tables, a row a population: what scenes count as, what lies inside 2u, how large errors are."""
    return "\n\n".join((_counts(populations), _coverage(populations), _errors(populations)))


def _counts(populations: Mapping[str, Scenes]) -> str:
    header = (
        "%",
        "n",
        *OUTCOMES,
        "refused blaming right / wrong / nothing",
        "right, but warned of",
        "missed, invented",
        "converged",
    )
    rows = []
    for name, scenes in populations.items():
        all_ = _flat(scenes)
        refused = Counter(one.blames for one in all_ if one.outcome == "refused")
        rows.append(
            (
                name,
                str(len(all_)),
                *(_percent(_share(scenes, lambda one, wanted=wanted: one.outcome == wanted)) for wanted in OUTCOMES),
                " / ".join(str(refused[blamed]) for blamed in ("right", "wrong", "nothing")),
                _percent(_share(scenes, lambda one: one.outcome == "right" and one.status == "ok" and one.warned)),
                f"{sum(one.missed for one in all_)}, {sum(one.invented for one in all_)}",
                "-" if None in (one.converged for one in all_) else _percent(_share(scenes, lambda one: one.converged)),
            )
        )
    return _table(header, rows)


def _coverage(populations: Mapping[str, Scenes]) -> str:
    header = ("inside 2u, %", "e", "of", "g", "of", "track", "of", f"u over error of the first e ({SHARP} is sharp)")
    rows = []
    for name, scenes in populations.items():
        e = [[value for one in scene for value in one.e] for scene in scenes]
        g = [[one.g for one in scene if one.g is not None] for scene in scenes]
        track = [[one.track_inside_2u for one in scene if one.track_inside_2u is not None] for scene in scenes]
        first, scene_of = _values(scenes, lambda one: one.first_e)
        rows.append(
            (
                name,
                *_inside(e),
                *_inside(g),
                _percent(clustered_share([sum(one) for one in track], [len(one) for one in track])),
                str(sum(map(len, track))),
                _number(ratio_of_medians([v.u for v in first], [abs(v.error) for v in first], scene_of), 2),
            )
        )
    return _table(header, rows)


def _inside(values: Sequence[Sequence[Value]]) -> tuple[str, str]:
    hits = [sum(abs(one.in_u) <= 2.0 for one in scene) for scene in values]
    return _percent(clustered_share(hits, [len(one) for one in values])), str(sum(map(len, values)))


ERRORS: Mapping[str, tuple[Callable[[Score], float | None], int]] = {
    "first e, %": (lambda one: one.first_e and 100.0 * abs(one.first_e.error / one.first_e.truth), 4),
    "place, mm": (lambda one: one.place_m and 1e3 * one.place_m, 3),
    "shape, mm": (lambda one: one.shape_m and 1e3 * one.shape_m, 4),
}
"""Of results called ok, and how many decimals they have."""


def _errors(populations: Mapping[str, Scenes]) -> str:
    header = (
        "error",
        *(f"{name}: {which}" for name in ERRORS for which in ("median", "90 %")),
        *(f"processor time, s: {which}" for which in ("median", "95 %", "worst")),
    )
    rows = []
    for name, scenes in populations.items():
        row = [name]
        for of_score, digits in ERRORS.values():
            values, scene_of = _values(scenes, of_score)
            row += [_number(quantile(values, q, scene_of), digits) for q in (0.5, 0.9)]
        seconds, scene_of = _values(scenes, _seconds)
        row += [_number(quantile(seconds, q, scene_of), 1) for q in (0.5, 0.95)]
        rows.append((*row, f"{max(seconds, default=float('nan')):.1f}"))
    return _table(header, rows)


def _seconds(one: Score) -> float | None:
    return one.seconds or None


@dataclass(frozen=True)
class Comparison:
    """A version against another on the same scenes.

    Attributes
    ----------
    right, silent
        Differences of their shares.
    more_silent
        The same as a number of scenes.
    errors
        Ratios of medians, by name, of scenes of which both tell it.
    time
        Ratio of the medians of processor time.
    changed
        What the scenes counted as before and count as now, and how many.
    """

    right: Estimate
    silent: Estimate
    more_silent: int
    errors: Mapping[str, Estimate]
    time: Estimate
    changed: Mapping[tuple[str, str], int]

    @property
    def fails(self) -> tuple[str, ...]:
        """What is worse, or not shown to be not worse; empty where nothing is."""
        errors = [f"{name}: median" for name, ratio in self.errors.items() if ratio.value > MAX_ERROR]
        right = ["right"] if not self.right.low > MIN_RIGHT else []
        return (*right, *(["SILENT"] if self.more_silent > MAX_SILENT else []), *errors)


def compared(new: Scenes, old: Scenes) -> Comparison:
    """Return the paired differences of two versions' scores of the same scenes, in the same order."""
    pairs = [(n, *pair) for n, both in enumerate(zip(new, old, strict=True)) for pair in zip(*both, strict=True)]
    changed = Counter((before.outcome, now.outcome) for _, now, before in pairs if now.outcome != before.outcome)
    is_single = all(len(scene) == 1 for scene in new)

    def difference(outcome: str) -> Estimate:
        gained = sum(count for (_, now), count in changed.items() if now == outcome)
        lost = sum(count for (before, _), count in changed.items() if before == outcome)
        if is_single:
            return paired_difference(gained, lost, len(pairs))
        hits = [[sum(one.outcome == outcome for one in scene) for scene in scenes] for scenes in (new, old)]
        return clustered_difference(np.subtract(*hits), [len(scene) for scene in new])

    def ratio(of_score: Callable[[Score], float | None]) -> Estimate:
        both = [(of_score(now), of_score(before), n) for n, now, before in pairs]
        known = np.array([one for one in both if None not in one], float).reshape(-1, 3)
        return ratio_of_medians(*known.T)

    silent = Counter(one.outcome for one in _flat(new))["SILENT"] - Counter(one.outcome for one in _flat(old))["SILENT"]
    errors = {name: ratio(of_score) for name, (of_score, _) in ERRORS.items()}
    return Comparison(difference("right"), difference("SILENT"), silent, errors, ratio(_seconds), changed)


def comparison(each: Mapping[str, Comparison], new: str, old: str) -> str:
    """Return a table of comparisons, a row a population, and below it a verdict for each."""
    header = (
        f"{new} against {old}",
        "right, points",
        "SILENT, points",
        *(f"{name}: ratio of medians" for name in ERRORS),
        "processor time: ratio of medians",
    )
    rows = [
        (
            name,
            _percent(one.right, signed=True),
            f"{_percent(one.silent, signed=True)}, {one.more_silent:+d}",
            *(_number(ratio, 3) for ratio in one.errors.values()),
            _number(one.time, 3),
        )
        for name, one in each.items()
    ]
    lines = [_table(header, rows), ""]
    for name, one in each.items():
        lines.append(f"{name}: {'fails: ' + ', '.join(one.fails) if one.fails else 'not worse'}")
        lines += [f"  {count} were {was}, are {now}" for (was, now), count in sorted(one.changed.items())]
    return "\n".join(lines)


def _flat(scenes: Scenes) -> list[Score]:
    return [one for scene in scenes for one in scene]


def _share(scenes: Scenes, hits: Callable[[Score], bool]) -> Estimate:
    counts = [sum(map(hits, scene)) for scene in scenes]
    if all(len(scene) == 1 for scene in scenes):
        return share(sum(counts), len(counts))
    return clustered_share(counts, [len(scene) for scene in scenes])


def _values(scenes: Scenes, of_score: Callable[[Score], T | None]) -> tuple[list[T], list[int]]:
    """Return what is known of the scores, and of which scene each is."""
    known = [(value, n) for n, scene in enumerate(scenes) for one in scene if (value := of_score(one)) is not None]
    return [value for value, _ in known], [n for _, n in known]


def _percent(one: Estimate, *, signed: bool = False) -> str:
    sign = "+" if signed else ""
    if np.isnan(one.value):
        return "-"
    return f"{100 * one.value:{sign}.1f} ({100 * one.low:{sign}.1f} to {100 * one.high:{sign}.1f})"


def _number(one: Estimate, digits: int) -> str:
    if np.isnan(one.value):
        return "-"
    return f"{one.value:.{digits}f} ({one.low:.{digits}f} to {one.high:.{digits}f})"


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return "\n".join(_lines(header, rows))


def _lines(header: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield f"| {' | '.join(header)} |"
    yield "|---" * len(header) + "|"
    for row in rows:
        yield f"| {' | '.join(row)} |"
