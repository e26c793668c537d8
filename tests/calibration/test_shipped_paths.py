"""The ready files for known motions."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.calibration.known_path import read_known
from radargui.model.resources import resources_folder

PATHS = sorted((resources_folder() / "paths").glob("*.toml"))


@pytest.mark.parametrize("path", PATHS, ids=lambda path: path.stem)
def test_a_shipped_path_is_read_and_moves_within_the_field_of_view(path: object) -> None:
    trajectory = read_known(path)  # type: ignore[arg-type]
    place = trajectory.place(np.linspace(trajectory.begin_s, min(trajectory.end_s, 5.0), 200))
    assert np.abs(place).max() < 0.2
    assert np.ptp(place, axis=1).max() > 0.05


def test_there_is_one_of_each_kind() -> None:
    assert {read_known(path).path.kind for path in PATHS} == {"stage", "turntable", "pendulum", "table"}
