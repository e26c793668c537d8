"""Keys: Tab enters only what is seen, and nothing that is not seen changes; Space, R and Esc do what they say."""

from __future__ import annotations

import re
import threading
from typing import Any

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QComboBox,
    QLineEdit,
    QPlainTextEdit,
    QToolButton,
    QWidget,
)

from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.panels import TITLES, FocusMark
from radargui.gui.setup.setup_model import SetupModel
from radargui.model.setup import plain


def values(model: SetupModel) -> dict[str, Any]:
    """Return all that the forms can change, key by key."""
    return flat(model._draft)


def flat(values: Any, name: str = "") -> dict[str, Any]:
    if isinstance(values, dict):
        return {key: one for part in values for key, one in flat(values[part], f"{name}.{part}").items()}
    if isinstance(values, list | tuple):
        return {key: one for number, part in enumerate(values) for key, one in flat(part, f"{name}[{number}]").items()}
    return {name: values}


def has_keys() -> QWidget:
    focused = QApplication.focusWidget()
    assert focused is not None
    return focused


def seen(widget: QWidget) -> bool:
    return widget.isVisible() and widget.mapTo(widget.window(), widget.rect().bottomRight()).x() > 0


def raised(window: MainWindow, name: str) -> None:
    number = 1 + list(TITLES).index(name)
    if number <= 10:
        QTest.keyClick(window, Qt.Key.Key_0 + number % 10, Qt.KeyboardModifier.AltModifier)
    else:
        # the digits are used up: the menu View has it
        window.panels.go_to(name)
    QApplication.processEvents()


@pytest.mark.parametrize("panel", TITLES, ids=TITLES.values())
def test_typing_by_tab_only_changes_nothing_that_is_not_seen(active: MainWindow, panel: str) -> None:
    window = active
    window.bar.runs.setFocus()
    raised(window, panel)
    mark = window.findChild(FocusMark)
    assert mark is not None
    start, visited, panels = has_keys(), [], []
    before = values(window.setup_model)
    for _ in range(200):
        focused = has_keys()
        visited.append(focused)
        assert not focused.visibleRegion().isEmpty(), focused
        assert mark.widget() is focused
        assert mark.isVisible()
        panels.append(next((name for name, dock in window.panels.docks.items() if dock.isAncestorOf(focused)), "bar"))
        # letters and digits as someone would who looks elsewhere; no key that acts, not even by a closed list
        if not isinstance(focused, QAbstractButton | QComboBox):
            QTest.keyClicks(focused, "5")
        QTest.keyClick(focused, Qt.Key.Key_Tab)
        if has_keys() is start:
            break
    else:
        pytest.fail("Tab never came back")
    assert panel in panels or panel in ("track", "planes", "geometry")
    changed = {key for key, value in values(window.setup_model).items() if before.get(key) != value}
    # where it is prepared one of both forms is in front, elsewhere there is none
    shown = panel in ("hardware", "antennas", "geometry", "channels")
    forms = {one.objectName() for one in visited}
    for key in changed:
        # fields are called by their keys, which are counted from 1
        name = re.sub(r"\[(\d)\]", lambda at: f"[{int(at[1]) + 1}]", key.removeprefix("."))
        assert name in forms, f"{key} changed unseen"
    assert bool(changed) == shown, changed


def test_a_layout_that_was_remembered_hides_what_stands_behind(
    make_window: Any, own_window: MainWindow, wait_for: Any
) -> None:
    raised(own_window, "scopes")
    raised(own_window, "session")
    assert own_window.panels.workspace == "measure"
    own_window.close()
    wait_for(own_window.isHidden)
    again = make_window(None)
    docks = again.panels.docks
    wait_for(lambda: docks["session"].widget().isVisible())
    assert not docks["runs"].widget().isVisible()
    assert not docks["hardware"].widget().isVisible()


def test_the_key_of_a_panel_raises_it_and_never_hides_it(active: MainWindow) -> None:
    for name, dock in active.panels.docks.items():
        for _ in range(2):
            raised(active, name)
            assert seen(dock.widget()), name
    active.panels.docks["track"].close()
    raised(active, "track")
    assert seen(active.panels.docks["track"].widget())


