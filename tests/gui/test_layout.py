"""Where things stand: everything fits a small screen at the first start, and stays as the operator set it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QPointF, QRect, QSize, Qt
from PySide6.QtWidgets import QApplication, QCheckBox, QComboBox, QLabel, QLineEdit, QPushButton, QSplitter, QWidget

from radargui.acquisition.health import ChannelFacts
from radargui.acquisition.run_output import Level
from radargui.gui.layout import OneLine
from radargui.gui.main_window import MainWindow
from radargui.gui.panels import TITLES, HelpBrowser, Room, show_help
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.sessions.import_dialog import ImportDialog
from radargui.model.drop import RunOrigin

SMALL = QSize(1350, 680)
"""What a screen of 1366 x 768 leaves of a window beside its frame, its title and the system's bar."""
SMALLEST = QSize(944, 500)
"""The same of 1920 x 1080 at scale 2."""


def made_small(window: MainWindow, request: pytest.FixtureRequest) -> MainWindow:
    window.resize(getattr(request, "param", SMALL))
    window.actions_.reset_layout.trigger()
    QApplication.processEvents()
    return window


@pytest.fixture
def small(window: MainWindow, request: pytest.FixtureRequest) -> MainWindow:
    return made_small(window, request)


@pytest.fixture
def small_at_first(make_window: Any, setup_path: Any, request: pytest.FixtureRequest) -> MainWindow:
    """A new one, whose columns nobody has set."""
    return made_small(make_window(setup_path), request)


def looked_at(window: MainWindow, name: str) -> None:
    window.panels.go_to(name)
    for _ in range(3):
        QApplication.processEvents()


def cut(widget: QWidget) -> bool:
    if isinstance(widget, QComboBox):
        # the words beside the arrow
        wanted = widget.fontMetrics().horizontalAdvance(widget.currentText()) + 26
        return widget.width() < wanted
    if isinstance(widget, QLineEdit):
        # what an empty field says, between its edges
        return (
            not widget.text() and widget.width() < widget.fontMetrics().horizontalAdvance(widget.placeholderText()) + 8
        )
    if isinstance(widget, QLabel) and (widget.wordWrap() or not widget.text()):
        return False
    return widget.width() < widget.sizeHint().width() or widget.height() < widget.sizeHint().height()


@pytest.mark.parametrize("small", [SMALL, SMALLEST], indirect=True)
def test_nothing_is_cut_on_a_small_screen(small: MainWindow, record_one: Any) -> None:
    size = small.size()
    assert size in (SMALL, SMALLEST), "larger than the screen"
    small.setup_model.assign("processing.correction", "adaptive")
    record_one(small)
    for number in range(3):
        small.board.post("warning", f"message {number}")
    for kind in ("simulated", "ni", "replay"):
        small.hardware.choose(kind)
        for name in TITLES:
            looked_at(small, name)
            assert small.size() == size, name
            for room in small.panels.findChildren(Room):
                if room.isVisible():
                    # a panel that is larger than its dock is scrolled, and never squeezed
                    least = room.widget().minimumSizeHint()
                    assert room.widget().width() >= least.width(), (name, room.widget())
                    assert room.widget().height() >= least.height(), (name, room.widget())
                    assert size == SMALLEST or room.width() >= least.width(), (name, room.widget())
            for one in small.panels.findChildren(QWidget):
                if one.isVisible() and isinstance(one, QLabel | QPushButton | QCheckBox | QComboBox | QLineEdit):
                    if size == SMALLEST and isinstance(one, QComboBox | QLineEdit):
                        continue
                    ignored = one.sizePolicy().horizontalPolicy() == one.sizePolicy().Policy.Ignored
                    assert ignored or not cut(one), (name, one, one.objectName(), getattr(one, "text", str)())


@pytest.mark.parametrize("small", [SMALL, SMALLEST], indirect=True)
def test_the_words_of_the_time_axes_are_not_cut_on_a_small_screen(small: MainWindow) -> None:
    looked_at(small, "scopes")
    plots = (small.scopes.time.scopes[-1], small.track.curves.height_plot)
    for plot in plots:
        words = plot.getPlotItem().getAxis("bottom").label
        place = words.mapRectToScene(words.boundingRect())
        assert place.left() >= -1.0, words.toPlainText()
        assert place.right() <= plot.width() + 1.0, (words.toPlainText(), place.right(), plot.width())


def test_the_whole_track_is_seen_on_a_small_screen(small: MainWindow, record_one: Any) -> None:
    record_one(small)
    for _ in range(3):
        QApplication.processEvents()
    room = next(one for one in small.panels.findChildren(Room) if one.content is small.track)
    assert small.track.height() <= room.viewport().height(), "the words of the lowest axis are cut"


