"""Measure: impacts as they come, the trigger's level as a line, the last drops as dots, a plot over the whole room."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, QSize, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup
from support.work_at_once import at_once

from radargui.acquisition.ring import Ring
from radargui.gui.control.control_bar import DiskLight
from radargui.gui.control.state import AppState, Asked, Feed
from radargui.gui.main_window import MainWindow
from radargui.gui.plots.plot import Plot
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.theme import Theme
from radargui.gui.track.track_panel import TrackPanel
from radargui.live.processor import LiveProcessor
from radargui.live.track import LiveTrack
from radargui.model.drop import RunOrigin


def settle() -> None:
    for _ in range(3):
        QApplication.processEvents()


@pytest.fixture
def measure(window: MainWindow, wait_for: Callable[..., None]) -> Iterator[MainWindow]:
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.panels.work_in("measure")
    window.panels.go_to("drops")
    window.track.show_live()
    window.track.curves.show_live(window.track.shown or window.track.curves._track)
    window.track.curves.choose("trigger")
    settle()
    yield window
    window.actions_.full.setChecked(False)
    window.runs.show_session(None, [])


def pixel_of(plot: Plot, x: float, y: float) -> QPoint:
    """Return where values stand in a plot's own pixels."""
    return plot.mapFromScene(plot.view.mapViewToScene(QPointF(x, y)))


def drag(plot: Plot, start: QPoint, end: QPoint) -> None:
    viewport = plot.viewport()
    QTest.mousePress(viewport, Qt.MouseButton.LeftButton, pos=start)
    for share in (0.3, 0.6, 0.8, 1.0):
        QTest.mouseMove(viewport, start + (end - start) * share)
        QTest.qWait(20)
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=end)
    settle()


def test_the_line_of_the_trigger_is_the_field_and_the_field_is_the_line(measure: MainWindow) -> None:
    curves, model = measure.track.curves, measure.setup_model
    field = measure.findChild(QLineEdit, "recording.threshold")
    assert field is not None
    assert curves.level == model.setup.recording.threshold == 8.0
    start = pixel_of(curves.detail, -2.0, np.log10(8.0))
    end = pixel_of(curves.detail, -2.0, np.log10(3.5))
    drag(curves.detail, start, end)
    level = model.setup.recording.threshold
    # a pixel is some hundredths of a decade
    assert level == pytest.approx(3.5, rel=0.15)
    assert float(field.text()) == level
    assert f"{level:g}" in curves.detail._inside_text
    # what takes a field back takes the line back
    model.undo("recording.threshold")
    assert curves.level == 8.0
    model.assign("recording.threshold", 100.0)
    assert curves.level == 100.0
    assert curves.trigger.value() == pytest.approx(2.0)


def test_the_line_stays_within_what_the_setup_allows(measure: MainWindow) -> None:
    curves = measure.track.curves
    start = pixel_of(curves.detail, -2.0, np.log10(8.0))
    drag(curves.detail, start, start + QPoint(0, 400))
    assert measure.setup_model.valid
    assert measure.setup_model.setup.recording.threshold == 3.0


def test_the_line_rests_while_a_run_is_recorded(measure: MainWindow, wait_for: Any) -> None:
    window = measure
    window.actions_.record.trigger()
    assert window.control.state is AppState.STARTING
    assert not window.track.curves.trigger.movable
    window.control.end(Asked.LEAVE)
    wait_for(lambda: not window.control.state.running)
    assert window.track.curves.trigger.movable


