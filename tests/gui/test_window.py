"""The window itself: layout, look, memory, messages, OpenGL."""

from __future__ import annotations

import subprocess
import sys
import threading
import warnings
from pathlib import Path
from typing import Any

import pytest
from nidaqmx.errors import DaqWarning
from PySide6.QtCore import QProcess, qCritical, qWarning
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QApplication, QMenu, QPushButton

from radargui.gui.layout import Strip
from radargui.gui.main_window import MainWindow
from radargui.gui.notices import Hooks
from radargui.gui.opengl_probe import FORCE_VARIABLE, SOFTWARE, UNUSABLE, USABLE, OpenGLProbe, check_command
from radargui.gui.panels import WORKSPACES
from radargui.gui.settings import Settings
from radargui.gui.theme import DARK, LIGHT
from radargui.model.errors import SourceError


def test_every_panel_can_be_closed_and_comes_back_by_reset(window: MainWindow) -> None:
    docks = window.panels.docks
    for name, workspace in WORKSPACES.items():
        window.panels.work_in(name)
        shown = {*workspace.own, *workspace.guests}
        assert {one for one in docks if not docks[one].isHidden()} == shown
        for one in shown:
            docks[one].toggleViewAction().trigger()
        assert all(dock.isHidden() for dock in docks.values())
    for name, workspace in reversed(WORKSPACES.items()):
        window.panels.work_in(name)
        assert all(dock.isHidden() for dock in docks.values()) == (name == "sessions")
        window.actions_.reset_layout.trigger()
        assert {one for one in docks if not docks[one].isHidden()} == {*workspace.own, *workspace.guests}


def test_every_action_has_a_key_and_stands_in_a_menu(window: MainWindow) -> None:
    in_menus = {action for menu in window.menuBar().findChildren(QMenu) for action in menu.actions()}
    assert len(window.actions_._made) >= 28
    for action in window.actions_._made.values():
        assert action in in_menus, action.text()
        assert action.shortcuts(), action.text()
    keys: dict[str, str] = {}
    for action in in_menus:
        for key in action.shortcuts():
            name = key.toString()
            assert name == "F5" or name not in keys, f"{name}: {keys.get(name)} and {action.text()}"
            keys[name] = action.text()


def test_the_look_reaches_palette_and_plots(window: MainWindow) -> None:
    plots = [*window.scopes.time.scopes, *window.planes.raw, window.track.curves.height_plot]
    for choice, colours in (("dark", DARK), ("light", LIGHT)):
        action = next(action for action in window.theme_actions.actions() if action.data() == choice)
        action.trigger()
        assert window.theme.colours is colours
        assert QApplication.palette().color(QPalette.ColorRole.Window).name() == colours.window
        for plot in plots:
            assert plot.backgroundBrush().color().name() == colours.base
        pen = window.scopes.time.scopes[0]._curves[0].opts["pen"]
        assert pen.color().name() == colours.i
        assert pen.width() == 1
    assert window.settings.theme() == "light"


def test_layout_operator_and_edits_are_remembered(make_window: Any, setup_path: Path) -> None:
    first = make_window(setup_path)
    first.panels.work_in("measure")
    first.panels.docks["planes"].toggleViewAction().trigger()
    first.session_panel.set_details("Grace", "")
    first.bar.runs.setValue(7)
    first.setup_model.assign("receiver[1].tilt_deg", 42.0)
    first.close()
    second = make_window(None)
    assert second.setup_model.path == setup_path
    assert second.setup_model.setup.receiver[0].tilt_deg == 42.0
    assert second.setup_model.modified
    assert second.panels.workspace == "measure"
    assert second.panels.docks["planes"].isHidden()
    assert second.session_panel.details.operator == "Grace"
    assert second.bar.runs.value() == 7


