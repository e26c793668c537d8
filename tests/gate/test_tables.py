"""Tables of populations, and what makes a version not worse."""

from __future__ import annotations

from dataclasses import replace

import pytest
from benchmarks.gate.score import Score, Value
from benchmarks.gate.tables import compared, comparison, tables

RIGHT = Score(
    "ok", "", (), None, "ok", frozenset({"walls"}), 1.0, 1e-4, 1e-4, 1.0, 2e-4, 1e-4, Value(0.8001, 2e-4, 0.8),
    (Value(0.8001, 2e-4, 0.8),), Value(9.81, 0.01, 9.809), seconds=2.0,
)  # fmt: skip
SILENT = replace(RIGHT, track_error_m=1e-3)
REFUSED = replace(RIGHT, status="rejected", reason="one cable on both")
N = 300


def off(**changes: object) -> list[list[Score]]:
    return [[replace(RIGHT, **changes)]] * N


def test_a_population_is_counted() -> None:
    text = tables({"modelled": [[RIGHT]] * 6 + [[SILENT]] * 3 + [[REFUSED]]})
    counts, coverage, errors = (block.splitlines()[-1] for block in text.split("\n\n"))
    assert counts.startswith("| modelled | 10 | 60.0 (31.3 to 83.2) | 0.0 (0.0 to 27.8) | 0.0 ")
    assert "| 30.0 (10.8 to 60.3) | 10.0 (1.8 to 40.4) | 0 / 1 / 0 |" in counts
    assert coverage.startswith("| modelled | 100.0 (")
    assert "| 2.00 (2.00 to 2.00) |" in coverage
    assert "| 0.0125 (0.0125 to 0.0125) |" in errors


def test_the_same_results_are_not_worse() -> None:
    same = compared([[RIGHT]] * N, [[RIGHT]] * N)
    assert same.fails == ()
    assert same.right.low > -0.01
    assert "modelled: not worse" in comparison({"modelled": same}, "new", "old")


@pytest.mark.parametrize(
    ("new", "fails"),
    [
        ([[RIGHT]] * (N - 15) + [[REFUSED]] * 15, ("right",)),
        ([[RIGHT]] * (N - 3) + [[REFUSED]] * 3, ()),
        ([[RIGHT]] * (N - 2) + [[SILENT]] * 2, ("SILENT",)),
        ([[RIGHT]] * (N - 1) + [[SILENT]], ()),
        (off(shape_m=1.06e-4), ("shape, mm: median",)),
        (off(shape_m=1.04e-4, place_m=1e-4), ()),
        (off(first_e=Value(0.8002, 2e-4, 0.8)), ("first e, %: median",)),
    ],
)
def test_what_is_worse_is_named(new: list[list[Score]], fails: tuple[str, ...]) -> None:
    assert compared(new, [[RIGHT]] * N).fails == fails


def test_a_few_scenes_show_nothing() -> None:
    assert compared([[RIGHT]] * 10, [[RIGHT]] * 10).fails == ("right",)


def test_drops_of_a_session_count_as_sessions() -> None:
    old = [[RIGHT] * 10] * 30
    new = [*old[:28], *[[REFUSED] * 10] * 2]
    together = compared(new, old).right
    alone = compared([[one] for scene in new for one in scene], [[one] for scene in old for one in scene]).right
    assert together.value == alone.value == pytest.approx(-20 / 300)
    assert together.high - together.low > 2.0 * (alone.high - alone.low)


def test_changes_are_listed() -> None:
    text = comparison({"modelled": compared([[REFUSED]] * 2 + [[RIGHT]], [[RIGHT]] * 3)}, "new", "old")
    assert "  2 were right, are refused" in text
