"""Runs studied ahead by another process come in order, like those studied one by one."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.results import default_setup
from support.stored_runs import store_runs

from radargui.model.errors import ProcessingError
from radargui.model.result import RunResult
from radargui.processing.result_of_run import stored_or_computed
from radargui.report.report import studied


@pytest.mark.parametrize("ahead", [False, True])
def test_runs_come_in_their_order_and_one_that_fails_says_why(tmp_path: Path, *, ahead: bool) -> None:
    paths = [tmp_path / f"run-{number:04d}.h5" for number in range(1, 8)]
    for path in paths[1:]:
        path.write_bytes(b"this is no run file")
    facts = list(studied(paths, default_setup(), stored_or_computed, detailed=False, ahead=ahead))
    assert [one.name for one in facts] == [path.stem for path in paths]
    assert "no such file" in facts[0].failure
    assert all("run file" in one.failure for one in facts[1:])
    # what nobody can read was not measured either
    assert {one.source.kind for one in facts} == {"unknown"}


def test_a_simulated_run_whose_processing_fails_stays_a_simulated_one(tmp_path: Path) -> None:
    (path,) = store_runs(tmp_path / "session", 1)

    def fail(*_: object) -> RunResult:
        raise ProcessingError("nothing fits")

    (facts,) = studied([path], default_setup(), fail, detailed=False, ahead=False)
    assert (facts.failure, facts.source.kind) == ("nothing fits", "simulated")


def test_nobody_waits_for_runs_that_are_not_wanted_any_more(tmp_path: Path) -> None:
    paths = [tmp_path / f"run-{number:04d}.h5" for number in range(1, 400)]
    found = studied(paths, default_setup(), stored_or_computed, detailed=False, ahead=True)
    assert next(found).name == "run-0001"
    found.close()
