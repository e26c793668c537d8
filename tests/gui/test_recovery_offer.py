"""Runs that a crash left: offered at the start, recovered only when asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from support.gui_sessions import make_session

from radargui.files.run_card import read_run_card
from radargui.gui.main_window import MainWindow
from radargui.model.errors import CancelledError


@pytest.fixture
def crashed(tmp_path: Path) -> Path:
    return make_session(tmp_path / "data", 4, finish=False) / "run-0001.h5"


def test_an_unfinished_run_is_offered_and_recovered_when_asked(
    crashed: Path, window: MainWindow, wait_for: Any
) -> None:
    before = crashed.read_bytes()
    wait_for(lambda: not window.recovery.isHidden())
    assert "1 run was left unfinished" in window.recovery.words.text()
    assert "run-0001.h5" in window.recovery.words.text()
    assert crashed.read_bytes() == before
    window.recovery.accept.click()
    assert window.recovery.isHidden()
    wait_for(lambda: not window.work.busy)
    card = read_run_card(crashed)
    assert card.finished
    assert card.recovered_at
    assert card.summary["e"] == pytest.approx(0.5, abs=0.05)
    assert any("1 run is recovered" in notice.text for notice in window.board.notices)


def test_not_now_leaves_a_run_as_it_is(crashed: Path, own_window: MainWindow, wait_for: Any) -> None:
    before = crashed.read_bytes()
    wait_for(lambda: not own_window.recovery.isHidden())
    own_window.recovery.refuse.click()
    assert own_window.recovery.isHidden()
    assert crashed.read_bytes() == before


def test_without_unfinished_runs_nothing_is_offered(tmp_path: Path, window: MainWindow, wait_for: Any) -> None:
    make_session(tmp_path / "data", 4)
    window.recovery.look()
    wait_for(lambda: not window.jobs.running)
    assert window.recovery.isHidden()


def test_closing_ends_a_long_look_at_the_folders(own_window: MainWindow) -> None:
    task = own_window.work.quiet()
    task.report(0.1)
    own_window.close()
    with pytest.raises(CancelledError):
        task.report(0.2)
