"""Where samples come from stands beside everything that is shown of them, from the first moment."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from support.gui_sessions import make_session

from radargui.files.run_card import origin_of_source, read_run_card
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.run_model import COLUMNS, RunEntry, RunModel
from radargui.model.drop import RunOrigin
from radargui.processing.result_of_run import stored_result
from radargui.report.content import Facts
from radargui.report.facts import report_facts
from radargui.report.findings_section import front_chapters
from radargui.report.report import study_session
from radargui.report.run_section import run_page
from radargui.session.info import read_info
from radargui.session.session import BY_OPERATOR, Session, reason_of


def all_say(window: MainWindow, badge: str) -> None:
    window.situation.look()
    assert window.bar.state.badge == badge
    assert badge in window.bar.state.accessibleName()
    assert f" · {badge}" in window.windowTitle()
    assert window.situation.now.badge == badge


def report_says(session: Path, badge: str) -> None:
    facts = report_facts([study_session(Session.open(session, write=False), stored_result)], "now")
    first, *_ = front_chapters(facts)
    assert badge.lower() in first.title
    (found,) = [block for block in first.blocks if isinstance(block, Facts) and ("Source", badge) in block.rows]
    assert found
    assert badge.lower() in run_page(facts.sessions[0].runs[0]).title


def test_a_simulation_is_called_so_from_the_first_moment_to_the_report(
    own_window: MainWindow, wait_for: Any, record_one: Any
) -> None:
    window = own_window
    all_say(window, "SIMULATED")
    window.actions_.start.trigger()
    wait_for(lambda: window.control.state is AppState.LIVE)
    all_say(window, "SIMULATED")
    record_one(window)
    all_say(window, "SIMULATED")
    window.actions_.across.setChecked(True)
    assert window.across.situation.badge == "SIMULATED"
    assert "SIMULATED" in window.across.accessibleName()
    window.actions_.across.setChecked(False)
    assert window.runs.model.entries[0].cells[-1] == "good, SIMULATED"
    path = window.control.session.path
    assert read_info(path).source == "SIMULATED"
    report_says(path, "SIMULATED")

    # what is shown is spoken of, not what is chosen for the next one
    window.hardware.choose("ni")
    all_say(window, "SIMULATED")
    window.actions_.new_session.trigger()
    all_say(window, f"NI {window.setup_model.setup.daq.device}")
    window.sessions.open(path)
    wait_for(lambda: window.runs.model.entries and not window.jobs.running)
    all_say(window, "SIMULATED")


def test_a_replayed_simulation_keeps_the_word(own_window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    window = own_window
    session = make_session(tmp_path / "other", 4)
    copy = Path(shutil.copy(session / "run-0001.h5", tmp_path / "drop.h5"))
    window.setup_model.replace(Session.open(session, write=False).setup)
    window.hardware.choose("replay")
    window.hardware.replay.file.line.setText(str(copy))
    all_say(window, "REPLAY")
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED))
    assert window.control.state is AppState.DONE, window.board.notices
    all_say(window, "REPLAY OF SIMULATED")
    assert window.runs.model.entries[0].verdict.endswith(", REPLAY OF SIMULATED")
    assert window.runs.series.text().endswith(", replay of simulated")
    report_says(window.control.session.path, "REPLAY OF SIMULATED")


@pytest.mark.parametrize(
    ("origin", "badge"),
    [
        (RunOrigin("simulated"), "SIMULATED"),
        (RunOrigin("replay", of_simulated=True), "REPLAY OF SIMULATED"),
        (RunOrigin("measured", source="NI Dev1"), "NI Dev1"),
    ],
)
def test_a_run_that_was_set_aside_keeps_its_badge_in_the_list(origin: RunOrigin, badge: str) -> None:
    model, path = RunModel(), Path("run-0001.h5")
    model.put(RunEntry(path, origin=origin))
    cell = model.index(0, list(COLUMNS).index("Verdict"))
    for rejected, words, why in (
        (BY_OPERATOR, f"set aside, {badge}", "set aside: by the operator"),
        (reason_of("touched"), f"set aside, {badge}: touched", "set aside: by the operator: touched"),
        ("no fall", f"set aside, {badge}: no fall", "set aside: no fall"),
    ):
        model.put(RunEntry(path, origin=origin, rejected=rejected))
        assert cell.data() == words
        assert cell.data(Qt.ItemDataRole.ToolTipRole).splitlines() == [words, why]
    model.put(RunEntry(path, origin=origin, rejected=""))
    assert cell.data() == f"not processed, {badge}"


def test_a_device_is_called_by_its_name(tmp_path: Path) -> None:
    assert origin_of_source("ni", None, "Dev1").badge == "NI Dev1"
    assert origin_of_source("replay", tmp_path / "missing.h5", "Dev1").badge == "REPLAY"
    assert origin_of_source("my-plug-in", None, "Dev1").badge == "my-plug-in"
    # a file of before says no more than that it was measured
    assert RunOrigin("measured").badge == ""
    (run,) = make_session(tmp_path, 4).glob("run-*.h5")
    assert read_run_card(run).origin.badge == "SIMULATED"