@pytest.mark.parametrize(
    "text",
    [
        "\x00\x01\x02 not settings",
        "[General\nlayout=@Variant(\\0\\0\\0\\x7f\\xff\nruns=many\ntheme=pink\ngeometry=5\n",
        "[General]\nruns=-5\nlayout=@ByteArray(rubbish)\ngeometry=@ByteArray(rubbish)\nscope_window_s=nan\ntheme=pink\n",
        "[General]\nsetup_file=/no/such.toml\nsetup_draft=[[[\n",
    ],
)
def test_corrupt_settings_never_block_the_start(make_window: Any, settings_path: Path, text: str) -> None:
    settings_path.write_text(text, encoding="latin-1")
    window = make_window(None)
    assert window.setup_model.valid
    assert window.setup_model.shipped
    assert window.bar.runs.value() == 1
    assert window.panels.workspace == "measure", "the shipped setup is right"
    assert not window.panels.docks["track"].isHidden()


def test_a_file_that_is_no_settings_file_is_set_aside(settings_path: Path, qapp: QApplication) -> None:
    settings_path.write_text("rubbish without meaning\n[[", encoding="utf-8")
    settings = Settings(settings_path)
    assert settings.set_aside is not None
    assert settings.set_aside.parent == settings_path.parent
    assert settings.set_aside.read_text(encoding="utf-8").startswith("rubbish")
    settings.put("operator", "Ada")
    settings.sync()
    assert Settings(settings_path).text("operator") == "Ada"


def test_a_setup_named_at_the_start_that_is_bad_is_told_and_replaced(
    make_window: Any, tmp_path: Path, wait_for: Any
) -> None:
    window = make_window(tmp_path / "missing.toml")
    wait_for(lambda: window.strip.texts())
    assert "missing.toml" in window.strip.texts()[0]
    assert window.setup_model.valid


def test_an_error_of_many_lines_is_read_in_few_and_its_buttons_stand_beside_the_first(
    window: MainWindow, wait_for: Any
) -> None:
    told = "Requested value is not allowed.\n\n    Property: Rate\n\n    Status Code: -200077\n" * 6
    window.board.post("error", told)
    wait_for(lambda: window.strip.findChildren(QPushButton))
    QApplication.processEvents()
    (row,) = window.strip.findChildren(Strip)
    assert row.words.text().startswith("Error: Requested value is not allowed. Property: Rate Status Code: -200077 ")
    assert "\n" not in row.words.text()
    assert row.height() > 2 * row.fontMetrics().height()
    for one in row.findChildren(QPushButton):
        assert one.visibleRegion().boundingRect().size() == one.size(), one.text()
    # as it came
    next(one for one in row.findChildren(QPushButton) if one.text() == "Copy").click()
    assert QApplication.clipboard().text() == told


def test_messages_are_whole_selectable_and_not_repeated(window: MainWindow, wait_for: Any) -> None:
    error = SourceError("Cable <out>", reasons=["it was pulled"], remedy="Plug it in.")
    for _ in range(3):
        window.board.post_error(error)
    wait_for(lambda: window.board.notices)
    assert window.strip.texts() == (str(error),)
    assert window.board.notices[0].count == 3
    window.board.dismiss(window.board.notices[0])
    assert window.strip.isHidden()


@pytest.mark.usefixtures("window")
def test_the_thread_that_draws_has_its_turn_sooner_than_python_gives_it_and_windows_can_count_it() -> None:
    assert sys.getswitchinterval() == pytest.approx(1e-3)


def test_exceptions_of_any_thread_reach_the_strip(window: MainWindow, wait_for: Any) -> None:
    old = sys.excepthook, threading.excepthook
    hooks = Hooks(window.board)
    try:
        thread = threading.Thread(target=lambda: 1 / 0)
        thread.start()
        thread.join()
        sys.excepthook(SourceError, SourceError("in the main thread"), None)
    finally:
        hooks.remove()
    assert (sys.excepthook, threading.excepthook) == old
    wait_for(lambda: len(window.strip.texts()) == 2)
    # what the main thread posts is there at once, what another posts comes by the event loop
    assert window.strip.texts()[1] == "in the main thread"
    assert "ZeroDivisionError" in window.strip.texts()[0]


