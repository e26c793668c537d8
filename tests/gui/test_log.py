"""The log window, and what is copied for a bug report."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtGui import QGuiApplication

from radargui.gui.log_window import COPIED_ENTRIES, MAX_ENTRIES, LogWindow
from radargui.gui.main_window import MainWindow

LOG = logging.getLogger("radargui.test")


@pytest.fixture
def log(window: MainWindow) -> Iterator[LogWindow]:
    log = window.log
    window.actions_.log.trigger()
    log.level.setCurrentIndex(0)
    log.follows.setChecked(True)
    yield log
    log.keeper.entries.clear()


def test_entries_of_any_thread_are_shown_filtered_and_followed(log: LogWindow, wait_for: Any) -> None:
    LOG.warning("the first thing")
    thread = threading.Thread(target=LOG.error, args=("a thing of another thread",))
    thread.start()
    thread.join()
    wait_for(lambda: "another thread" in log.view.toPlainText())
    first, second = log.view.toPlainText().splitlines()[-2:]
    # a line as the file has it: time, level, who, what
    assert first.endswith("WARNING radargui.test: the first thing")
    log.level.setCurrentIndex(2)
    assert log.view.toPlainText() == second
    log.level.setCurrentIndex(0)
    assert "the first thing" in log.view.toPlainText()
    for number in range(200):
        LOG.warning("line %d", number)
    log.refresh()
    bar = log.view.verticalScrollBar()
    assert bar.value() == bar.maximum() > 0
    log.follows.click()
    bar.setValue(3)
    LOG.warning("one more")
    log.refresh()
    assert bar.value() == 3


def test_words_are_found_from_the_top_after_the_last(log: LogWindow, wait_for: Any) -> None:
    for text in ("red apple", "green pear", "green apple"):
        LOG.warning(text)
    log.refresh()
    log.words.setText("apple")
    log.view.moveCursor(log.view.textCursor().MoveOperation.Start)
    for text in ("red apple", "green apple", "red apple"):
        log.words.returnPressed.emit()
        assert log.view.textCursor().block().text().endswith(text)
    assert not log.follows.isChecked()
    log.words.setText("cherry")
    log.find_next()
    assert log.said.text() == "“cherry” stands nowhere in what is shown."


def test_memory_is_bounded(log: LogWindow) -> None:
    for number in range(MAX_ENTRIES + 50):
        LOG.warning("n%d", number)
    log.refresh()
    assert len(log.keeper.entries) == MAX_ENTRIES
    assert log.view.blockCount() <= MAX_ENTRIES
    assert log.view.toPlainText().splitlines()[-1].endswith(f"n{MAX_ENTRIES + 49}")


def test_a_closed_window_takes_no_entries(own_window: MainWindow, wait_for: Any) -> None:
    assert own_window.log.keeper in logging.getLogger().handlers
    own_window.close()
    wait_for(own_window.isHidden)
    assert own_window.log.keeper not in logging.getLogger().handlers


def test_a_bug_report_has_what_is_needed_and_no_folders(
    own_window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "Ada Lovelace"
    monkeypatch.setattr(Path, "home", lambda: home)
    monkeypatch.setattr("platformdirs.user_documents_dir", lambda: str(home / "secret project" / "data"))
    for number in range(COPIED_ENTRIES + 5):
        LOG.warning("entry %d of %s", number, home / "secret" / "run-0001.h5")
    QGuiApplication.clipboard().clear()
    own_window.actions_.bug_report.trigger()
    wait_for(lambda: bool(QGuiApplication.clipboard().text()))
    text = QGuiApplication.clipboard().text()
    lines = text.splitlines()
    assert any(line.startswith("RadarGUI ") for line in lines)
    assert any(line.startswith("numpy ") for line in lines)
    assert any(line.startswith("NI-DAQmx driver ") for line in lines)
    entries = [line for line in lines if "radargui.test" in line]
    assert len(entries) == COPIED_ENTRIES
    assert entries[-1].endswith(f"entry {COPIED_ENTRIES + 4} of …/run-0001.h5")
    assert "[[receiver]]" in lines
    assert "frequency_hz = 10000000000.0" in text
    for private in ("Lovelace", "secret", str(tmp_path)):
        assert private not in text, private
    said = own_window.board.notices[0].text
    assert said.startswith(f"Copied for a bug report: versions and system, the last {COPIED_ENTRIES} entries")
    assert f"{len(lines)} lines" in said
