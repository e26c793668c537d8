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
LEAST_INSIDE = 0.9
# they take seconds each, and on a computer that others use a minute
pytestmark = pytest.mark.timeout(600)


@cache
def scored(folder: Path) -> Score:
    return Score.of_plain(process(folder))


@pytest.mark.parametrize("folder", SCENES, ids=lambda folder: folder.name)
def test_no_drop_is_wrong_in_silence(folder: Path) -> None:
    assert scored(folder).outcome != "SILENT"


def test_nearly_all_drops_are_right_and_e_lies_inside_two_of_its_uncertainties() -> None:
    scores = [scored(folder) for folder in SCENES]
    outcomes = [one.outcome for one in scores]
    assert len(outcomes) == 24
    assert outcomes.count("right") >= LEAST_RIGHT, outcomes
    inside = [abs(e.in_u) <= 2.0 for one in scores for e in one.e]
    assert len(inside) >= len(scores)
    assert np.mean(inside) >= LEAST_INSIDE
