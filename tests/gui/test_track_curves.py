"""The track in colours of its speed, its curves with their bands, the fitted fall with its residual."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from PySide6.QtGui import QFontMetricsF
from pytestqt.qtbot import QtBot
from support.results import drop_result
from support.work_at_once import at_once

from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import live_track
from radargui.gui.track.speed_colours import N_COLOURS
from radargui.gui.track.track_panel import TrackPanel
from radargui.live.track import LiveSpan
from radargui.model.result import Kinematics, RunResult, whole_milliseconds
from radargui.report.curves import take_track


@pytest.fixture(scope="module")
def result() -> RunResult:
    return drop_result(rate_hz=4000.0)


@pytest.fixture
def panel(qtbot: QtBot, theme: Theme, result: RunResult) -> TrackPanel:
    panel = TrackPanel(theme, result.setup, at_once)
    qtbot.addWidget(panel)
    panel.resize(500, 600)
    panel.show()
    return panel


def drawn(panel: TrackPanel) -> tuple[np.ndarray, np.ndarray]:
    x, y = panel.curves.detail.curve.getData()
    return (np.empty(0), np.empty(0)) if x is None else (x, y)


def span_of(n: int) -> LiveSpan:
    """Estimates of a sphere that stands still, the last `n` of them."""
    index = np.arange(n)
    return LiveSpan(index, index / 1000.0, *np.zeros((4, 3, n)))


def live_of(**facts: Any) -> SimpleNamespace:
    """What the panel reads of a live track: of a sphere that stands still, where the trigger saw nothing."""
    seen = {"since": lambda _index: span_of(5), "shaken_since": lambda _index: np.empty((2, 0))}
    return SimpleNamespace(moving=False, **seen, **facts)


def test_the_trail_has_the_colour_of_its_speed_and_the_bar_says_which(panel: TrackPanel, result: RunResult) -> None:
    panel.show_result(result, "run-0001")
    scale_m_s = panel._colours.max_m_s
    assert panel.speed_bar.high.text() == f"{scale_m_s:g} m/s"
    fastest = max(bounce.speed_before_m_s for bounce in result.bounces.impacts)
    assert scale_m_s >= fastest
    steps = {step for *_, trail, _, _ in panel.projections._parts for step in trail.lines}
    # from rest to the speed of the impact, every colour in between
    assert steps == set(range(int(fastest / scale_m_s * N_COLOURS) + 1))
    table = panel._colours.table()
    lightness = table[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(lightness) > 0.0).all(), "the map is told apart by lightness too"
    panel._theme.apply("dark")
    assert panel._colours.table()[0] != pytest.approx(table[0])


def test_the_speed_is_that_of_the_sphere(panel: TrackPanel, result: RunResult) -> None:
    panel.show_result(result, "run-0001")
    panel.curves.choose("speed")
    t, v = drawn(panel)
    first = result.bounces.impacts[0]
    zero = result.zero[0]
    before = v[(t < first.time_s - zero - 0.002) & (t > first.time_s - zero - 0.004)]
    expected = np.hypot(first.speed_before_m_s - 9.81 * 0.003, 0.02)
    assert before == pytest.approx(expected, abs=0.02)


def test_velocities_of_the_estimate_are_drawn_with_their_bands(panel: TrackPanel, result: RunResult) -> None:
    panel.show_result(result, "run-0001")
    for name in ("acceleration", "speed over z"):
        panel.curves.choose(name)
        assert not np.isfinite(drawn(panel)[1]).any(), "nobody knows them"
    time = whole_milliseconds(0.3, 0.5)
    rows, one = np.zeros((3, time.size)), np.ones((3, time.size))
    velocity = np.stack([rows[0], rows[1], -9.81 * (time - 0.3)])
    place = np.stack([rows[0], rows[1], 0.12 - 4.905 * (time - 0.3) ** 2])
    acceleration = np.stack([rows[0], rows[1], rows[2] - 9.81])
    flight = np.where(time < 0.49, 0, -1)
    motion = Kinematics(time, place, velocity, acceleration, 1e-5 * one, 2e-3 * one, 0.03 * one, flight)
    panel.show_result(replace(result, motion=motion), "run-0001")
    panel.curves.choose("speed")
    assert np.nanmax(drawn(panel)[1]) == pytest.approx(9.81 * 0.2)
    band = panel.curves.detail.band_drawn.path().boundingRect()
    assert band.bottom() == pytest.approx(9.81 * 0.2 + 4e-3)
    panel.curves.choose("acceleration")
    t, a = drawn(panel)
    assert np.nanmax(np.abs(a + 9.81)) < 1e-9
    assert t[np.isfinite(a)].max() == pytest.approx(0.489 - result.zero[0])
    panel.curves.choose("speed over z")
    z, v = drawn(panel)
    assert z[np.argmax(v)] == pytest.approx(1e3 * place[2, -1])


def test_x_and_y_have_their_band_which_is_the_combined_uncertainty_where_it_is_known(
    panel: TrackPanel, result: RunResult
) -> None:
    assert result.track is not None
    combined = np.full_like(result.track.u_position_m, 0.002)
    result = replace(result, track=replace(result.track, u_combined_m=combined))
    panel.show_result(result, "run-0001")
    assert "± 2 u (combined)" in panel.curves.key.text().replace("&nbsp;", " ")
    for name in ("x", "y"):
        panel.curves.choose(name)
        area = panel.curves.detail.band_drawn.path().boundingRect()
        _, y = drawn(panel)
        assert area.height() == pytest.approx(np.nanmax(y) - np.nanmin(y) + 8.0, abs=0.01)
    height = panel.curves.height_plot.band_drawn.path().boundingRect()
    assert height.width() == pytest.approx(panel.shown.time_s[-1] - panel.shown.time_s[0])


def test_parabola_and_residual_are_the_reports(panel: TrackPanel, result: RunResult) -> None:
    assert result.track is not None
    # exact by itself: a wave of 50 µm is what the fit leaves
    wave = np.array([[0.0], [0.0], [5e-5]]) * np.sin(60.0 * result.track.time_s)
    result = replace(result, track=replace(result.track, position_m=result.track.position_m + wave))
    panel.show_result(result, "run-0001")
    assert panel.curves.shown_detail == "residual", "once it has fallen, what the fit leaves is shown"
    t, rest_um = drawn(panel)
    own = take_track(result)
    assert own is not None
    assert own.residual is not None
    assert np.nanmax(np.abs(rest_um)) == pytest.approx(1e6 * own.residual.largest)
    assert np.nanmax(np.abs(rest_um)) == pytest.approx(50.0, abs=0.5)
    assert t[[0, -1]] == pytest.approx(own.residual.x[[0, -1]])
    assert panel.curves.detail.viewRange()[0][1] == pytest.approx(t[-1], abs=0.01)
    without = replace(result, bounces=replace(result.bounces, free_fall=None))
    panel.show_result(without, "run-0001")
    assert drawn(panel)[0].size == 0
    assert panel.curves.detail._inside_text == "no fall was fitted"


def test_what_was_chosen_for_the_live_trail_and_for_a_result_is_kept_apart(
    panel: TrackPanel, result: RunResult
) -> None:
    assert panel.curves.shown_detail == "trigger"
    panel.curves.choose("y")
    panel.show_result(result, "run-0001")
    assert panel.curves.shown_detail == "residual"
    panel.curves.choose("x")
    panel.clear()
    assert panel.curves.shown_detail == "y"
    assert not panel.curves.tabs.isTabVisible(2), "nothing is fitted to a sphere that still falls"
    panel.show_result(result, "run-0001")
    assert not panel.curves.tabs.isTabVisible(0), "nobody kept what the trigger saw"
    assert panel.curves.shown_detail == "x"


def test_a_live_trail_is_coloured_too(panel: TrackPanel) -> None:
    t = np.linspace(-0.2, 0.0, 200)
    place = np.stack([0.0 * t, 0.0 * t, 0.1 - 4.905 * (t + 0.2) ** 2])
    track = live_track(t, place)
    panel._draw(track)
    panel.curves.show_live(track)
    assert track.speed_m_s[-1] == pytest.approx(1.962, abs=1e-6)
    assert len(panel.projections._parts[0][4].lines) > 5
    panel.curves.choose("speed")
    assert np.nanmax(drawn(panel)[1]) == pytest.approx(1.962, abs=1e-6)
    assert panel.curves.detail.band_drawn.path().isEmpty()


def test_no_sphere_is_drawn_where_nobody_knows_it_and_that_of_a_result_where_the_track_ends(
    panel: TrackPanel, result: RunResult
) -> None:
    spheres = [part[-1] for part in panel.projections._parts]
    t = np.linspace(-0.2, 0.0, 50)
    place = np.stack([0.0 * t + 0.01, 0.0 * t - 0.02, 0.1 + t])
    panel._draw(live_track(t, place))
    now_mm = 1e3 * place[:, -1]
    for (across, up, *_), dot in zip(panel.projections._parts, spheres, strict=True):
        assert dot.isVisible()
        assert [dot.pos().x(), dot.pos().y()] == pytest.approx(now_mm[[across, up]])
    place[:, -1] = np.nan
    panel._draw(live_track(t, place))
    # the line stays, the place that was known last is not the place now
    assert not any(dot.isVisible() for dot in spheres)
    panel.show_result(result, "run-0001")
    track = result.track
    assert track is not None
    last = np.flatnonzero(track.valid & np.isfinite(track.position_m).all(axis=0))[-1]
    for (across, up, *_), dot in zip(panel.projections._parts, spheres, strict=True):
        assert dot.isVisible()
        assert [dot.pos().x(), dot.pos().y()] == pytest.approx(1e3 * track.position_m[[across, up], last])


def test_the_speed_of_the_next_fall_is_seen_whole(panel: TrackPanel) -> None:
    t = np.linspace(-0.2, 0.0, 200)
    falling = live_track(t, np.stack([0.0 * t, 0.0 * t, 0.1 - 4.905 * (t + 0.2) ** 2]))
    panel.curves.choose("speed")
    panel.curves.show_live(falling)
    # a recording begins: the last moments of before are forgotten
    panel.clear()
    panel.curves.show_live(falling)
    low, high = panel.curves.detail.viewRange()[1]
    assert low <= 0.0
    assert high > np.nanmax(falling.speed_m_s)


def test_a_bounce_that_turns_round_is_not_called_at_rest(panel: TrackPanel) -> None:
    # at 1 kHz; only what the panel reads of an acquisition
    live = live_of(latest=0, began_anew=False, doubt="")
    feed = SimpleNamespace(live=live, rate_hz=1000.0, samples=lambda seconds: round(1000.0 * seconds))
    panel._feed = cast("Any", feed)
    titles = []
    for latest, moving in ((100, False), (200, True), (220, False), (240, True), (600, False)):
        live.latest, live.moving = latest, moving
        panel.refresh()
        titles.append(panel._title.text())
    assert titles == ["Live track: at rest", *["Live track"] * 3, "Live track: at rest"]


def test_a_place_that_is_not_known_is_not_called_at_rest(panel: TrackPanel) -> None:
    words = "receiver 2 shows no circle"
    live = live_of(latest=900, began_anew=True, doubt=words)
    feed = SimpleNamespace(live=live, rate_hz=1000.0, samples=lambda seconds: round(1000.0 * seconds))
    panel._feed = cast("Any", feed)
    panel.refresh()
    assert panel._title.text() == f"Live track: place unknown, {words}"
    live.latest, live.doubt = 1000, ""
    panel.refresh()
    assert panel._title.text() == "Live track: at rest, starts anew, as if from the release"


def test_the_words_of_the_projections_do_not_lie_upon_their_figures(panel: TrackPanel) -> None:
    panel.resize(490, 600)
    for plot in panel.projections.plots:
        axis = plot.getPlotItem().getAxis("left")
        words = axis.label.mapRectToParent(axis.label.boundingRect())
        figures = QFontMetricsF(axis.style["tickFont"] or axis.font()).horizontalAdvance("-100")
        # pyqtgraph lets a label reach a fifth of its height beyond the axis; figures end at their marks
        assert words.right() <= axis.width() - figures - axis.style["tickTextOffset"][0]


def test_a_run_without_a_track_says_why_in_place_of_what_to_press(panel: TrackPanel, result: RunResult) -> None:
    alone = result.setup.model_copy(update={"receiver": result.setup.receiver[:1]})
    plot = panel.curves.height_plot
    panel.show_result(replace(result, setup=alone, track=None), "run-0001")
    assert plot.when_empty == "No track: a position needs 3 receivers."
    panel.show_result(replace(result, status="no_motion", track=None), "run-0002")
    assert plot.when_empty == "Nothing moved in this run."
    panel.show_result(result, "run-0003")
    assert plot.when_empty == ""
    panel.show_result(replace(result, track=None), "run-0004")
    panel.clear()
    assert plot.when_empty == "", "then it says again how to begin"
    panel.show_setup(alone)
    assert plot.when_empty == "No track: a position needs 3 receivers.", "whatever is pressed"


def test_a_track_that_comes_late_is_not_drawn_over_another_run(qtbot: QtBot, theme: Theme, result: RunResult) -> None:
    waiting: list[Any] = []
    panel = TrackPanel(theme, result.setup, lambda *call: waiting.append(call))
    qtbot.addWidget(panel)
    panel.show_result(result, "run-0001")
    panel.show_result(replace(result, preliminary=True), "run-0002")
    (_, _, _, _, first), (_, work, then, _, second) = waiting
    assert (first(), second()) == (False, True)
    then(work())
    assert panel.shown is not None
    panel.clear()
    assert not second()
