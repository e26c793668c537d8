"""What every plot can do: zoom that stays, cursors that read values, copies with names and units."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import QByteArray, QPoint, QPointF, Qt
from PySide6.QtGui import QImage, QWheelEvent
from PySide6.QtSvg import QSvgRenderer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QVBoxLayout, QWidget

from radargui.gui.layout import fill
from radargui.gui.mnemonics import without
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import DARK, Theme

TIME_S = np.linspace(0.0, 1.0, 1001)


@pytest.fixture(autouse=True)
def clipboard_is_left_empty(qapp: QApplication) -> Iterator[None]:
    """Leave nothing there: Qt's offscreen platform crashes at the end of the program over what Python put there."""
    yield
    qapp.clipboard().clear()


def shown(qtbot: Any, plot: Plot) -> Plot:
    # in a window of its own: a plot that is closed itself does not follow the theme any more
    around = QWidget()
    fill(QVBoxLayout(around), plot)
    qtbot.addWidget(around)
    around.resize(500, 300)
    around.show()
    plot.around = around
    QApplication.processEvents()
    return plot


@pytest.fixture
def plot(qtbot: Any, theme: Theme) -> Plot:
    plot = Plot(theme, "time [s]", "Rx 1 [V]")
    plot.still_line("i", "I").setData(TIME_S, np.cos(2.0 * np.pi * 5.0 * TIME_S))
    plot.still_line("q", "Q").setData(TIME_S, np.full(TIME_S.size, 0.25))
    return shown(qtbot, plot)


