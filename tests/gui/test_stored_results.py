"""Choosing a stored run shows the result in its file; it is computed only where that is none."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from support.gui_sessions import make_session
from support.stored_runs import SETUP, results_digest

from radargui.files.run_results import write_results
from radargui.gui.main_window import MainWindow
from radargui.model.words import sentence
from radargui.processing.result_of_run import DAMAGED, stored_result


def choose(window: MainWindow, wait_for: Any, folder: Path) -> None:
    window.sessions.open(folder)
    wait_for(lambda: window.runs.model.entries and not window.jobs.running)
    window.runs.table.selectRow(0)
    wait_for(lambda: window.run.result is not None and not window.jobs.running)


def test_a_chosen_run_is_shown_and_exported_without_computing(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    folder = make_session(tmp_path / "data", 4)
    stored = stored_result(folder / "run-0001.h5", SETUP)
    first, *others = stored.bounces.impacts
    # what no computing gives
    impacts = (replace(first, e=0.4321), *others)
    write_results(folder / "run-0001.h5", replace(stored, bounces=replace(stored.bounces, impacts=impacts)))
    choose(window, wait_for, folder)
    shown = window.run.result
    assert shown.bounces.impacts[0].e == 0.4321
    for page in range(window.run.tabs.count()):
        window.run.tabs.setCurrentIndex(page)
        wait_for(lambda: not window.jobs.running)
    assert window.run.tabs.page("steps").raw[0].found["peaks"].getData()[0].size > 3
    assert np.isfinite(window.run.tabs.page("steps")._curves[0].getOriginalDataset()[1]).any()
    assert window.track.shown is not None
    window.run_controller._kept.clear()
    window.run_controller.export(tmp_path)
    wait_for(lambda: not window.work.busy)
    assert (tmp_path / "run-0001" / "track.csv").stat().st_size > 0
    assert [notice.level for notice in window.board.notices] == ["info"]


def test_damaged_results_are_computed_again_and_the_operator_is_told(
    own_window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    folder = make_session(tmp_path / "data", 4)
    with h5py.File(folder / "run-0001.h5", "r+") as file:
        file["results"].attrs["reason"] = np.bytes_("spoiled")
    before = results_digest(folder / "run-0001.h5")
    choose(own_window, wait_for, folder)
    assert own_window.run.result.findings[0] == DAMAGED
    assert own_window.run.result.status == "ok"
    assert sentence(DAMAGED.text) in own_window.run.figures.toPlainText()
    assert results_digest(folder / "run-0001.h5") == before
