"""Everything the window can do, as actions with their keys, the menus in which each stands, and what Help tells."""

from __future__ import annotations

import platform
from pathlib import Path

import pyqtgraph
from PySide6 import __version__ as pyside_version
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QActionGroup, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QComboBox,
    QDialog,
    QHBoxLayout,
    QMainWindow,
    QMenuBar,
    QPlainTextEdit,
    QVBoxLayout,
    QWidget,
)

from radargui import __version__
from radargui.gui.control.app_state import AppState
from radargui.gui.layout import button, fill, fit_screen
from radargui.gui.panels import Panels, belongs
from radargui.gui.settings import Settings
from radargui.gui.theme import CHOICES, Theme


class Actions:
    """One attribute an action."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self.start = self._make("Start", "Space", "F5", tip="Show what the source gives, without recording")
        self.record = self._make("Record", "R", "F9", tip="Record runs: armed, triggered by motion, processed, saved")
        self.stop = self._make("Stop", "Esc", "F5", "Shift+F5", tip="End what runs; what was recorded is kept")
        for action in (self.start, self.record, self.stop):
            action.setIconText(f"{action.text()}\n{action.shortcut().toString()}")
            action.setAutoRepeat(False)
        for action in (self.start, self.record):
            # in a window beside this one these are letters
            action.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        self.pause = self._make("Pause display", "F6", tip="Hold the plots; samples are taken all the same")
        self.pause.setCheckable(True)
        self.open_setup = self._make("Open setup…", "Ctrl+O")
        self.save_setup = self._make("Save setup", "Ctrl+S")
        self.save_setup_as = self._make("Save setup as…", "Ctrl+Shift+S")
        self.undo_setup = self._make("Undo all changes of the setup", "Ctrl+Shift+U", tip="Back to what the file says")
        self.new_session = self._make("New session", "Ctrl+N", tip="The next Record makes a new session")
        self.sessions = self._make("Sessions…", "Ctrl+F", tip="Find, look at and open what was recorded before")
        self.open_session = self._make("Open session folder…", "Ctrl+Shift+O")
        self.import_ = self._make("Import recordings…", "Ctrl+I", tip="CSV, MATLAB, TDMS, SigMF as a session")
        self.export_samples = self._make(
            "Export samples…", "Ctrl+Shift+E", tip="A run or the session as CSV, MATLAB, TDMS, SigMF"
        )
        self.mark = self._make("Note now", "Ctrl+M", tip="Keep a note of this moment, also while a run is recorded")
        self.report = self._make("Make report", "Ctrl+R", tip="PDF, HTML, CSV and JSON of this session")
        self.export = self._make("Export tables of the run…", "Ctrl+E")
        self.compare = self._make(
            "Process again and compare…", "Shift+F8", tip="Other correction, geometry or setup; keep or discard"
        )
        self.reprocess = self._make("Process run again with this setup", "F8")
        self.reject = self._make(
            "Reject run, or take it back", "Del", "Backspace", tip="The chosen run, or the last one; it is kept"
        )
        # the same keys mean something else in a window beside this one
        self.reject.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        self.show_rejected = self._make("Show rejected runs", "Ctrl+J")
        self.show_rejected.setCheckable(True)
        self.sound = self._make("Sound when a run is done", "Ctrl+B", tip="Once: done; twice: rejected")
        self.sound.setCheckable(True)
        self.wiring = self._make("Check the wiring…", "F7", tip="Half a minute at the antennas: are the wires right?")
        self.quit = self._make("Quit", "Ctrl+Q")
        self.reset_layout = self._make("Reset layout", "Ctrl+0")
        self.in_space = self._make("Track in 3D", "Ctrl+3")
        self.in_space.setCheckable(True)
        self.in_space.setEnabled(False)
        self.show_live = self._make("Back to the live track", "Ctrl+L")
        self.dismiss = self._make("Dismiss messages", "Ctrl+D")
        self.about = self._make("About RadarGUI", "F1")

    def enable(self, state: AppState, *, valid: bool) -> None:
        """Let be chosen what can be done in a state, with a setup that is `valid` or not."""
        free = not state.running
        self.start.setEnabled(free and valid)
        self.record.setEnabled((free or state is AppState.LIVE) and valid)
        self.stop.setEnabled(not free)
        for action in (self.open_setup, self.undo_setup, self.new_session, self.open_session):
            action.setEnabled(free)
        self.save_setup.setEnabled(valid)
        self.save_setup_as.setEnabled(valid)

    def _make(self, words: str, *keys: str, tip: str = "") -> QAction:
        action = QAction(words, self._window)
        action.setShortcuts([QKeySequence(key) for key in keys])
        action.setToolTip(f"{tip or words.rstrip('…')} ({', '.join(keys)})")
        action.setShortcutContext(Qt.ShortcutContext.ApplicationShortcut)
        self._window.addAction(action)
        return action


class RunKeys(QObject):
    """Lets Space, R and Esc do in every panel what stands on the buttons; Enter presses what has the keys instead.

    Only where words are typed Space and R are letters; a number has none, so there they act as well.
    """

    def __init__(self, window: QMainWindow, application: QApplication) -> None:
        super().__init__(window)
        self._window = window
        application.focusChanged.connect(self._follow)

    def eventFilter(self, widget: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Keep a key from what has the focus."""
        kind = event.type()
        if kind not in (QEvent.Type.ShortcutOverride, QEvent.Type.KeyPress) or not isinstance(widget, QWidget):
            return False
        if not isinstance(event, QKeyEvent) or event.modifiers() != Qt.KeyboardModifier.NoModifier:
            return False
        acts = event.key() in (Qt.Key.Key_Space, Qt.Key.Key_R) and not _takes_words(widget)
        if kind == QEvent.Type.ShortcutOverride:
            if acts:
                event.ignore()
            return acts
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            if isinstance(widget, QAbstractButton):
                widget.click()
            elif isinstance(widget, QComboBox):
                widget.showPopup()
        # while Start or Record cannot be chosen, their keys press nothing else
        return acts

    def _follow(self, old: QWidget | None, now: QWidget | None) -> None:
        if old is not None:
            old.removeEventFilter(self)
        if now is not None and belongs(now, self._window):
            now.installEventFilter(self)


