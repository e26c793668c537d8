"""The look: edges that are seen, titles said once, letters that stay as large as they are, colours of one meaning."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QImage
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QCheckBox,
    QComboBox,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QSpinBox,
    QTabBar,
    QVBoxLayout,
    QWidget,
)
from pytestqt.qtbot import QtBot

from radargui.gui.control.state import LARGE_WORDS
from radargui.gui.main_window import MainWindow
from radargui.gui.panels import TITLES
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import DARK, LIGHT, Colours, Theme, ThemeChoice


def luminance(colour: QColor) -> float:
    """Return the relative luminance (WCAG 2.2)."""
    parts = np.array([colour.redF(), colour.greenF(), colour.blueF()])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one: QColor, other: QColor) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def edge_contrast(image: QImage, window: QColor) -> float:
    """Return the largest contrast to the window of what stands at a widget's left edge, half-way down."""
    return max(contrast(image.pixelColor(x, image.height() // 2), window) for x in range(6))


@pytest.mark.parametrize("choice", ["light", "dark"])
def test_every_field_has_an_edge_that_is_seen(qtbot: QtBot, theme: Theme, choice: ThemeChoice) -> None:
    theme.apply(choice)
    holder = QWidget()
    qtbot.addWidget(holder)
    column = QVBoxLayout(holder)
    kinds: tuple[type[QWidget], ...] = (QLineEdit, QSpinBox, QComboBox, QCheckBox, QPushButton, QPlainTextEdit)
    fields = [kind() for kind in kinds]
    for field in fields:
        column.addWidget(field)
    holder.resize(240, 400)
    holder.show()
    QApplication.processEvents()
    window = QColor(theme.colours.window)
    for field in fields:
        # WCAG 2.2, 1.4.11: three to one for what tells a field from what is around it
        assert edge_contrast(field.grab().toImage(), window) >= 3.0, type(field).__name__
    # none of them shows the colour that only makes the edge
    assert holder.palette().color(holder.palette().ColorRole.Window).name() == theme.colours.window


def tabs_of(window: MainWindow) -> dict[str, QTabBar]:
    bars = window.panels.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly)
    return {bar.tabText(tab): bar for bar in bars if bar.isVisible() for tab in range(bar.count())}


def titled(window: MainWindow) -> set[str]:
    """Return the panels above which their title stands."""
    docks = window.panels.docks.values()
    return {dock.windowTitle() for dock in docks if not dock.isHidden() and dock.titleBarWidget() is None}


def test_a_panel_says_its_title_once(window: MainWindow, wait_for: Any) -> None:
    window.resize(1400, 900)
    window.panels.work_in("measure")
    window.actions_.reset_layout.trigger()
    every, tabs = {"Track", "IQ scopes", "IQ plane", "Last drops", "Runs", "Session"}, {"Last drops", "Runs", "Session"}
    wait_for(lambda: set(tabs_of(window)) == tabs and titled(window) == every - tabs)
    assert "Track" in titled(window)
    # the tab does what the title's buttons do
    bar = tabs_of(window)["Session"]
    tab = next(tab for tab in range(bar.count()) if bar.tabText(tab) == "Session")
    assert "right click" in bar.tabToolTip(tab)
    bar.tabBarDoubleClicked.emit(tab)
    session = window.panels.docks["session"]
    assert session.isFloating()
    wait_for(lambda: session.titleBarWidget() is None)
    session.setFloating(False)
    wait_for(lambda: "Session" in tabs_of(window) and "Session" not in titled(window))
    menu = window.titles.menu_of(session)
    menu.actions()[1].trigger()
    assert session.isHidden()
    window.panels.docks["runs"].close()
    # alone it has no tab, so its title stands above it
    wait_for(lambda: "Last drops" in titled(window))
    # and what belongs to another workspace leaves no tab behind
    window.panels.work_in("analyse")
    wait_for(lambda: not tabs_of(window) and titled(window) == {"Runs", "Run", "Result"})
    window.panels.work_in("sessions")
    wait_for(lambda: not tabs_of(window) and titled(window) == {"Session", "All sessions"})


@pytest.mark.parametrize("choice", ["light", "dark"])
def test_the_buttons_of_a_title_are_seen_in_every_look(window: MainWindow, choice: ThemeChoice) -> None:
    window.theme.apply(choice)
    QApplication.processEvents()
    for name in ("float", "close"):
        button = window.panels.docks["track"].findChild(QAbstractButton, f"qt_dockwidget_{name}button")
        assert button is not None
        image = button.icon().pixmap(32).toImage()
        seen = [image.pixelColor(x, y) for x in range(image.width()) for y in range(image.height())]
        darkest = max(
            (one for one in seen if one.alpha() > 250),
            key=lambda one: contrast(one, QColor(window.theme.colours.window)),
        )
        assert contrast(darkest, QColor(window.theme.colours.window)) > 7.0
        assert button.toolTip()


def test_the_letters_of_the_state_stay_as_large_as_they_are(window: MainWindow) -> None:
    view = window.bar.state
    sizes = set()
    for word in LARGE_WORDS:
        for detail in ("", "drop 1: e = 0.8002 ± 0.0011", "words " * 60):
            view.show_state(word, detail, "good")
            view.grab()
            sizes.add(view.word_font().pointSizeF())
    assert len(sizes) == 1
    assert sizes.pop() > 20.0


def hue(colour: str) -> float | None:
    """Return the hue in degrees; None of a grey."""
    found = QColor(colour)
    return found.hsvHueF() * 360.0 if found.hsvSaturationF() > 0.35 else None


def alike(one: str, other: str) -> bool:
    a, b = hue(one), hue(other)
    return a is not None and b is not None and abs((a - b + 180.0) % 360.0 - 180.0) < 15.0


TOGETHER = (
    ("i", "q", "gap"),
    ("i", "q", "receivers.2", "receivers.3"),
    ("track", "mark", "good", "alarm"),
    ("receivers.0", "receivers.1", "receivers.2", "receivers.3", "gap"),
)
"""Roles that stand in one plot, beside those that a plot of the window is found to have."""


@pytest.mark.parametrize("colours", [LIGHT, DARK])
def test_no_two_meanings_that_stand_together_have_one_hue(colours: Colours) -> None:
    for roles in TOGETHER:
        for one, other in combinations(roles, 2):
            assert not alike(colours.role(one), colours.role(other)), (one, other)


def test_no_plot_of_the_window_has_one_hue_for_two_roles(window: MainWindow, record_one: Any) -> None:
    record_one(window)
    seen = 0
    for name in TITLES:
        window.panels.go_to(name)
        QApplication.processEvents()
    for plot in window.findChildren(Plot):
        roles = {role for _, role, *_ in plot._pens}
        seen += len(roles) > 1
        for one, other in combinations(sorted(roles), 2):
            for colours in (LIGHT, DARK):
                assert not alike(colours.role(one), colours.role(other)), (plot, one, other)
    assert seen >= 10
    roles = {one.role for one in window.sketch.places}
    for one, other in combinations(sorted(roles), 2):
        assert not alike(LIGHT.role(one), LIGHT.role(other))
