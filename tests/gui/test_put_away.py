"""Series and preview while sessions are opened, put away, or cannot be read."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest
from support.gui_sessions import make_height

from radargui.gui.main_window import MainWindow
from radargui.model.errors import FileError
from radargui.report import facts


@pytest.fixture
def two(tmp_path: Path) -> list[Path]:
    return [make_height(tmp_path / "data", day, height) for day, height in ((4, 0.26), (5, 0.18))]


def idle(window: MainWindow, wait_for: Any) -> None:
    wait_for(lambda: not window.jobs.running)


def opened(window: MainWindow, path: Path, wait_for: Any) -> None:
    window.sessions.open(path)
    idle(window, wait_for)


def test_nothing_of_a_session_stays_in_series_and_preview_when_another_is_opened_unseen(
    window: MainWindow, wait_for: Any, two: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened(window, two[0], wait_for)
    window.show_view("table")
    window.actions_.preview.trigger()
    preview, panel = window.run_controller.report_preview, window.series
    idle(window, wait_for)
    assert two[0].name in preview.page.toPlainText()
    # a reading that takes its time: meanwhile both are put away, and another session is opened
    go, glance = threading.Event(), facts.glance
    monkeypatch.setattr(facts, "glance", lambda path, normal: go.wait(60.0) and glance(path, normal))
    (two[0] / "run-0001.h5").touch()
    window.series.refresh()
    preview.refresh()
    window.panels.go_to("scopes")
    preview.close()
    window.sessions.open(two[1])
    wait_for(lambda: window.control.session is not None and window.control.session.path == two[1])
    go.set()
    idle(window, wait_for)
    assert panel.facts is None
    assert two[0].name not in preview.page.toPlainText()
    # and both read the other one when they are looked at
    window.show_view("table")
    window.actions_.preview.trigger()
    wait_for(lambda: panel.facts is not None and panel.facts.findings.sessions[0].name == two[1].name)
    wait_for(lambda: two[1].name in preview.page.toPlainText())
    window.control.use_session(None)
    assert preview.page.toPlainText() == "No session is open."


def test_a_session_that_is_put_away_while_it_is_read_takes_its_fault_along(
    window: MainWindow, wait_for: Any, two: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    opened(window, two[0], wait_for)
    go, glance = threading.Event(), facts.glance

    def damaged(path: Path, normal: Any) -> Any:
        go.wait(60.0)
        if path.parent == two[0]:
            raise FileError(f"{path.name} is damaged")
        return glance(path, normal)

    monkeypatch.setattr(facts, "glance", damaged)
    window.show_view("table")
    window.sessions.open(two[1])
    wait_for(lambda: window.control.session is not None and window.control.session.path == two[1])
    go.set()
    wait_for(lambda: window.series.facts is not None)
    assert window.series.facts.findings.sessions[0].name == two[1].name
    assert window.board.notices == ()


def test_a_session_that_cannot_be_read_is_said_and_leaves_the_open_one_alone(
    window: MainWindow, wait_for: Any, two: list[Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    glance = facts.glance

    def damaged(path: Path, normal: Any) -> Any:
        if path.parent == two[1]:
            raise FileError(f"{path.name} is damaged")
        return glance(path, normal)

    monkeypatch.setattr(facts, "glance", damaged)
    opened(window, two[0], wait_for)
    window.show_view("table")
    window.series.show_beside((two[1],))
    panel = window.series
    wait_for(lambda: window.board.notices and panel.facts is not None)
    assert [one.name for one in panel.facts.findings.sessions] == [two[0].name]
    opened(window, two[1], wait_for)
    wait_for(lambda: panel._title.text().startswith("The session cannot be read"))
    assert panel.facts is None
