"""Old and new results of a run side by side; the samples stay as they are."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.run_contents import read_summary
from support.stored_runs import SETUP, raw_digest, store_runs

from radargui.experiment.compare import compare_stored, compare_with
from radargui.experiment.reprocess import process_run
from radargui.files.stored_results import read_stored_results
from radargui.model.errors import SetupError
from radargui.model.setup import changed
from radargui.model.setup_error import changed_settings

PLANE = {"processing.geometry": "plane"}


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return store_runs(tmp_path / "session", 1)[0]


def test_other_settings_are_tried_without_touching_the_file(run: Path) -> None:
    process_run(run)
    before = run.read_bytes()
    compared = compare_with(run, changes=PLANE)
    assert run.read_bytes() == before
    assert [one.name for one in compared.figures] == ["e", "drop_height_m", "impact_speed_m_s", "g_m_s2"]
    e = compared.figures[0]
    assert e.before == pytest.approx(0.5, abs=0.02)
    # as lists and reports have it; but the antennas are the same on both sides
    assert (e.u_before, e.u_after) == (
        compared.before.summary["u_e_combined"],
        compared.after.summary["u_e_combined"],
    )
    assert e.u_difference == max(compared.before.summary["u_e"], compared.after.summary["u_e"]) < e.u_after
    assert e.difference != 0.0
    assert [(one.key, one.before, one.after) for one in compared.settings] == [
        ("processing.geometry", "exact", "plane")
    ]


def test_one_that_was_not_processed_is_compared_with_its_own_settings(run: Path) -> None:
    compared = compare_with(run, changes=PLANE)
    assert compared.before.summary["geometry"] == "exact"
    assert read_summary(run) is None


def test_kept_results_take_the_place_of_the_old_ones_which_stay_beside(run: Path) -> None:
    process_run(run)
    samples = raw_digest(run)
    assert compare_stored(run) is None
    tried = compare_with(run, changes=PLANE, keep=True)
    assert raw_digest(run) == samples
    assert [one.summary["geometry"] for one in read_stored_results(run)] == ["exact", "plane"]
    stored = compare_stored(run)
    assert stored is not None
    assert stored.before.summary == tried.before.summary
    assert stored.after.summary == tried.after.summary
    assert stored.settings == tried.settings


def test_another_calibration_is_a_change_like_any_other(run: Path) -> None:
    other = changed(SETUP, {"transmitter.distance_m": 0.72})
    compared = compare_with(run, setup=other)
    assert [(one.key, one.before, one.after) for one in compared.settings] == [("transmitter.distance_m", 0.7, 0.72)]
    assert changed_settings(SETUP, SETUP) == ()


def test_a_value_that_is_not_allowed_is_told_before_any_work(run: Path) -> None:
    with pytest.raises(SetupError, match="geometry"):
        compare_with(run, changes={"processing.geometry": "flat"})