def test_the_order_of_tab_follows_the_layout(active: MainWindow) -> None:
    for panel in ("hardware", "antennas", "session"):
        raised(active, panel)
        dock, rows = active.panels.docks[panel], []
        content = next(one for one in dock.widget().findChildren(QWidget) if one.objectName() == "form")
        while dock.isAncestorOf(has_keys()):
            place = has_keys().mapTo(content, has_keys().rect().center())
            rows.append((place.y() // 12, place.x()))
            QTest.keyClick(has_keys(), Qt.Key.Key_Tab)
        assert len(rows) > 4
        assert rows == sorted(rows)
        # and whoever comes in again from outside sees where, though it was scrolled
        raised(active, panel)
        assert dock.isAncestorOf(has_keys())
        assert not has_keys().visibleRegion().isEmpty()


def test_the_keys_come_to_the_gain_from_the_scopes(active: MainWindow) -> None:
    active.scopes.set_receivers(4, 10.0)
    raised(active, "scopes")
    active.scopes.pause.setFocus()
    QTest.keyClick(has_keys(), Qt.Key.Key_Tab)
    assert has_keys() is active.scopes.time.gain
    active.scopes.set_receivers(3, 10.0)


def test_the_wheel_over_a_form_changes_no_choice(active: MainWindow) -> None:
    before = plain(active.setup_model.setup)
    raised(active, "hardware")
    for box in active.hardware.findChildren(QComboBox):
        if box.isVisible():
            at = QPointF(box.rect().center())
            wheel = QWheelEvent(
                at,
                QPointF(box.mapToGlobal(at)),
                QPoint(0, 0),
                QPoint(0, -120),
                Qt.MouseButton.NoButton,
                Qt.KeyboardModifier.NoModifier,
                Qt.ScrollPhase.NoScrollPhase,
                False,
            )
            QApplication.sendEvent(box, wheel)
    assert plain(active.setup_model.setup) == before
    assert active.hardware.kind == "simulated"


def everything_that_takes_keys(window: MainWindow) -> list[QWidget]:
    return [one for one in window.findChildren(QWidget) if one.isVisible() and one.isEnabled() and tabbed(one)]


def tabbed(widget: QWidget) -> bool:
    return bool(widget.focusPolicy() & Qt.FocusPolicy.TabFocus) and widget.focusProxy() is None


def test_space_and_r_act_wherever_the_keys_go_but_are_typed_into_words(
    own: MainWindow, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    for name in ("start", "record"):
        action = getattr(own.actions_, name)
        action.triggered.disconnect()
        action.triggered.connect(lambda _checked=False, name=name: asked.append(name))
    words = 0
    for panel in TITLES:
        raised(own, panel)
        for widget in everything_that_takes_keys(own):
            for key, name in ((Qt.Key.Key_Space, "start"), (Qt.Key.Key_R, "record")):
                asked.clear()
                widget.setFocus()
                before = values(own.setup_model)
                text = typed(widget)
                QTest.keyClick(widget, key)
                takes_words = isinstance(widget, QPlainTextEdit) or widget.objectName().startswith(WORDS)
                assert asked == ([] if takes_words else [name]), widget
                assert takes_words == (typed(widget) != text), widget
                assert takes_words or values(own.setup_model) == before
                words += takes_words
            assert QApplication.activePopupWidget() is None
    assert words >= 10
    for action in (own.actions_.start, own.actions_.record):
        action.setEnabled(False)
    raised(own, "antennas")
    asked.clear()
    button = own.antennas.table.add
    button.setFocus()
    QTest.keyClick(button, Qt.Key.Key_Space)
    assert own.setup_model.n_receivers == 3
    QTest.keyClick(button, Qt.Key.Key_Return)
    assert own.setup_model.n_receivers == 4
    assert not asked


WORDS = ("session.data_folder", "session.operator", "session.sample", "session.target", "search.")
"""What the names of fields begin with that words are typed into."""


def typed(widget: QWidget) -> str:
    if isinstance(widget, QPlainTextEdit):
        return widget.toPlainText()
    return widget.text() if isinstance(widget, QLineEdit) else ""


def test_space_starts_r_records_and_esc_stops_at_once(own: MainWindow, wait_for: Any) -> None:
    # armed for as long as it takes to see that
    own.setup_model.assign("simulation.scene", "rest")
    own.setup_model.assign("simulation.rest_s", 60.0)
    raised(own, "hardware")
    QTest.keyClick(has_keys(), Qt.Key.Key_Space)
    wait_for(lambda: own.control.state is AppState.LIVE)
    QTest.keyClick(own.focusWidget() or own, Qt.Key.Key_Escape)
    assert own.control.state is AppState.STOPPING
    wait_for(lambda: not own.control.state.running)
    QTest.keyClick(own.focusWidget() or own, Qt.Key.Key_R)
    wait_for(lambda: own.control.state is AppState.ARMED)
    raised(own, "runs")
    QTest.keyClick(own.focusWidget() or own, Qt.Key.Key_Escape)
    assert own.control.state is AppState.STOPPING
    wait_for(lambda: not own.control.state.running)


def test_the_keys_stand_on_their_buttons(active: MainWindow) -> None:
    texts = [button.text() for button in active.bar.findChildren(QToolButton) if button.text()]
    assert texts == ["Start\nSpace", "Record\nR", "Stop\nEsc", "♪"]


def test_messages_and_progress_move_nothing(active: MainWindow, wait_for: Any) -> None:
    gate = threading.Event()
    parts = (*active.bar.findChildren(QToolButton), active.bar, active.panels, *active.panels.docks.values())
    places = [(part, part.mapTo(active, part.rect().topLeft()), part.size()) for part in parts]
    size, least = active.size(), active.minimumSizeHint()

    def nothing_moved() -> bool:
        QApplication.processEvents()
        here = [(part, part.mapTo(active, part.rect().topLeft()), part.size()) for part in parts]
        return here == places and active.size() == size and active.minimumSizeHint() == least

    bar = active.place.verticalScrollBar()
    for text in ("one message that takes a whole line of the window, " * 2, "another one, " * 8):
        active.board.post("warning", text)
        assert nothing_moved()
        assert bar.maximum() == 0, "two messages need no scrolling"
    for number in range(6):
        active.board.post("error" if number % 2 else "warning", f"message {number}: " + "what to do about it " * 12)
        assert nothing_moved()
    active.work.start("something long", lambda _task: gate.wait(20.0), lambda _done: None, lambda _error: None)
    assert nothing_moved()
    gate.set()
    wait_for(lambda: not active.work.busy)
    assert nothing_moved()
    has_keys()
    active.bar.runs.setFocus()
    QTest.keyClick(has_keys(), Qt.Key.Key_Tab)
    assert active.strip.isAncestorOf(has_keys())
    active.board.clear()
    assert nothing_moved()