def _takes_words(widget: QWidget) -> bool:
    numbers = Qt.InputMethodHint.ImhDigitsOnly | Qt.InputMethodHint.ImhFormattedNumbersOnly
    typed = widget.testAttribute(Qt.WidgetAttribute.WA_InputMethodEnabled)
    return typed and not widget.inputMethodHints() & numbers


def fill_menus(bar: QMenuBar, does: Actions, panels: Panels, theme: Theme, settings: Settings) -> QActionGroup:
    """Fill the bar; return the group that chooses the look, each action's data is its choice."""
    file = bar.addMenu("&File")
    file.addActions([does.open_setup, does.save_setup, does.save_setup_as, does.undo_setup])
    file.addSeparator()
    file.addActions([does.new_session, does.sessions, does.open_session])
    file.addSeparator()
    file.addActions([does.import_, does.export_samples])
    file.addSeparator()
    file.addActions([does.report, does.export])
    file.addSeparator()
    file.addAction(does.quit)
    run = bar.addMenu("&Run")
    run.addActions([does.start, does.record, does.stop])
    run.addSeparator()
    run.addActions([does.mark, does.pause, does.show_live, does.reprocess, does.compare])
    run.addSeparator()
    run.addActions([does.reject, does.show_rejected, does.sound])
    run.addSeparator()
    run.addAction(does.wiring)
    view = bar.addMenu("&View")
    panels.fill(view)
    view.addSeparator()
    view.addAction(does.in_space)
    looks = view.addMenu("Theme")
    group = QActionGroup(bar)
    for choice in CHOICES:
        action = looks.addAction(choice.capitalize())
        action.setCheckable(True)
        action.setData(choice)
        action.setChecked(choice == theme.choice)
        group.addAction(action)

    def choose_look(action: QAction) -> None:
        theme.apply(action.data())
        settings.put("theme", action.data())

    group.triggered.connect(choose_look)
    view.addSeparator()
    view.addActions([does.reset_layout, does.dismiss])
    bar.addMenu("&Help").addAction(does.about)
    return group


def facts(opengl: str, data_folder: Path, setup_file: Path | None) -> str:
    """Return the facts as lines of text."""
    return "\n".join(
        (
            f"RadarGUI {__version__}",
            f"Python {platform.python_version()}, PySide6 {pyside_version}, pyqtgraph {pyqtgraph.__version__}",
            f"System: {platform.platform()}",
            f"Track in 3D: {opengl}",
            f"Data folder: {data_folder}",
            f"Setup file: {setup_file or 'none'}",
        )
    )


class About(QDialog):
    """The facts, to be copied."""

    def __init__(self, text: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("About RadarGUI")
        fit_screen(self, 560, 220)
        view = QPlainTextEdit(text)
        view.setReadOnly(True)
        ends = fill(QHBoxLayout(), 1, button("Close", self.reject, default=True))
        fill(QVBoxLayout(self), view, ends, margins=(9, 9, 9, 9), spacing=6)