def wheel(plot: Plot, steps: int = 3) -> None:
    at = QPointF(plot.viewport().rect().center())
    angle = QPoint(0, 120 * steps)
    event = QWheelEvent(
        at,
        QPointF(plot.viewport().mapToGlobal(at.toPoint())),
        QPoint(),
        angle,
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(plot.viewport(), event)
    QApplication.processEvents()


def x_span(plot: Plot) -> float:
    left, right = plot.view.viewRange()[0]
    return float(right - left)


def test_the_wheel_and_keys_zoom_and_home_shows_all(plot: Plot) -> None:
    whole = x_span(plot)
    wheel(plot)
    assert x_span(plot) < 0.9 * whole
    assert plot.view.zoomed
    QTest.keyClick(plot, Qt.Key.Key_Plus)
    closer = x_span(plot)
    middle = plot.view.viewRange()[0][0]
    QTest.keyClick(plot, Qt.Key.Key_Right)
    assert plot.view.viewRange()[0][0] == pytest.approx(middle + 0.2 * closer)
    QTest.keyClick(plot, Qt.Key.Key_Home)
    QApplication.processEvents()
    assert x_span(plot) == pytest.approx(whole)
    assert not plot.view.zoomed


def test_a_live_plot_that_is_zoomed_stays_so_until_all_is_asked_for(qtbot: Any, theme: Theme) -> None:
    plot = shown(qtbot, Plot(theme, "time [s]", "z [mm]", live=True))
    plot.setXRange(-3.0, 0.0, padding=0)
    plot.setYRange(-1.0, 1.0, padding=0)
    wheel(plot)
    zoomed = plot.view.viewRange()
    plot.setXRange(-5.0, 0.0, padding=0)
    plot.setYRange(-2.0, 2.0, padding=0)
    assert plot.view.viewRange() == zoomed
    for part in (QTest.mouseDClick, QTest.mouseRelease):
        part(plot.viewport(), Qt.MouseButton.LeftButton, pos=plot.viewport().rect().center())
    QApplication.processEvents()
    assert plot.view.viewRange() == [[-5.0, 0.0], [-2.0, 2.0]]


def test_new_contents_end_the_zoom_of_a_plot_that_is_not_live(plot: Plot) -> None:
    wheel(plot)
    plot.setXRange(2.0, 3.0, padding=0)
    assert plot.view.viewRange()[0] == [2.0, 3.0]
    assert not plot.view.zoomed


def test_linked_time_bases_zoom_together_and_back(qtbot: Any, theme: Theme) -> None:
    first, second = (shown(qtbot, Plot(theme, "time [s]", "[V]", left_px=50, live=True)) for _ in range(2))
    first.setXLink(second)
    second.setXRange(-3.0, 0.0, padding=0)
    wheel(first)
    assert second.view.viewRange()[0] == pytest.approx(first.view.viewRange()[0])
    assert second.view.zoomed
    first.view.show_all()
    assert second.view.viewRange()[0] == pytest.approx([-3.0, 0.0])
    assert not second.view.zoomed


def test_the_cursors_stand_on_samples_and_say_time_volts_and_frequency(plot: Plot) -> None:
    QTest.keyClick(plot, Qt.Key.Key_C)
    cursors = plot.cursors
    assert cursors is not None
    # near two maxima of the 5 Hz line, not on them
    cursors.put(0, 0.2004, 1.0)
    cursors.put(1, 0.3996, 1.0)
    a, b, difference = cursors.text.splitlines()
    assert a.startswith("A  0.2")
    assert "1.0" in a
    assert b.startswith("B  0.4")
    assert "= 5 Hz" in difference
    assert "0.00" in difference.rpartition("Hz")[2]
    QTest.keyClick(plot, Qt.Key.Key_B)
    QTest.keyClick(plot, Qt.Key.Key_Left)
    assert cursors.marks[1].pos().x() < 0.4
    QTest.keyClick(plot, Qt.Key.Key_C)
    assert plot.cursors is None


def test_a_copied_picture_is_white_and_of_vectors_whatever_the_theme(plot: Plot, theme: Theme) -> None:
    theme.apply("dark")
    plot.setFocus()
    QTest.keyClick(plot, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    data = QApplication.clipboard().mimeData()
    svg = bytes(data.data("image/svg+xml").data())
    assert QSvgRenderer(QByteArray(svg)).isValid()
    assert b"<image" not in svg, "pixels are no vectors"
    for words in (b"time [s]", b"Rx 1 [V]", b">I<", b">Q<"):
        assert words in svg
    assert bytes(data.data("application/pdf").data()).startswith(b"%PDF")
    image = QImage(data.imageData())
    assert image.pixelColor(2, 2) == Qt.GlobalColor.white
    assert plot.colour("text") == DARK.text, "the plot itself stays dark"
    assert plot.grab().toImage().pixelColor(2, 2).name() == DARK.base


def test_a_live_plot_is_copied_without_pixels(qtbot: Any, theme: Theme) -> None:
    plot = shown(qtbot, Plot(theme, "time [s]", "z [mm]", live=True))
    plot.fast_line("track", "z").setData(TIME_S, TIME_S)
    plot.copy_image()
    assert b"<image" not in bytes(QApplication.clipboard().mimeData().data("image/svg+xml").data())


def test_copied_data_have_names_and_units_and_every_sample(plot: Plot) -> None:
    QTest.keyClick(plot, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    lines = QApplication.clipboard().text().splitlines()
    assert lines[0] == "time [s]\tI [V]\tQ [V]"
    assert len(lines) == 1 + TIME_S.size
    values = np.array([[float(cell) for cell in line.split("\t")] for line in lines[1:]])
    np.testing.assert_allclose(values[:, 0], TIME_S, rtol=1e-8)
    np.testing.assert_allclose(values[:, 1], np.cos(2.0 * np.pi * 5.0 * TIME_S), atol=1e-8)


def test_curves_with_times_of_their_own_have_columns_of_their_own(plot: Plot) -> None:
    plot.marker("mark", name="peaks").setData([0.2, 0.4], [1.0, 1.0])
    plot.copy_data()
    lines = QApplication.clipboard().text().splitlines()
    assert lines[0] == "time [s]\tI [V]\tQ [V]\ttime [s] (2)\tpeaks [V]"
    assert lines[2].split("\t")[3:] == ["0.4", "1"]
    assert lines[3].split("\t")[3:] == ["", ""]


def test_of_a_zoomed_plot_what_is_seen_is_copied(plot: Plot) -> None:
    plot.view.meant(Qt.Key.Key_Plus)()
    low, high = plot.view.viewRange()[0]
    x = plot.columns()[0][1]
    assert x.size < TIME_S.size
    assert x.min() >= low
    assert x.max() <= high


def test_the_menu_offers_the_same_and_says_the_keys(plot: Plot) -> None:
    entries = {
        without(action.text()): action.shortcut().toString() for action in plot.menu().actions() if action.text()
    }
    assert entries == {
        "Show all (double click)": "Home",
        "Two cursors": "C",
        "Copy image": "Ctrl+C",
        "Copy data": "Ctrl+Shift+C",
    }


def test_no_plot_of_the_window_is_without_these(window: Any) -> None:
    window.run.tabs.page("steps"), window.run.tabs.page("phase")
    plots = window.findChildren(pg.PlotWidget)
    assert len(plots) >= 15
    assert all(isinstance(plot, Plot) for plot in plots)
    assert all(one == [True, True] for plot in plots for one in [plot.view.state["mouseEnabled"]])