@pytest.mark.parametrize("small_at_first", [SMALL, SMALLEST], indirect=True)
def test_every_column_of_the_runs_can_be_read_on_a_small_screen(small_at_first: MainWindow, tmp_path: Any) -> None:
    small = small_at_first
    small.panels.work_in("analyse")
    origin = RunOrigin("simulated")
    measured = {"e": 0.80001, "u_e": 2.2e-4, "g_m_s2": 9.81, "u_g_m_s2": 0.011, "drop_height_m": 0.26}
    states: tuple[dict[str, Any], ...] = (
        {"summary": measured | {"impact_speed_m_s": 2.259, "verdict": "usable", "preliminary": True}},
        {"waits": True},
        {"rejected": "rejected by the operator"},
    )
    small.runs.rejected.setChecked(True)
    for number, state in enumerate(states, start=1):
        now = "2026-05-04T10:00:00+02:00"
        small.runs.put(RunEntry(tmp_path / f"run-{number:04d}.h5", started_at=now, origin=origin, **state))
    looked_at(small, "runs")
    table, model = small.runs.table, small.runs.model
    if not table.isVisible():
        small.actions_.turn_runs.trigger()
        looked_at(small, "runs")
    assert table.isVisible()
    last = model.columnCount() - 1
    for row, entry in enumerate(model.entries):
        inside = QRect(0, 0, table.columnWidth(last) - 8, 10_000)
        needed = table.fontMetrics().boundingRect(inside, Qt.TextFlag.TextWordWrap, entry.verdict)
        assert entry.verdict
        assert needed.height() <= table.rowHeight(row), entry.verdict
        assert needed.width() <= inside.width(), entry.verdict
    assert entry.verdict == "set aside, SIMULATED"
    assert needed.height() <= table.fontMetrics().lineSpacing(), "a run that does not count takes one line"
    for column in (one for one in range(last) if not table.isColumnHidden(one)):
        words = (
            *str(model.headerData(column, Qt.Orientation.Horizontal)).splitlines(),
            str(model.data(model.index(0, column), Qt.ItemDataRole.DisplayRole)),
        )
        room = table.columnWidth(column) - 8
        assert all(table.fontMetrics().horizontalAdvance(text) <= room for text in words), words
    assert table.horizontalHeader().length() <= table.viewport().width()


def test_all_that_a_channel_shows_is_seen_on_a_small_screen(small: MainWindow) -> None:
    looked_at(small, "channels")
    levels = [Level(f"{part}{rx}", -1.23, 1.23, 5.0, clipped=True) for rx in (1, 2, 3) for part in "IQ"]
    small.channels.show_facts(tuple(ChannelFacts(one, -0.707, 0.00712, 0.71, -0.0123) for one in levels))
    QApplication.processEvents()
    for bar in small.channels.bars:
        assert bar.visibleRegion().boundingRect().size() == bar.size()
        for words in bar.words:
            assert bar.fontMetrics().horizontalAdvance(words) <= bar.width() - 8, words


def test_the_planes_of_four_receivers_are_seen_whole_on_a_small_screen(small: MainWindow) -> None:
    small.planes.set_receivers(4)
    looked_at(small, "planes")
    room = next(one for one in small.panels.findChildren(Room) if one.content is small.planes)
    assert small.planes.width() <= room.viewport().width()
    assert small.planes.height() <= room.viewport().height()
    for plane in (*small.planes.raw, *small.planes.corrected):
        # no figures take the room of the circle; the name above it does
        circle = plane.view.mapViewToScene(QPointF(1.0, 0.0)) - plane.view.mapViewToScene(QPointF(-1.0, 0.0))
        assert circle.x() >= 0.4 * min(plane.width(), plane.height()), plane.size()


def test_how_the_last_run_was_recorded_is_read_whole_on_a_small_screen(small: MainWindow) -> None:
    line = small.health
    line.show_run("run-0003: 93082 samples, 27.4 kS/s, none lost, backlog 1283, writer queue 1 %, live 0 ms behind")
    # figures of a run that was just recorded take more room than dashes
    for label in line.labels.values():
        label.setMinimumWidth(190)
    line.show_health(None)
    for _ in range(3):
        QApplication.processEvents()
    assert line.run.width() >= line.fontMetrics().horizontalAdvance(line.run.text())


def test_a_dialog_that_grows_stays_on_the_screen(window: MainWindow, tmp_path: Any, wait_for: Any) -> None:
    window.actions_.import_.trigger()
    dialog, room = window.transfer.dialog, window.screen().availableGeometry()
    assert isinstance(dialog, ImportDialog)
    dialog.move(room.right() - dialog.width(), room.bottom() - dialog.height())
    file = tmp_path / "samples.bin"
    file.write_bytes(bytes(4000))
    before = dialog.width()
    dialog.choose([file])
    assert dialog.width() > before
    taken = dialog.frameGeometry()
    # one that is wider than the screen begins where that does
    assert taken.left() == room.left() or room.left() < taken.left() <= taken.right() <= room.right(), (room, taken)
    assert room.top() <= taken.top() <= taken.bottom() <= room.bottom(), (room, taken)
    wait_for(lambda: not window.jobs.running)