def test_warnings_of_libraries_are_logged_once_and_shown_where_the_operator_can_do_something(
    window: MainWindow, caplog: pytest.LogCaptureFixture
) -> None:
    hooks = Hooks(window.board)
    try:
        for _ in range(40):
            warnings.showwarning("overflow", RuntimeWarning, "library.py", 12)
            warnings.showwarning(DaqWarning("the clock was rounded", 200), DaqWarning, "task.py", 3)
            qWarning("a signal nobody heard")
            qCritical("the display is gone")
    finally:
        hooks.remove()
    logged = [record.getMessage() for record in caplog.records]
    assert sum("RuntimeWarning: overflow" in text for text in logged) == 1
    assert sum("a signal nobody heard" in text for text in logged) == 1
    assert sum("the clock was rounded" in text or "the display is gone" in text for text in logged) == 2
    assert [(one.level, one.count) for one in window.board.notices] == [("error", 1), ("warning", 1)]
    assert "the display is gone" in window.board.notices[0].text
    assert "the clock was rounded" in window.board.notices[1].text


def test_without_opengl_the_track_is_shown_in_projections(make_window: Any, setup_path: Path, wait_for: Any) -> None:
    window = make_window(setup_path, probe=OpenGLProbe())
    wait_for(lambda: window.opengl_answer)
    assert "no OpenGL" in window.opengl_answer
    assert not window.actions_.in_space.isEnabled()
    assert not window.track.in_space


@pytest.mark.parametrize(("status", "usable", "good"), [(USABLE, 1, 1), (SOFTWARE, 1, 0), (UNUSABLE, 0, 0), (0, 0, 0)])
def test_the_test_of_opengl_is_asked_in_another_process(
    qtbot: Any, monkeypatch: pytest.MonkeyPatch, status: int, usable: int, good: int
) -> None:
    monkeypatch.setattr("PySide6.QtGui.QGuiApplication.platformName", lambda: "windows")
    probe = OpenGLProbe([sys.executable, "-c", f"print('a driver'); raise SystemExit({status})"])
    with qtbot.waitSignal(probe.answered, timeout=20_000) as told:
        probe.start()
    assert told.args == [bool(usable), bool(good), "a driver"]
    probe.close()


def test_the_check_itself_says_no_on_the_offscreen_platform() -> None:
    ended = subprocess.run(check_command(), capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == UNUSABLE, ended.stderr
    assert "no OpenGL" in ended.stdout


def test_a_test_of_opengl_that_hangs_does_not_hold_up_the_end(monkeypatch: pytest.MonkeyPatch, wait_for: Any) -> None:
    monkeypatch.setattr("PySide6.QtGui.QGuiApplication.platformName", lambda: "windows")
    probe = OpenGLProbe([sys.executable, "-c", "import time; time.sleep(60)"])
    probe.start()
    probe.close()
    wait_for(lambda: not probe.busy)
    assert probe._process.exitStatus() == QProcess.ExitStatus.CrashExit, "it was killed"


def test_a_test_of_opengl_that_crashes_or_cannot_be_run_leaves_the_projections(
    qtbot: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("PySide6.QtGui.QGuiApplication.platformName", lambda: "windows")
    for command in ([sys.executable, "-c", "import os; os.abort()"], ["/no/such/program"]):
        probe = OpenGLProbe(command)
        with qtbot.waitSignal(probe.answered, timeout=20_000) as told:
            probe.start()
        assert told.args[:2] == [False, False]
        assert told.args[2].startswith("the test of OpenGL ")


def test_projections_can_be_forced(qtbot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FORCE_VARIABLE, "1")
    probe = OpenGLProbe(["this is never run"])
    with qtbot.waitSignal(probe.answered, timeout=5_000) as told:
        probe.start()
    assert told.args[0] is False
