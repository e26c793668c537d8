"""When recordings contradict each other more than chance and the usual widening of u let them."""

from __future__ import annotations

import numpy as np

from radargui.calibration.calibrate import CONTRADICTION, max_birge
from radargui.calibration.fit import LEAST, MIN_BESIDE_WALLS, Fit
from radargui.calibration.likelihood import World
from radargui.calibration.verdict import are_far
from radargui.model.setup import read_setup
from radargui.system.resources import default_setup_path


class _Differing(Fit):
    """A fit whose recordings differ by three deviations each time."""

    differences = 6.0

    def contradiction(self) -> tuple[float, float]:
        return 9.0 * self.differences, self.differences


class _OftenDiffering(_Differing):
    differences = 100.0


def most(kind: type[Fit], least: float) -> float:
    """Return the largest Birge ratio."""
    world = World(read_setup(default_setup_path()), ())
    return max_birge(kind(world, np.empty(0), (), (), np.zeros(0, dtype=bool), least))


def test_beside_a_wall_few_differences_may_be_as_large_as_chance_makes_them() -> None:
    assert 4.2 < most(_Differing, MIN_BESIDE_WALLS) < 4.4


def test_where_there_is_no_wall_or_many_differences_the_limit_is_the_same_as_ever() -> None:
    assert most(_Differing, LEAST) == CONTRADICTION
    assert most(_OftenDiffering, MIN_BESIDE_WALLS) == CONTRADICTION


def test_a_release_that_the_recordings_hardly_tell_is_not_far_where_their_own_u_explains_it() -> None:
    assert are_far(np.array([4.8, 4.8, -4.2, 3.9]), np.array([0.02, 1.2, 0.1, 0.0])).tolist() == [
        True,
        False,
        True,
        False,
    ]
