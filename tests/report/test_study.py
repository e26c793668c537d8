"""Runs studied ahead by another process come in order, like those studied one by one."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.results import default_setup

from radargui.processing.result_of_run import stored_or_computed
from radargui.report.study import studied


@pytest.mark.parametrize("ahead", [False, True])
def test_runs_come_in_their_order_and_one_that_fails_says_why(tmp_path: Path, *, ahead: bool) -> None:
    paths = [tmp_path / f"run-{number:04d}.h5" for number in range(1, 8)]
    for path in paths[1:]:
        path.write_bytes(b"this is no run file")
    facts = list(studied(paths, default_setup(), stored_or_computed, detailed=False, ahead=ahead))
    assert [one.name for one in facts] == [path.stem for path in paths]
    assert "no such file" in facts[0].failure
    assert all("run file" in one.failure for one in facts[1:])


def test_nobody_waits_for_runs_that_are_not_wanted_any_more(tmp_path: Path) -> None:
    paths = [tmp_path / f"run-{number:04d}.h5" for number in range(1, 400)]
    found = studied(paths, default_setup(), stored_or_computed, detailed=False, ahead=True)
    assert next(found).name == "run-0001"
    found.close()
