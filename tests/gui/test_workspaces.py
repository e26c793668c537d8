"""Four workspaces: each is reached by key and mouse, Measure belongs to the plots, and nobody's view is taken away."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLabel, QTabBar, QWidget
from support.gui_sessions import make_session

from radargui.gui.control.state import AppState
from radargui.gui.layout import FormScroll, PlainLabel, Strip, Turning
from radargui.gui.main_window import MainWindow
from radargui.gui.panels import TITLES, WORKSPACES
from radargui.gui.plots.plot import Plot

MakeWindow = Callable[..., MainWindow]
SIZE = (1366, 768)
"""The laboratory's notebook."""
STRIP_PX = 64


def settle() -> None:
    for _ in range(3):
        QApplication.processEvents()


def press(window: MainWindow, digit: int, modifier: Qt.KeyboardModifier) -> None:
    QTest.keyClick(window, Qt.Key(Qt.Key.Key_0 + digit), modifier)
    settle()


def shown(window: MainWindow) -> set[str]:
    return {name for name, dock in window.panels.docks.items() if not dock.isHidden()}


def seen_of(widget: QWidget) -> QRect:
    """Return what the window shows of a widget, in its pixels."""
    return widget.visibleRegion().boundingRect()


def plot_shares(window: MainWindow) -> list[float]:
    """Return the share of the window that each plot in sight takes, the largest first."""
    areas = [seen_of(plot.viewport()).size() for plot in window.findChildren(Plot) if plot.isVisible()]
    whole = window.width() * window.height()
    return sorted((one.width() * one.height() / whole for one in areas), reverse=True)


@pytest.fixture
def small(window: MainWindow, wait_for: Any) -> MainWindow:
    window.resize(*SIZE)
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.actions_.reset_layout.trigger()
    settle()
    return window


def test_the_keys_show_the_four_workspaces(small: MainWindow) -> None:
    for number, (name, workspace) in enumerate(WORKSPACES.items(), 1):
        press(small, number, Qt.KeyboardModifier.ControlModifier)
        assert small.panels.workspace == name
        assert shown(small) == {*workspace.own, *workspace.guests}
        tabs = small.panels.tabs
        assert tabs.tabText(tabs.currentIndex()) == workspace.title
        assert small.width() == SIZE[0]
        assert small.height() == SIZE[1]


def test_the_mouse_shows_the_four_workspaces(small: MainWindow) -> None:
    tabs = small.panels.tabs
    for number, name in reversed(list(enumerate(WORKSPACES))):
        assert seen_of(tabs).contains(tabs.tabRect(number))
        QTest.mouseClick(tabs, Qt.MouseButton.LeftButton, pos=tabs.tabRect(number).center())
        settle()
        assert small.panels.workspace == name


def test_tab_comes_to_the_workspaces_and_arrows_change_them(small: MainWindow) -> None:
    tabs = small.panels.tabs
    small.bar.runs.setFocus()
    for _ in range(200):
        if tabs.hasFocus():
            break
        focused = QApplication.focusWidget()
        assert focused is not None
        QTest.keyClick(focused, Qt.Key.Key_Tab)
    assert tabs.hasFocus()
    for name in ("measure", "analyse", "sessions"):
        QTest.keyClick(tabs, Qt.Key.Key_Right)
        settle()
        assert small.panels.workspace == name
        assert tabs.hasFocus()


def test_the_key_of_a_panel_goes_where_it_is(small: MainWindow) -> None:
    for number, name in enumerate(list(TITLES)[:10], 1):
        press(small, number % 10, Qt.KeyboardModifier.AltModifier)
        assert small.panels.held[name].isVisible()
        parts = small.panels.held[name].findChildren(QWidget)
        assert any(not seen_of(part).isEmpty() for part in parts), name
    # a guest is shown where one is
    small.panels.work_in("measure")
    small.panels.go_to("runs")
    assert small.panels.workspace == "measure"
    small.panels.work_in("prepare")
    small.panels.go_to("runs")
    assert small.panels.workspace == "analyse"


