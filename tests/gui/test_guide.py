"""The first steps tick themselves off as things happen, and empty plots say what to do next."""

from __future__ import annotations

import threading
from typing import Any

import pytest
from PySide6.QtCore import QRect, Qt
from PySide6.QtWidgets import QApplication, QLabel, QTabBar, QWidget

from radargui.experiment.processing_apart import ProcessingHere
from radargui.gui.control.state import AppState
from radargui.gui.guide import is_empty
from radargui.gui.main_window import MainWindow
from radargui.gui.plots.plot import Plot


def done(window: MainWindow) -> list[str]:
    return [name for name, step in window.guide.steps.items() if step.done]


def upcoming(window: MainWindow) -> str:
    return window.guide.upcoming if window.guide.isVisible() else ""


def over(window: MainWindow, widget: QWidget, part: QRect | None = None) -> bool:
    """Return whether the bubble lies over a widget."""
    part = part or widget.rect()
    return window.guide.geometry().intersects(QRect(widget.mapTo(window, part.topLeft()), part.size()))


def test_each_step_ticks_itself_off_when_it_has_happened(window: MainWindow, wait_for: Any) -> None:
    go = threading.Event()

    class Held(ProcessingHere):
        """Does a job once it may."""

        def process(self, *job: Any) -> Any:
            assert go.wait(60.0)
            return super().process(*job)

    window.control.processing = Held
    guide = window.guide
    # where the antennas are not seen
    window.panels.work_in("measure")
    window.actions_.guide.trigger()
    assert guide.isVisible()
    assert (done(window), upcoming(window)) == ([], "source")
    # the form is not seen here: it points at the way there
    assert guide.target is window.panels.tabs
    # what only could have happened is not ticked off
    window.hardware.choose("simulated")
    assert done(window) == []
    window.hardware.source.activated.emit(0)
    assert (done(window), upcoming(window)) == (["source"], "antennas")
    guide.go.click()
    wait_for(lambda: "antennas" in done(window))
    assert window.antennas.isVisible()
    window.actions_.start.trigger()
    wait_for(lambda: "monitor" in done(window))
    assert upcoming(window) == "arm"
    assert guide.target is window.bar.buttons[1]
    assert not over(window, window.bar.buttons[1])
    assert not guide.go.isVisible()
    window.actions_.record.trigger()
    wait_for(lambda: "arm" in done(window))
    wait_for(lambda: "drop" in done(window))
    assert "read" not in done(window)
    go.set()
    wait_for(lambda: window.control.state is AppState.DONE)
    assert done(window) == [*guide.steps][:-1]
    assert upcoming(window) == "end"
    assert guide.target is window.drops
    assert "That was all" in guide.accessibleName()
    guide.ends.click()
    assert not guide.isVisible()
    # called again it begins anew
    window.actions_.guide.trigger()
    assert done(window) == []


def test_who_has_the_panel_before_him_looks_at_it(window: MainWindow) -> None:
    window.panels.go_to("antennas")
    window.actions_.guide.trigger()
    assert (done(window), upcoming(window)) == ([], "source")
    window.hardware.source.activated.emit(0)
    assert (done(window), upcoming(window)) == (["source", "antennas"], "monitor")


def test_the_bubble_lies_beside_the_thing_wherever_that_is(window: MainWindow, wait_for: Any) -> None:
    window.panels.work_in("prepare")
    window.panels.go_to("hardware")
    for size in ((1366, 768), (960, 540), (1920, 1080)):
        window.resize(*size)
        window.actions_.reset_layout.trigger()
        window.panels.go_to("hardware")
        window.actions_.guide.trigger()
        QApplication.processEvents()
        assert window.guide.target is window.hardware.source, size
        assert window.rect().contains(window.guide.geometry()), size
        assert not over(window, window.hardware.source), size
    # behind its tab: that is what is to be clicked
    window.hardware.source.activated.emit(0)
    QApplication.processEvents()
    bar = window.guide.target
    assert isinstance(bar, QTabBar)
    assert window.guide.go.isVisible()
    (place,) = (tab for tab in range(bar.count()) if bar.tabText(tab) == "Antenna calibration")
    assert not over(window, bar, bar.tabRect(place))


def test_nothing_counts_while_nobody_looks_and_esc_puts_it_away(
    own_window: MainWindow, wait_for: Any, qtbot: Any
) -> None:
    own_window.hardware.source.activated.emit(0)
    assert done(own_window) == []
    own_window.actions_.guide.trigger()
    own_window.guide.ends.setFocus()
    qtbot.keyClick(own_window.guide.ends, Qt.Key.Key_Escape)
    assert not own_window.guide.isVisible()


def test_it_is_shown_at_the_very_first_start_only(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    first = make_window(setup_path)
    first.guide.show_at_first()
    assert first.guide.isVisible()
    first.close()
    wait_for(first.isHidden)
    again = make_window(None)
    again.guide.show_at_first()
    assert not again.guide.isVisible()


def test_who_used_the_program_before_is_not_guided(make_window: Any, setup_path: Any, settings_path: Any) -> None:
    window = make_window(setup_path)
    window.settings.put("geometry", window.saveGeometry())
    window.guide.show_at_first()
    assert not window.guide.isVisible()


def said(window: MainWindow, name: str) -> str:
    window.panels.go_to(name)
    QApplication.processEvents()
    window.empty.refresh()
    label = window.empty.labels.get(name)
    return label.text() if label is not None else ""


@pytest.mark.parametrize("size", [(1366, 720), (944, 500)])
def test_an_empty_plot_says_what_to_do_within_its_axes(window: MainWindow, size: tuple[int, int]) -> None:
    window.resize(*size)
    window.actions_.reset_layout.trigger()
    QApplication.processEvents()
    for name, words in (("scopes", "Press Start"), ("planes", "Press Start"), ("track", "click a run")):
        assert words in said(window, name), name
        label = window.empty.labels[name]
        plot = label.parentWidget()
        assert isinstance(plot, Plot)
        assert name != "planes" or plot is window.planes.raw[1]
        inside = plot.getPlotItem().vb.sceneBoundingRect().toRect()
        assert inside.contains(label.geometry()), (name, label.geometry())
        # and below what stands inside, such as the number of the receiver
        assert (plot.height_inside > 0) == (name == "planes")
        assert label.geometry().top() >= inside.top() + plot.height_inside
        needed = QLabel().fontMetrics().boundingRect(label.rect(), Qt.TextFlag.TextWordWrap, label.text())
        assert needed.height() <= label.height(), name
    assert all(is_empty(plot) for plot in window.scopes.time.scopes)


def test_a_plot_with_data_says_nothing(window: MainWindow, wait_for: Any) -> None:
    assert said(window, "scopes")
    window.actions_.start.trigger()
    wait_for(lambda: not is_empty(window.scopes.time.scopes[0]))
    for name in ("scopes", "planes"):
        window.panels.go_to(name)
        # no `processEvents` here: where pictures take longer than their interval it never returns
        wait_for(lambda name=name: name not in window.empty.labels)
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)
