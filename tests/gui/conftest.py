"""What the tests of the window share: a window on a fast simulated source, its settings in a folder of the test."""

from __future__ import annotations

import gc
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QApplication, QDialog
from pytestqt.qtbot import QtBot
from support.changed import changed
from support.small_setups import quick_setup
from support.window_clocks import FastClock, SeenClock

from radargui.experiment.processing_apart import ProcessingHere
from radargui.gui.control.state import AppState, Asked
from radargui.gui.layout import having
from radargui.gui.main_window import MainWindow
from radargui.gui.notices import NoticeBoard
from radargui.gui.opengl_probe import OpenGLProbe
from radargui.gui.settings import Settings
from radargui.gui.theme import Theme
from radargui.model.setup import dump_setup, read_setup
from radargui.sources.factory import make_source
from radargui.system.resources import default_setup_path

LONGEST_MS = 60_000
IN_SPACE = bool(os.environ.get("RADARGUI_TEST_OPENGL"))
"""On a display: the track is shown by OpenGL."""
if IN_SPACE:
    # before there is an application, as the program's start has it
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)


def fast_sources(speed: float) -> Any:
    def make(kind: Any, setup: Any, **options: Any) -> Any:
        return make_source(kind, setup, clock=FastClock(speed), **options)

    return make


@pytest.fixture(autouse=True)
def nothing_of_the_user_is_touched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep index and channel maps in the test's folder."""
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_, **__: tmp_path / "cache")
    monkeypatch.setattr("platformdirs.user_config_path", lambda *_, **__: tmp_path / "config")


def write_lab(folder: Path) -> Path:
    """Write a user's setup file with a comment in it; low rates, so that the tests are quick."""
    path = folder / "lab.toml"
    path.write_text(_lab_text(), encoding="utf-8")
    return path


@cache
def _lab_text() -> str:
    setup = quick_setup()
    setup = changed(
        setup,
        daq={"rate_hz": 5000.0, "channel_skew_s": 0.0},
        simulation={"rest_s": 0.8, "settle_s": 0.7, "restitution": 0.6},
        recording={"pretrigger_s": 0.3, "quiet_s": 0.3},
    )
    text = dump_setup(setup, default_setup_path().read_text(encoding="utf-8"))
    return "# measured by the operator in May\n" + text


@pytest.fixture
def setup_path(tmp_path: Path) -> Path:
    return write_lab(tmp_path)


@pytest.fixture
def board(qapp: QApplication) -> NoticeBoard:
    return NoticeBoard()


@pytest.fixture
def theme(qapp: QApplication) -> Theme:
    return Theme(qapp, "light")


@pytest.fixture
def large_letters(qapp: QApplication) -> Iterator[None]:
    """Let the system's letters be five thirds as large meanwhile."""
    before = qapp.font()
    qapp.setFont(having(QFont(before), pointSizeF=15.0))
    yield
    qapp.setFont(before)


@pytest.fixture
def settings_path(tmp_path: Path) -> Path:
    return tmp_path / "settings.ini"


MakeWindow = Callable[..., MainWindow]


