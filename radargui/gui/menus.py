"""Everything the window can do, as actions with their keys, the menus in which each stands, and what Help tells."""

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
    QHBoxLayout,
    QMainWindow,
    QMenu,
    QMenuBar,
    QPlainTextEdit,
    QWidget,
)

from radargui import __version__
from radargui.gui.control.app_state import AppState
from radargui.gui.layout import Dialog, button, fill
from radargui.gui.panels import Panels, belongs
from radargui.gui.settings import Settings
from radargui.gui.theme import CHOICES, Theme
from radargui.model.resources import window_table


class Actions:
    """One attribute an action, named as in `resources/window/actions.toml`, which has their words and keys."""

    def __init__(self, window: QMainWindow) -> None:
        self._made = {name: _action(window, **one) for name, one in window_table("actions")["actions"].items()}
        for action in (self.start, self.record, self.stop):
            action.setIconText(f"{action.text()}\n{action.shortcut().toString()}")
            action.setAutoRepeat(False)
        self.in_space.setEnabled(False)

    def __getattr__(self, name: str) -> QAction:
        """Return an action by its name."""
        if name.startswith("_") or name not in self._made:
            raise AttributeError(f"no action is named {name}")
        return self._made[name]

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


def _action(
    window: QMainWindow, words: str, keys: list[str], tip: str = "", *, checkable: bool = False, in_window: bool = False
) -> QAction:
    action = QAction(words, window, checkable=checkable)
    action.setShortcuts([QKeySequence(key) for key in keys])
    action.setToolTip(f"{tip or words.rstrip('…')} ({', '.join(keys)})")
    reach = Qt.ShortcutContext
    action.setShortcutContext(reach.WindowShortcut if in_window else reach.ApplicationShortcut)
    window.addAction(action)
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
    group = QActionGroup(bar)

    def add_looks(view: QMenu) -> None:
        menu = view.addMenu("Theme")
        for choice in CHOICES:
            action = menu.addAction(choice.capitalize())
            action.setCheckable(True)
            action.setData(choice)
            action.setChecked(choice == theme.choice)
            group.addAction(action)

    def choose_look(action: QAction) -> None:
        theme.apply(action.data())
        settings.put("theme", action.data())

    group.triggered.connect(choose_look)
    several = {"panels": panels.fill, "looks": add_looks}
    for title, parts in window_table("actions")["menus"].items():
        menu = bar.addMenu(title)
        for part in parts:
            if menu.actions():
                menu.addSeparator()
            for name in part:
                several[name](menu) if name in several else menu.addAction(getattr(does, name))
    return group


def facts(opengl: str, data_folder: Path, setup_file: Path | None) -> str:
    """Return the facts as lines of text."""
    lines = (
        f"RadarGUI {__version__}",
        f"Python {platform.python_version()}, PySide6 {pyside_version}, pyqtgraph {pyqtgraph.__version__}",
        f"System: {platform.platform()}",
        f"Track in 3D: {opengl}",
        f"Data folder: {data_folder}",
        f"Setup file: {setup_file or 'none'}",
    )
    return "\n".join(lines)


class About(Dialog):
    """The facts, to be copied."""

    def __init__(self, text: str, parent: QWidget | None = None) -> None:
        super().__init__("About RadarGUI", (560, 220), parent)
        view = QPlainTextEdit(text, readOnly=True)
        self.lay_out(view, fill(QHBoxLayout(), 1, button("Close", self.reject, default=True)))
