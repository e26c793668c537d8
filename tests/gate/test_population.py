"""Drops of ordinary laboratories, as files, through the public door: the rates that a version must keep.

They were drawn once, whatever comes of them: 24 by
`dev.py bench population -n 24 --hold rate_hz=10000 --seed 1639977985 --write tests/data/population`, and 12 over glass
of 10 and 20 mm and steel, four each, without walls, horns, harmonics, foam and holder, measured by their flights.
The first two of those and one of each floor of these are looked at in every run of the tests, all with --slow; rates
are a benchmark's to tell.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from benchmarks.gate.score import Score
from benchmarks.gate.worker import process

DATA = Path(__file__).parents[1] / "data" / "population"
SCENES, STRONG = (sorted((DATA / kind).iterdir()) for kind in ("modelled", "strong"))
IN_EVERY_RUN = 2
MIN_INSIDE = 0.9
# they take seconds each, and on a computer that others use a minute
pytestmark = pytest.mark.timeout(600)


@cache
def scored(folder: Path) -> Score:
    return Score.of_plain(process(folder))


DROPS = [
    pytest.param(folder, id=folder.name, marks=() if number < IN_EVERY_RUN else pytest.mark.slow)
    for number, folder in enumerate(SCENES)
]


@pytest.mark.parametrize("folder", DROPS)
def test_no_drop_is_wrong_in_silence(folder: Path) -> None:
    assert scored(folder).outcome != "SILENT"


@pytest.mark.parametrize(("count", "least_right"), [(IN_EVERY_RUN, 2), pytest.param(24, 22, marks=pytest.mark.slow)])
def test_nearly_all_drops_are_right_and_e_lies_inside_two_of_its_uncertainties(count: int, least_right: int) -> None:
    scores = [scored(folder) for folder in SCENES[:count]]
    outcomes = [one.outcome for one in scores]
    assert len(outcomes) == count
    assert outcomes.count("right") >= least_right, outcomes
    inside = [abs(e.in_u) <= 2.0 for one in scores for e in one.e]
    assert len(inside) >= len(scores)
    assert np.mean(inside) >= MIN_INSIDE


@pytest.mark.parametrize(
    ("folders", "least_right", "most_silent"),
    [
        pytest.param(STRONG[::4], 3, 0, id="one of each floor"),
        pytest.param(STRONG, 9, 1, id="all", marks=pytest.mark.slow),
    ],
)
def test_drops_over_glass_and_steel_are_measured_and_few_are_wrong_in_silence(
    folders: list[Path], least_right: int, most_silent: int
) -> None:
    scores = [scored(folder) for folder in folders]
    outcomes = [one.outcome for one in scores]
    assert outcomes.count("right") >= least_right, outcomes
    assert outcomes.count("SILENT") <= most_silent
    assert outcomes.count("wrong cause") == 0
    inside = [abs(e.in_u) <= 2.0 for one in scores for e in one.e]
    assert len(inside) >= 2 * len(scores)
    assert np.mean(inside) >= MIN_INSIDE