@contextmanager
def windows(
    qtbot: QtBot, theme: Theme, board: NoticeBoard, settings_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[MakeWindow]:
    """Make windows that share a settings file, beside which their data go; close them in the end."""
    # the live track may be late here: time runs faster than for an operator, on a machine that does other things
    monkeypatch.setattr("radargui.acquisition.stream.LONGEST_LAG_S", 4.0)
    # nobody follows a sphere here: a third of the pictures says as much
    monkeypatch.setattr("radargui.gui.main_window.FRAME_MS", 100)
    made: list[MainWindow] = []

    def make(setup_path: Path | None = None, **options: Any) -> MainWindow:
        settings = Settings(settings_path)
        if settings.path("data_folder") is None:
            settings.put("data_folder", settings_path.with_name("data"))
        options.setdefault("source_maker", fast_sources(options.pop("speed", 8.0)))
        if IN_SPACE:
            options.setdefault("probe", OpenGLProbe())
        window = MainWindow(theme, settings, board, setup_path=setup_path, **options)
        window.may_leave = lambda: True
        window.control.processing = ProcessingHere
        window.resize(1400, 900)
        window.show()
        made.append(window)
        if IN_SPACE:
            qtbot.waitUntil(lambda: bool(window.opengl_answer), timeout=LONGEST_MS)
            window.actions_.in_space.setChecked(True)
            assert window.track.in_space, window.opengl_answer
        return window

    yield make
    for window in made:
        window.close()
        window.closing.leave_now()
        qtbot.waitUntil(window.isHidden, timeout=LONGEST_MS)
        # left behind, it would look for the next test's folders
        qtbot.waitUntil(lambda one=window: not one.jobs.running, timeout=LONGEST_MS)
        # what waits for it comes first: one that had never run its events crashed twice as it was deleted
        QApplication.sendPostedEvents()
        window.deleteLater()
    # without a running event loop nothing else deletes them
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    # the next window is slower for each one that is left behind
    gc.collect()


@pytest.fixture
def make_window(
    qtbot: QtBot, theme: Theme, board: NoticeBoard, settings_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[MakeWindow]:
    with windows(qtbot, theme, board, settings_path, monkeypatch) as make:
        yield make


@pytest.fixture
def own_window(make_window: MakeWindow, setup_path: Path) -> MainWindow:
    """Return a new window: for a test that closes it, counts its threads or looks at what a first start shows."""
    return make_window(setup_path)


@pytest.fixture
def seen_window(make_window: MakeWindow, setup_path: Path) -> MainWindow:
    """Return a new window whose source goes on with its pictures: no state passes unseen, however busy it is."""
    return make_seen(make_window, setup_path)


def make_seen(make: MakeWindow, setup_path: Path) -> MainWindow:
    clock = SeenClock()
    window = make(
        setup_path, source_maker=lambda kind, setup, **options: make_source(kind, setup, clock=clock, **options)
    )
    window._timer.setInterval(20)
    window._timer.timeout.connect(clock.go_on)
    return window


@pytest.fixture(scope="module")
def all_is_seen() -> bool:
    """Whether the window of the module is like `seen_window`; a module may say so."""
    return False


@pytest.fixture(scope="module")
def module_window(
    request: pytest.FixtureRequest, qapp: QApplication, tmp_path_factory: pytest.TempPathFactory, all_is_seen: bool
) -> Iterator[MainWindow]:
    folder, theme = tmp_path_factory.mktemp("window"), Theme(qapp, "light")
    with (
        pytest.MonkeyPatch.context() as patch,
        windows(QtBot(request), theme, NoticeBoard(), folder / "settings.ini", patch) as make,
    ):
        path = write_lab(folder)
        yield make_seen(make, path) if all_is_seen else make(path)


@pytest.fixture
def window(
    module_window: MainWindow, tmp_path: Path, wait_for: Callable[[Callable[[], object]], None]
) -> Iterator[MainWindow]:
    """One window for the tests of a module, as it is at its start: more than half a second to make and delete.

    What a test has left under way ends, its session is closed, its dialogs too; what it has said of the window's
    layout stays.
    """
    window = module_window
    if window.theme.choice != "light":
        window.theme.apply("light")
    window.board.clear()
    window.hardware.choose("simulated")
    window.hardware.replay.file.line.clear()
    path = write_lab(tmp_path)
    window.setup_model.take(read_setup(path), path)
    window.session_panel.folder.line.setText(str(tmp_path / "data"))
    window.bar.runs.setValue(1)
    window.control.processing = ProcessingHere
    window.resize(1400, 900)
    yield window
    for dialog in window.findChildren(QDialog):
        dialog.reject()
    window.work.cancel()
    window.control.end(Asked.LEAVE)
    wait_for(lambda: not window.control.state.running)
    window.sessions.flush()
    # half a second after its folder was named, it would look into the next test's
    window.sessions._entering.stop()
    wait_for(lambda: not window.jobs.running)
    window.control.use_session(None)
    window.session_panel.set_details("", "")


def with_keys(window: MainWindow, wait_for: Callable[..., None], panel: str) -> MainWindow:
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.panels.go_to(panel)
    QApplication.processEvents()
    return window


@pytest.fixture
def active(window: MainWindow, wait_for: Callable[..., None]) -> MainWindow:
    """The same, with the keys."""
    return with_keys(window, wait_for, "hardware")


@pytest.fixture
def antennas(window: MainWindow, wait_for: Callable[..., None]) -> MainWindow:
    """The same, whose panel of the antennas is shown."""
    return with_keys(window, wait_for, "antennas")


@pytest.fixture
def own(own_window: MainWindow, wait_for: Callable[..., None]) -> MainWindow:
    """The test's own window with the keys, whose panel of the antennas is shown."""
    return with_keys(own_window, wait_for, "antennas")


@pytest.fixture
def wait_for(qtbot: QtBot) -> Callable[[Callable[[], object]], None]:
    """Let the window live until something is true."""

    def wait(condition: Callable[[], object]) -> None:
        qtbot.waitUntil(lambda: bool(condition()), timeout=LONGEST_MS)

    return wait


@pytest.fixture
def record_one(wait_for: Any) -> Callable[[MainWindow], None]:
    """Record one simulated drop with the window's own button."""

    def record(window: MainWindow) -> None:
        window.actions_.record.trigger()
        wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED))
        assert window.control.state is AppState.DONE, window.board.notices

    return record