def test_impacts_and_shaking_are_drawn_as_they_come(qtbot: Any, theme: Theme) -> None:
    setup = changed(quick_setup(), daq={"rate_hz": 5000.0}, simulation={"restitution": 0.6, "rest_s": 0.8})
    recording, truth = simulate_recording(setup)
    digitisation, rate_hz = recording.digitisation, recording.digitisation.sample_rate_hz
    processor = LiveProcessor(setup, digitisation)
    live = LiveTrack(setup.n_receivers, rate_hz, recording.n_samples / rate_hz)
    panel = TrackPanel(theme, setup, at_once)
    qtbot.addWidget(panel)
    panel.show()
    panel.show_feed(Feed(Ring(6, 10, np.int16, digitisation), digitisation, live, setup))
    block, seen = round(0.02 * rate_hz), list[tuple[float, float]]()
    # the fall and two bounces
    for first in range(0, round((truth.impact_time_s[2] + 0.15) * rate_hz), block):
        live.append(processor.push(recording.raw[:, first : first + block], first))
        if first % (5 * block) == 0:
            panel.refresh()
            assert panel.shown is not None
            seen.append((first / rate_hz, float(panel.shown.shaken[1].max(initial=0.0))))
    shown = panel.shown
    assert shown is not None
    at_s = panel._drawn / rate_hz + shown.impact_time_s
    assert at_s[:3] == pytest.approx(truth.impact_time_s[:3], abs=2e-3)
    assert shown.impact_mm[2] == pytest.approx(1e3 * (setup.floor.height_m or -0.14), abs=3.0)
    x, z = panel.curves.height_plot.points_of(panel.curves.height_plot._impacts)
    assert x == pytest.approx(shown.impact_time_s)
    assert z == pytest.approx(shown.impact_mm[2])
    # the line divides rest and motion
    level = setup.recording.threshold
    assert all(shaking < level for time_s, shaking in seen if 0.3 < time_s < 0.7)
    assert seen[-1][1] > 3.0 * level
    _, drawn = panel.curves.detail.data_of(panel.curves.detail.curve)
    assert drawn.max() == pytest.approx(seen[-1][1])


def entry(folder: Path, number: int, e: float, **facts: Any) -> RunEntry:
    summary = {"e": e, "u_e": 2e-4, "u_e_combined": 1e-3, "status": "ok", "verdict": "good", "from_rest": True}
    now = "2026-05-04T10:00:00+02:00"
    path = folder / f"run-{number:04d}.h5"
    return RunEntry(path, now, summary | facts.pop("summary", {}), origin=RunOrigin("measured"), **facts)


def test_the_last_ten_drops_are_dots_with_their_u_and_one_opens_its_run(measure: MainWindow, tmp_path: Path) -> None:
    window, drops = measure, measure.drops
    es = 0.8 + 1e-3 * np.arange(12)
    for number, e in enumerate(es.tolist(), 1):
        window.runs.put(entry(tmp_path, number, e))
    window.runs.put(entry(tmp_path, 13, 0.5, rejected="rejected by the operator"))
    settle()
    _, y = drops.plot.data_of(drops._counts)
    assert y == pytest.approx(es[-10:])
    _, bars = drops.plot.data_of(drops._bars)
    assert bars[:2] == pytest.approx([es[2] - 2e-3, es[2] + 2e-3])
    assert drops.words.text().startswith("n = 12   mean 0.80")
    assert f"s = {np.std(es, ddof=1):.4f}" in drops.words.text()
    chosen: list[Path] = []
    drops.run_asked.connect(chosen.append)
    path = tmp_path / "run-0005.h5"
    QTest.mouseClick(drops.plot.viewport(), Qt.MouseButton.LeftButton, pos=pixel_of(drops.plot, 2.0, es[4]))
    settle()
    assert chosen == [path]
    assert window.panels.workspace == "analyse"
    assert window.runs.table.chosen.path == path


def test_one_line_says_who_measures_what_and_leads_to_the_fields(measure: MainWindow) -> None:
    drops = measure.drops
    assert drops.session.text() == "nothing typed yet"
    measure.session_panel.set_details("Ann", "", "steel 10 mm", "glass")
    measure.session_panel.details_changed.emit()
    assert drops.session.text() == "Ann · steel 10 mm · glass"
    (change,) = drops.findChildren(QPushButton)
    change.click()
    settle()
    assert measure.session_panel.isVisible()
    assert measure.panels.workspace == "measure"
    measure.session_panel.set_details("", "")
    measure.session_panel.details_changed.emit()