def test_the_first_window_fits_the_screen(window: MainWindow) -> None:
    room = window.screen().availableSize()
    window.panels.restore_within(window, window.settings)
    assert window.minimumSizeHint().width() <= SMALLEST.width()
    assert window.minimumSizeHint().height() <= SMALLEST.height()
    least = window.minimumSizeHint()
    assert window.width() <= max(room.width(), least.width())
    assert window.height() <= max(room.height(), least.height())


def test_columns_splitters_and_panels_stay_as_they_were_set(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    first = make_window(setup_path)
    first.panels.work_in("prepare")
    first.panels.resizeDocks([first.panels.docks["hardware"]], [450], Qt.Orientation.Horizontal)
    QApplication.processEvents()
    first.runs.table.setColumnWidth(1, 133)
    first.sessions.browser.table.setColumnWidth(2, 77)
    side = first.panels.docks["hardware"].width()
    first.panels.work_in("measure")
    QApplication.processEvents()
    (splitter,) = first.track.findChildren(QSplitter)
    splitter.setSizes([300, 300])
    wanted = splitter.sizes()
    first.close()
    wait_for(first.isHidden)
    again = make_window(None)
    QApplication.processEvents()
    (splitter,) = again.track.findChildren(QSplitter)
    assert splitter.sizes() == wanted
    again.panels.go_to("hardware")
    QApplication.processEvents()
    # the screen of the tests is smaller than the window: the layout passes through its width
    assert again.panels.docks["hardware"].width() == pytest.approx(side, abs=20)
    assert again.runs.table.columnWidth(1) == 133
    again.runs.show_session(None, [])
    assert again.runs.table.columnWidth(1) == 133
    assert again.sessions.browser.table.columnWidth(2) == 77


def test_dialogs_come_again_as_they_were_left(
    make_window: Any, setup_path: Any, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("PySide6.QtGui.QDesktopServices.openUrl", lambda _url: False)
    first = make_window(setup_path)
    for dialog in (first.log, first.wiring, first.run_controller.report_preview):
        dialog.show()
        dialog.resize(612, 433)
        dialog.reject()
    show_help(first, first.settings)
    (pages,) = first.findChildren(HelpBrowser)
    pages.resize(611, 432)
    pages.reject()
    # another one in the same window, and all in the next
    show_help(first, first.settings)
    assert first.findChildren(HelpBrowser)[1].size() == QSize(611, 432)
    first.close()
    wait_for(first.isHidden)
    again = make_window(None)
    for dialog in (again.log, again.wiring, again.run_controller.report_preview):
        assert dialog.size() == QSize(612, 433), dialog.windowTitle()


def test_words_that_are_longer_than_their_line_end_in_an_ellipsis_and_stand_in_the_tip(qapp: QApplication) -> None:
    words = "power law: e1 = 0.80001 ± 0.00003 (χ² = 182 of 124 degrees of freedom)"
    line, short = OneLine(words), OneLine("power law")
    shown = []
    for one in (line, short):
        one.resize(120, 20)
        shown.append(one.grab().toImage())
    drawn = OneLine(line.fontMetrics().elidedText(words, Qt.TextElideMode.ElideRight, 120))
    drawn.resize(120, 20)
    assert shown[0] == drawn.grab().toImage()
    assert shown[0] != shown[1]
    assert drawn.text().endswith("…")
    assert line.toolTip() == words


def test_in_large_letters_forms_are_whole_and_the_list_shows_a_run(
    make_window: Any, setup_path: Path, large_letters: None
) -> None:
    window = make_window(setup_path)
    window.resize(1900, 1000)
    window.panels.reset()
    window.panels.go_to("antennas")
    QApplication.processEvents()
    for name in ("hardware", "antennas", "session"):
        window.panels.go_to(name)
        QApplication.processEvents()
        room = window.panels.docks[name].widget()
        assert isinstance(room, Room)
        assert room.horizontalScrollBar().maximum() == 0, name
    window.panels.go_to("browser")
    QApplication.processEvents()
    assert window.sessions.browser.table.horizontalScrollBar().maximum() == 0
    # where no room is left for three panels beside each other, one stands behind another as on a small screen
    window.resize(1366, 768)
    window.panels.go_to("runs")
    window.panels.reset()
    QApplication.processEvents()
    table = window.runs.table
    assert table.viewport().height() >= table.verticalHeader().defaultSectionSize()
    window.panels.work_in("measure")
    assert window.panels.docks["planes"] in window.panels.tabifiedDockWidgets(window.panels.docks["scopes"])
