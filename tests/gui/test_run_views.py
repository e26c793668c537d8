"""What is shown of a run: results of every kind, from a full track to none."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QTextDocument
from PySide6.QtWidgets import QApplication, QTextBrowser, QWidget
from pytestqt.qtbot import QtBot
from support.changed import changed
from support.results import drop_result, rejected_result
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup
from support.work_at_once import at_once

from radargui.files.overview import Overview
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.figures_view import SHEET, FiguresView, page_of
from radargui.gui.runs.run_model import COLUMNS, RunEntry, RunModel
from radargui.gui.runs.run_panel import RunPanel, boxes
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import result_track
from radargui.gui.track.track_panel import ResultTrack, TrackPanel
from radargui.model.finding import as_stored
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import process
from radargui.report.content import Grid, templates
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_section
from radargui.report.tables import write_tables


def result_of(setup: Setup, **tables: Any) -> RunResult:
    setup = changed(setup, daq={"rate_hz": 8000.0, "channel_skew_s": 0.0, "channels": None}, **tables)
    recording, _ = simulate_recording(setup)
    return process(recording, setup)


@pytest.fixture(scope="module")
def setup() -> Setup:
    return quick_setup()


@pytest.fixture
def panel(qtbot: QtBot, theme: Theme, setup: Setup) -> RunPanel:
    panel = RunPanel(theme, at_once, QWidget(), lambda: ResultTrack(theme, setup, at_once))
    for one in (panel, panel.figures):
        qtbot.addWidget(one)
        one.show()
    return panel


def look_through(panel: RunPanel, result: RunResult) -> None:
    panel.show_result(result, "run-0001")
    for page in range(panel.tabs.count()):
        panel.tabs.setCurrentIndex(page)


def test_the_published_steps_of_a_drop_are_drawn(panel: RunPanel, setup: Setup) -> None:
    result = result_of(setup)
    look_through(panel, result)
    raw = panel.tabs.page("steps").raw[0]
    steps = result.corrected.steps[0].i
    assert raw.found["peaks"].getData()[0].size == steps.peaks.size > 10
    assert raw.found["upper"].getOriginalDataset()[0].size == steps.upper.size
    panel.tabs.page("steps").receiver.setCurrentIndex(2)
    other = result.corrected.steps[2].i
    assert raw.found["peaks"].getData()[0].size == other.peaks.size


def test_a_correction_without_steps_is_shown_without(panel: RunPanel, setup: Setup) -> None:
    for method in ("ellipse", "none"):
        look_through(panel, result_of(setup, processing={"correction": method}))
        assert method in panel.tabs.page("steps")._words.text()
        assert panel.tabs.page("steps").raw[0].found["peaks"].getData()[0] is None


def test_the_tables_of_the_figures_fit_the_width_that_they_have_now(theme: Theme, qtbot: QtBot) -> None:
    view = FiguresView(theme)
    qtbot.addWidget(view)
    view.resize(800, 400)
    view.show()
    view.show_result(drop_result(rate_hz=2000.0))
    for width in (380, 800, 520, 380):
        view.resize(width, 400)
        QApplication.processEvents()
        assert view.horizontalScrollBar().maximum() == 0, width


def test_no_motion_is_an_answer(panel: RunPanel, qtbot: QtBot, theme: Theme, setup: Setup) -> None:
    result = result_of(setup, simulation={"scene": "rest", "rest_s": 1.0})
    assert result.status == "no_motion"
    look_through(panel, result)
    assert "no motion" in panel.figures.toPlainText()
    track = TrackPanel(theme, setup, at_once)
    qtbot.addWidget(track)
    track.show_result(result, "run-0001")
    assert track.shown is None
    assert result_track(result) is None


def test_one_receiver_has_path_lengths_and_no_track(panel: RunPanel, setup: Setup) -> None:
    plain = setup.model_dump(by_alias=True)
    plain["receiver"] = plain["receiver"][:1]
    plain["daq"]["channels"] = None
    result = result_of(Setup.model_validate(plain))
    look_through(panel, result)
    assert result_track(result) is None
    assert panel.tabs.page("phase").path.getPlotItem().listDataItems()


def test_the_shown_track_counts_from_the_trigger_in_mm(setup: Setup) -> None:
    result = result_of(setup)
    shown = result_track(result)
    assert shown is not None
    assert shown.position_mm[2, 10] == pytest.approx(120.0, abs=0.5)
    assert np.nanmin(shown.position_mm[2]) == pytest.approx(-140.0, abs=1.0)
    assert shown.impact_time_s[0] == pytest.approx((2 * 0.26 / 9.80665) ** 0.5, abs=0.02)
    assert shown.fit_mm[-1] == pytest.approx(-140.0, abs=6.0)
    assert result.zero[0] == pytest.approx(0.6, abs=0.02)


def test_no_line_joins_two_pieces_of_a_path_and_the_place_is_marked(panel: RunPanel, setup: Setup) -> None:
    result = result_of(setup)
    assert result.segment is not None
    begin = result.segment.first + 501
    piece = (np.arange(result.recording.n_samples) >= begin).astype(np.intp)
    result = replace(result, paths=replace(result.paths, piece=piece))
    look_through(panel, result)
    at = result.paths.time_s[begin] - result.zero[0]
    lengths = panel.tabs.page("phase").path.getPlotItem().listDataItems()
    assert len(lengths) == 3
    for curve in lengths:
        x, y = curve.getOriginalDataset()
        assert at in x[np.isnan(y)]
    rules = [item for item in panel.tabs.page("phase").path.getPlotItem().items if isinstance(item, pg.InfiniteLine)]
    assert [rule.value() for rule in rules] == [pytest.approx(at)]
    shown = result_track(result)
    assert np.isnan(shown.position_mm[:, np.isclose(shown.time_s, at)]).all(axis=0).sum() >= 8
    look_through(panel, replace(result, paths=replace(result.paths, piece=None)))
    assert not [item for item in panel.tabs.page("phase").path.getPlotItem().items if isinstance(item, pg.InfiniteLine)]


def test_texts_from_files_are_no_markup(theme: Theme, setup: Setup) -> None:
    result = result_of(setup, simulation={"scene": "rest"})
    object.__setattr__(result, "findings", (as_stored("<b>bold</b>"),))
    assert "&lt;b&gt;" in page_of(result, theme)


@pytest.mark.parametrize(
    ("summary", "verdict"),
    [
        (None, "not processed"),
        ({"status": "no_motion"}, "no motion"),
        ({"status": "rejected", "reason": "receiver 2: clipped"}, "rejected: receiver 2: clipped"),
        ({"status": "ok", "verdict": "usable", "e": 0.8123, "u_e": 0.0012}, "usable"),
        ({"status": "ok", "verdict": "good", "warnings": ["the floor moves", "a loose contact"]}, "good, 2 warnings"),
    ],
)
def test_the_list_says_what_came_of_a_run(summary: Any, verdict: str, tmp_path: Any) -> None:
    entry = RunEntry(tmp_path / "run-0012.h5", "2026-05-04T13:14:15.5+02:00", summary, label="12")
    cells = entry.cells
    assert cells[0] == "12"
    assert cells[1] == "13:14:15"
    assert cells[-1] == verdict
    assert cells[4] == ("0.8123 ± 0.0012" if summary and "e" in summary else "–")


def test_what_speaks_against_a_run_is_said_with_it_in_words_and_colour(tmp_path: Path) -> None:
    path, warned = tmp_path / "run-0001.h5", {"status": "ok", "verdict": "good", "warnings": ["the floor moves"]}
    refused = RunEntry(path, summary={"status": "rejected", "reason": "receiver 2: clipped", "warnings": ["cold"]})
    assert (refused.objection, refused.role) == ("rejected: receiver 2: clipped", "alarm")
    moved = RunEntry(path, summary=warned)
    assert (moved.objection, moved.role) == ("the floor moves", "mark")
    model = RunModel()
    model.replace_all([moved])
    verdict = list(COLUMNS).index("Verdict")
    assert "the floor moves" in model.cell(moved, verdict, Qt.ItemDataRole.ToolTipRole)
    # of a run that the operator rejected that is what counts
    assert replace(moved, rejected="rejected by hand").objection == "set aside: by hand"
    assert RunEntry(path, summary={"status": "ok", "verdict": "good", "e": 0.8}).role == "good"
    assert RunEntry(path, summary={"status": "ok", "verdict": "good"}).role == "mark", "it has no e"


def test_a_long_reason_leaves_the_other_runs_in_the_list(window: MainWindow, tmp_path: Path, wait_for: Any) -> None:
    window.panels.go_to("runs")
    runs, reason = window.runs, "the motion is too quick for what the spectra tell " * 9
    known: dict[str, Any] = {"status": "ok", "verdict": "good", "e": 0.8, "u_e": 0.001}
    summaries = (known, {"status": "rejected", "reason": reason}, known)
    runs.show_session(None, [RunEntry(tmp_path / f"run-000{n}.h5", summary=one) for n, one in enumerate(summaries, 1)])
    table = runs.table
    wait_for(lambda: table.rowHeight(1) > table.rowHeight(0))
    assert table.rowHeight(1) < 4 * table.rowHeight(0)


def test_the_words_of_a_run_begin_with_what_speaks_against_it_and_say_each_thing_once(theme: Theme) -> None:
    result = drop_result(rate_hz=2000.0)
    impacts = tuple(replace(one, valid=False) for one in result.bounces.impacts)
    moved = replace(result, bounces=replace(result.bounces, impacts=impacts), findings=(as_stored("the floor moves"),))
    words = QTextDocument()
    words.setHtml(page_of(moved, theme))
    lines = [one for one in words.toPlainText().split("\n") if one]
    assert lines[:5] == ["The floor moves.", "Result", "good, 1 warning", "e of the first impact", "not valid"]
    # what is to be corrected is called as its field is
    words.setHtml(page_of(replace(moved, findings=(as_stored("correct daq.channel_skew_s."),)), theme))
    assert words.toPlainText().startswith("Correct “Channel skew” (Go there).")
    entry = RunEntry(Path("run-0001.h5"), summary={"status": "ok", "warnings": ["correct daq.channel_skew_s."]})
    assert entry.objection == "correct “Channel skew”."
    words.setHtml(page_of(rejected_result(), theme))
    assert words.toPlainText().count("receiver 2: no signal") == 1


def test_a_sentence_in_a_table_of_the_preview_takes_lines_and_a_name_does_not(qtbot: QtBot) -> None:
    rows = ({"run": f"run-000{number}", "reason": "the floor moves and " * number} for number in (1, 9))
    page = templates().get_template("blocks.html").render(blocks=[Grid.of(rows, "Runs", left=(0, 1))])
    view = QTextBrowser()
    qtbot.addWidget(view)
    view.resize(300, 200)
    view.setHtml(SHEET.format(alarm="red") + page)
    view.show()
    QApplication.processEvents()
    assert view.horizontalScrollBar().maximum() == 0
    begin, end = (view.document().find(text) for text in ("run-0001", "run-0009"))
    for name in (begin, end):
        assert name.block().layout().lineCount() == 1
    assert view.document().find("the floor moves", end).block().layout().lineCount() > 2


def test_what_is_looked_for_stands_first_and_no_table_is_wider_than_the_panel(qtbot: QtBot, theme: Theme) -> None:
    view = FiguresView(theme)
    qtbot.addWidget(view)
    # as wide as the panel on a screen of 1366 pixels
    view.resize(294, 400)
    view.show()
    result = drop_result(rate_hz=2000.0)
    view.notes = ("92878 samples, none lost",)
    view.show_result(result)
    QApplication.processEvents()
    assert view.horizontalScrollBar().maximum() == 0
    words = [one for one in view.toPlainText().split("\n") if one]
    # but for what is to be known before it is believed
    assert words[1:6:2] == ["Result", "e of the first impact", "g (combined u)"]
    assert words.index("Recorded") < words.index("Impacts")
    assert "none lost" in words[-1]
    for name in ("Result", "e of the first impact", "g (combined u)"):
        assert view.cursorRect(view.document().find(name)).bottom() < view.viewport().height()


def test_a_long_run_is_seen_before_it_is_processed(panel: RunPanel) -> None:
    low = np.zeros((4, 1000))
    low[0, 500] = np.nan
    overview = Overview(low - 1.0, low + 1.0, 64, 64_000, 1000.0, ("I1", "Q1", "I2", "Q2"))
    panel.show_overview(overview, in_front=False)
    assert panel.tabs.currentIndex() == 0
    panel.show_overview(overview, in_front=True)
    assert panel.tabs.currentWidget() is panel.samples
    assert len(panel.samples.plots) == 2
    time_s, value = boxes(overview, 0)
    assert time_s[-1] == pytest.approx(64.0)
    assert value[:4].tolist() == [-1.0, 1.0, 1.0, -1.0]
    panel.grab()
    for plot in panel.samples.plots:
        first_s, last_s = plot.viewRange()[0]
        assert -5.0 < first_s <= 0.0
        assert 64.0 <= last_s < 70.0


def test_window_and_report_count_bounces_from_the_trigger_and_the_table_from_the_file(
    theme: Theme, setup: Setup, tmp_path: Path
) -> None:
    result = drop_result(rate_hz=2000.0)
    result = replace(result, recording=replace(result.recording, trigger_index=600))
    when = result.bounces.impacts[0].time_s
    page = page_of(result, theme)
    assert f"{when - 0.3:.5f}<" in page
    assert "time after the trigger /\u00a0s" in page
    (table,) = (
        block
        for block in run_section(take_facts(result, "run-0001"), setup).blocks
        if isinstance(block, Grid) and block.title == "Impacts"
    )
    assert table.header[1] == "time after the trigger / s"
    assert table.rows[0][1] == f"{when - 0.3:.5f}"
    write_tables(result, tmp_path)
    first = next(csv.DictReader((tmp_path / "bounces.csv").read_text().splitlines()))
    assert float(first["time_s"]) == pytest.approx(when)


def test_a_page_needs_no_more_room_than_its_own(panel: RunPanel) -> None:
    heights = {}
    for name in ("samples", "phase", "steps", "methods", "phase"):
        panel.tabs.setCurrentWidget(panel.tabs.page(name))
        QApplication.processEvents()
        heights.setdefault(name, []).append(panel.minimumSizeHint().height())
        # nothing of the page itself is cut
        assert panel.minimumSizeHint().height() >= panel.tabs.page(name).minimumSizeHint().height()
    before, after = heights["phase"]
    assert before == after < heights["steps"][0]


def test_what_was_assumed_stands_in_the_units_of_the_fields(theme: Theme) -> None:
    result = drop_result(rate_hz=2000.0)
    assert result.uncertainty_budget is not None
    budget = replace(result.uncertainty_budget, assumed={"receiver[1].u_distance_m": 0.003})
    page = page_of(replace(result, uncertainty_budget=budget), theme)
    assert "Receiver 1: Distance ±</th><td>3.0 mm<" in page
    assert page.count("Assumed, because the setup does not say") == 1
