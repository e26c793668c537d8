"""Twenty-four drops of ordinary laboratories, as files, through the public door: the rates that a version must keep.

They were drawn once, whatever comes of them, and anew by
`dev.py bench population -n 24 --hold rate_hz=10000 --seed 1639977985 --write tests/data/population`.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from benchmarks.gate.score import Score
from benchmarks.gate.worker import process

SCENES = sorted(Path(__file__).parents[1].joinpath("data", "population", "modelled").iterdir())
LEAST_RIGHT = 22
LONG = ("006", "009")
"""Refused after most of a minute each: strong floors, on which walls are sought for long."""
QUICK = [folder for folder in SCENES if folder.name not in LONG]
DROPS = [
    pytest.param(folder, id=folder.name, marks=pytest.mark.slow if folder.name in LONG else ()) for folder in SCENES
]
LEAST_INSIDE = 0.9
# most take seconds, one a minute, and on a computer that others use several
pytestmark = pytest.mark.timeout(600)


@cache
def scored(folder: Path) -> Score:
    return Score.of_plain(process(folder))


@pytest.mark.parametrize("folder", DROPS)
def test_no_drop_is_wrong_in_silence(folder: Path) -> None:
    assert scored(folder).outcome != "SILENT"


def test_nearly_all_quick_drops_are_right_and_e_lies_inside_two_of_its_uncertainties() -> None:
    scores = [scored(folder) for folder in QUICK]
    outcomes = [one.outcome for one in scores]
    assert outcomes.count("right") >= LEAST_RIGHT - len(LONG), outcomes
    inside = [abs(e.in_u) <= 2.0 for one in scores for e in one.e]
    assert len(inside) >= len(scores)
    assert np.mean(inside) >= LEAST_INSIDE


@pytest.mark.slow
def test_of_all_drops_nearly_all_are_right() -> None:
    assert len(SCENES) == 24
    assert [scored(folder).outcome for folder in SCENES].count("right") >= LEAST_RIGHT