@pytest.mark.parametrize("name", ["height", "scope", "plane", "drops"])
def test_a_plot_fills_the_workspace_by_a_key_and_esc_gives_it_back(measure: MainWindow, name: str) -> None:
    window = measure
    window.panels.go_to("scopes")
    window.panels.go_to("planes" if name == "plane" else "drops")
    settle()
    plots = {"height": window.track.curves.height_plot, "scope": window.scopes.time.scopes[0]}
    plot = {**plots, "plane": window.planes.raw[0], "drops": window.drops.plot}[name]
    plot.setFocus()
    settle()
    shown = {one: one.size() for one in window.findChildren(Plot) if one.isVisible()}
    before = plot.parentWidget().size()
    QTest.keyClick(plot, Qt.Key.Key_F2)
    settle()
    room = window.panels.size()
    assert plot.parentWidget().width() > 0.97 * room.width()
    assert plot.parentWidget().height() > 0.85 * room.height()
    assert plot.isVisible()
    QTest.keyClick(plot, Qt.Key.Key_Escape)
    settle()
    assert plot.parentWidget().size() == before
    assert {one: one.size() for one in window.findChildren(Plot) if one.isVisible()} == shown
    assert window.actions_.stop.iconText() == "Stop\nEsc"


def test_who_goes_elsewhere_finds_all_panels_again(measure: MainWindow) -> None:
    plot = measure.track.curves.height_plot
    plot.setFocus()

    def seen() -> dict[str, QSize]:
        docks = measure.panels.docks.items()
        return {name: dock.size() for name, dock in docks if not dock.visibleRegion().isEmpty()}

    sizes = seen()
    measure.actions_.full.trigger()
    settle()
    measure.panels.work_in("prepare")
    assert not measure.actions_.full.isChecked()
    measure.panels.work_in("measure")
    settle()
    assert seen() == sizes


def test_esc_gives_the_room_back_before_it_ends_what_runs(measure: MainWindow, wait_for: Any) -> None:
    measure.track.curves.height_plot.setFocus()
    measure.actions_.start.trigger()
    wait_for(lambda: measure.control.state is AppState.LIVE)
    QTest.keyClick(measure.track.curves.height_plot, Qt.Key.Key_F2)
    assert measure.actions_.stop.iconText() == "Stop\nF5"
    QTest.keyClick(measure.track.curves.height_plot, Qt.Key.Key_Escape)
    settle()
    assert measure.control.state is AppState.LIVE
    QTest.keyClick(measure.track.curves.height_plot, Qt.Key.Key_Escape)
    wait_for(lambda: measure.control.state is AppState.IDLE)


def test_the_disk_is_a_traffic_light_that_says_it_in_words(qtbot: Any, theme: Theme) -> None:
    light = DiskLight(theme)
    qtbot.addWidget(light)
    for free, left_s, role, text in (
        (None, None, "idle", "–"),
        (76e9, 1e6, "good", "76 GB"),
        (2e9, 5000.0, "mark", "2 GB"),
        (0.3e9, 300.0, "alarm", "5 min"),
    ):
        light.show_room(free, left_s)
        assert (light.role, light.text) == (role, text)
        assert light.accessibleName().startswith("Disk: ")


def test_the_room_on_the_disk_is_known_at_rest(window: MainWindow, wait_for: Any) -> None:
    wait_for(lambda: window.bar.disk.role == "good")
    assert "GB free" in window.bar.disk.toolTip()
    assert "of recording" in window.bar.disk.toolTip()


def test_the_sign_of_the_sounds_is_struck_out_where_none_is_on(window: MainWindow) -> None:
    does, sign = window.actions_, window.bar.sound
    switches = (does.sound, does.sound_trigger, does.sound_fault)
    before = [one.isChecked() for one in switches]
    for one in switches:
        one.setChecked(False)
    assert sign.font().strikeOut()
    assert sign.toolTip() == "Sound off"
    for one, on in zip(switches, before, strict=True):
        one.setChecked(on)
    assert not sign.font().strikeOut()
    assert [one.text() for one in sign.menu().actions()] == [one.text() for one in switches]
