"""What is wrong with a score though nothing was said of it."""

from __future__ import annotations

from benchmarks.scoring.laboratory import Figure, Score

WRONG_U = 3.0


def wrong(one: Score) -> tuple[str, ...]:
    """Return what is off by more than three u, and impacts that are missed or false; each in a few words."""
    found = []
    ratio = one.ratio if one.ratio_combined is None else one.ratio_combined
    if ratio is not None and ratio > WRONG_U:
        found.append(f"track {ratio:.1f} u rms")
    worst = max((_in_u(figure) for figure in one.e), default=0.0)
    if worst > WRONG_U:
        found.append(f"e {worst:.1f} u")
    if one.g is not None and _in_u(one.g) > WRONG_U:
        found.append(f"g {_in_u(one.g):.1f} u")
    if one.missed:
        found.append(f"missed {one.missed}")
    if one.false:
        found.append(f"false {one.false}")
    return tuple(found)


def wrong_in_silence(one: Score) -> bool:
    """Whether something is wrong with a result called ok without any warning; whether a warning fits, people judge."""
    return one.status == "ok" and not one.warnings and bool(wrong(one))


def _in_u(figure: Figure) -> float:
    return abs(figure.in_u if figure.in_combined is None else figure.in_combined)