def test_measure_belongs_to_the_plots(small: MainWindow) -> None:
    small.panels.work_in("measure")
    settle()
    shares = plot_shares(small)
    assert sum(shares) >= 0.65, shares
    assert shares[0] >= 0.38, shares
    largest = small.track.curves.height_plot
    area = seen_of(largest.viewport()).size()
    assert area.width() * area.height() == pytest.approx(shares[0] * SIZE[0] * SIZE[1])
    assert small.bar.height() <= STRIP_PX


def words_of(window: MainWindow) -> list[str]:
    """Return the words outside the plots: labels, buttons, choices, tabs, menus, the state; no keys, no signs."""
    texts = [window.bar.state.text, window.bar.state.badge]
    texts += [action.text() for action in window.menuBar().actions()]
    docks = window.panels.docks.values()
    texts += [dock.windowTitle() for dock in docks if dock.isVisible() and dock.titleBarWidget() is None]
    for one in window.findChildren(QWidget):
        if seen_of(one).isEmpty():
            continue
        if isinstance(one, QTabBar):
            texts += [one.tabText(tab) for tab in range(one.count()) if one.isTabVisible(tab)]
        elif isinstance(one, QComboBox):
            texts.append(one.currentText())
        elif isinstance(one, QLabel | QAbstractButton) and not isinstance(one.parent(), Plot):
            texts.append(one.text())
    return re.findall(r"[^\W\d]{2,}", re.sub(r"<[^>]*>|&\w+;|&", "", " ".join(texts)))


def test_few_words_stand_in_measure_at_rest(small: MainWindow) -> None:
    small.panels.work_in("measure")
    settle()
    words = words_of(small)
    assert len(words) <= 45, words


def test_a_start_with_a_setup_that_is_right_measures(make_window: MakeWindow, setup_path: Path, wait_for: Any) -> None:
    first = make_window(setup_path)
    assert first.panels.workspace == "measure"
    first.panels.work_in("sessions")
    first.close()
    wait_for(first.isHidden)
    assert make_window(None).panels.workspace == "measure"


def test_each_workspace_stays_as_it_was_left(small: MainWindow) -> None:
    small.panels.work_in("measure")
    small.panels.docks["planes"].close()
    small.panels.resizeDocks([small.panels.docks["track"]], [700], Qt.Orientation.Horizontal)
    settle()
    width = small.panels.docks["track"].width()
    for name in ("analyse", "prepare", "sessions", "measure"):
        small.panels.work_in(name)
        settle()
    assert "planes" not in shown(small)
    assert small.panels.docks["track"].width() == width


def test_record_goes_to_measure_and_its_result_takes_nobody_away(window: MainWindow, wait_for: Any) -> None:
    window.panels.work_in("prepare")
    window.actions_.record.trigger()
    assert window.panels.workspace == "measure"
    window.panels.work_in("prepare")
    wait_for(lambda: window.control.state in (AppState.DONE, AppState.FAILED))
    wait_for(lambda: not window.jobs.running)
    assert window.control.state is AppState.DONE
    assert window.panels.workspace == "prepare"
    # nor does a message, or a click on nothing
    window.board.post("error", "something went wrong")
    settle()
    assert window.panels.workspace == "prepare"
    window.actions_.start.trigger()
    assert window.panels.workspace == "measure"


def test_a_run_that_is_chosen_is_analysed_and_a_session_too(window: MainWindow, record_one: Any, wait_for: Any) -> None:
    record_one(window)
    assert window.panels.workspace == "measure"
    table = window.runs.table
    table.clearSelection()
    first = table.visualRect(table.model().index(0, 1)).center()
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=first)
    settle()
    assert window.panels.workspace == "analyse"
    assert window.run.isVisible()
    session = window.control.session
    assert session is not None
    path = session.path
    window.actions_.new_session.trigger()
    window.actions_.sessions.trigger()
    assert window.panels.workspace == "sessions"
    browser = window.sessions.browser
    wait_for(lambda: not browser.looks.busy and browser.model.entries)
    browser.table.choose(lambda one: one.path == path)
    browser.review.click()
    wait_for(lambda: window.control.session is not None)
    assert window.panels.workspace == "analyse"


def test_messages_leave_the_buttons_and_the_titles_of_a_table_alone(
    small: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    small.sessions.open(make_session(tmp_path / "data", 4))
    wait_for(lambda: small.runs.model.entries and not small.jobs.running)
    small.panels.work_in("analyse")
    small.show_view("table")
    settle()
    small.board.post("warning", "The cable of receiver 2 is loose.")
    wait_for(small.place.isVisible)
    settle()
    place = QRect(small.place.mapTo(small, QPoint()), small.place.size())
    for one in (small.series.compare, small.series.table.horizontalHeader()):
        assert one.isVisible()
        assert not place.intersects(QRect(one.mapTo(small, QPoint()), one.size()))
    tabs = small.run.tabs
    foot = tabs.mapTo(small, QPoint(0, tabs.height()))
    assert place.bottom() + 1 == foot.y()
    # over a plot at the top, as before
    small.show_view("height")
    settle()
    assert small.place.mapTo(small, QPoint()) == tabs.mapTo(small, QPoint())
    small.board.clear()
    wait_for(lambda: not small.strip.findChildren(Strip))


def test_messages_take_no_row_and_lie_over_the_panels(small: MainWindow, wait_for: Any) -> None:
    small.panels.work_in("measure")
    settle()
    assert small.place.isHidden()
    below, size = small.bar.mapTo(small, QPoint(0, small.bar.height())), small.panels.size()
    assert small.panels.mapTo(small, QPoint()).y() - below.y() <= 2
    keys = QApplication.focusWidget()
    small.board.post("warning", "The cable of receiver 2 is loose.")
    wait_for(small.place.isVisible)
    settle()
    assert small.panels.size() == size
    assert QApplication.focusWidget() is keys
    assert small.place.mapTo(small, QPoint()).y() >= below.y()
    # in each workspace over its plot, not over fields and choices
    for name, plot in (
        ("measure", small.track.curves.height_plot),
        ("analyse", small.run.tabs),
        ("prepare", small.sketch),
        ("sessions", small.browser.thumbnails),
    ):
        small.panels.work_in(name)
        settle()
        assert small.place.mapTo(small, QPoint()) == plot.mapTo(small, QPoint()), name
        assert small.place.width() == plot.width(), name
    small.panels.work_in("measure")
    settle()
    (row,) = small.strip.findChildren(Strip)
    assert seen_of(row).size() == row.size()
    small.actions_.dismiss.trigger()
    settle()
    assert small.place.isHidden()


def test_a_form_beside_a_drawing_gets_the_width_that_its_words_come_to_need(qtbot: Any) -> None:
    words, drawing = PlainLabel("few"), QWidget()
    words.setWordWrap(False)
    form = FormScroll(words)
    both = Turning(100, (drawing, 1, 3), (form, 1, 1))
    qtbot.addWidget(both)
    both.resize(800, 300)
    both.show()
    settle()
    assert drawing.width() > 500
    words.setText("what the drops say of each antenna, a line each " * 2)
    settle()
    assert form.content.width() <= form.viewport().width()
    assert form.content.minimumSizeHint().width() > 300
    assert drawing.width() + form.width() <= 800


def test_who_reads_a_moment_stays_with_the_channels(small: MainWindow, wait_for: Any) -> None:
    press(small, 1, Qt.KeyboardModifier.ControlModifier)
    small.actions_.moment.trigger()
    wait_for(lambda: "A moment read" in small.channels.words.text())
    assert small.panels.workspace == "prepare"
    assert small.channels.isVisible()
