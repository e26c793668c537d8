"""The series: statistics, e against speed, falls; runs left out with a reason, noted, sorted, selected and copied."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog, QLabel, QWidget
from support.gui_sessions import make_height, make_session

from radargui.gui.main_window import MainWindow
from radargui.gui.runs.run_keeping import REASONS
from radargui.gui.runs.run_model import COLUMNS as RUN_COLUMNS
from radargui.gui.series import COLUMNS, SeriesRow, mark_of, role_of
from radargui.gui.table import RowModel, RowTable, sort_key
from radargui.model.rounding import alone
from radargui.processing.result_of_run import stored_result
from radargui.report import facts
from radargui.report.facts import report_facts
from radargui.report.findings_section import front_chapters
from radargui.report.report import study_session
from radargui.restitution.statistics import statistics_of
from radargui.session.session import BY_OPERATOR, Session, reason_of, was_drop

HEIGHTS_M = (0.26, 0.18, 0.11)
G = 9.80665


def idle(window: MainWindow, wait_for: Any) -> None:
    wait_for(lambda: not window.jobs.running)


def opened(window: MainWindow, path: Path, wait_for: Any) -> None:
    window.sessions.open(path)
    idle(window, wait_for)


def cells(table: Any, row: int) -> list[str]:
    model = table.model()
    return [str(model.index(row, column).data()) for column in range(model.columnCount())]


@pytest.fixture
def three(tmp_path: Path) -> list[Path]:
    about = {"sample": "steel", "target": "glass"}
    return [make_height(tmp_path / "data", day, height, **about) for day, height in enumerate(HEIGHTS_M, 4)]


def test_three_heights_are_compared(window: MainWindow, wait_for: Any, three: list[Path]) -> None:
    opened(window, three[0], wait_for)
    window.show_view("table")
    panel = window.series
    wait_for(lambda: panel.facts is not None)
    assert panel.table.isColumnHidden(0), "of one session its name need not stand in each row"
    panel.compare.click()
    browser = window.sessions.browser
    wait_for(lambda: not browser.looks.busy and len(browser.model.entries) == 3)
    browser.table.selectAll()
    browser.compare.click()
    wait_for(lambda: panel.facts is not None and len(panel.facts.sessions) == 3)
    assert not browser.isVisible()

    # one table, from the statistics that the report has
    folders = [three[0].parent / one.info.name for one in panel.facts.sessions]
    assert sorted(folders) == sorted(three)
    own = [study_session(Session.open(path, write=False), stored_result) for path in folders]
    found = report_facts(own, "").findings
    shown = {one.name: one for one in panel.facts.findings.sessions}
    for one in found.sessions:
        assert shown[one.name].series.e == one.series.e
        assert shown[one.name].series.g_m_s2 == one.series.g_m_s2
    assert panel.table.rows.rowCount() == 12
    row = next(row for row in range(12) if cells(panel.table, row)[:2] == [three[1].name, "e"])
    e = next(one for one in found.sessions if one.name == three[1].name).series.e
    assert cells(panel.table, row)[2] == "2"
    assert cells(panel.table, row)[4:6] == [alone(one, e.u) for one in (e.standard_deviation, e.standard_error)]

    # e against the impact speed: three groups of first impacts, where the heights say
    panel.pages.setCurrentWidget(panel.pages.page("speeds"))
    dots = [item for item in panel.pages.page("speeds").plot.getPlotItem().listDataItems() if item.opts.get("symbol")]
    assert len({item.opts["symbol"] for item in dots}) == 3
    assert all(sign in panel.pages.page("speeds").key.text() for sign in "●■▲")
    fastest = sorted(float(item.xData.max()) for item in dots)
    assert fastest == pytest.approx(sorted(np.sqrt(2.0 * G * np.array(HEIGHTS_M))), rel=0.01)
    # first impacts are the fastest
    shown = [sorted(item.yData[item.xData > 0.9 * item.xData.max()]) for item in dots]
    opened_again = [Session.open(path, write=False) for path in three]
    stored = [[stored_result(run, one.setup).bounces.impacts[0].e for run in one.run_paths()] for one in opened_again]
    assert np.sort(shown, axis=0) == pytest.approx(np.sort([sorted(one) for one in stored], axis=0), abs=1e-9)
    panel.pages.page("speeds").model.setCurrentIndex(panel.pages.page("speeds").model.findData("power"))
    (fit,) = panel.pages.page("speeds").fits
    assert fit == next(one for one in found.samples[0].fits if one.model == "power")
    assert fit.words in panel.pages.page("speeds").words.text()

    # all falls lie on one parabola
    panel.pages.setCurrentWidget(panel.pages.page("falls"))
    items = [item for item in panel.pages.page("falls").fallen.getPlotItem().items if hasattr(item, "xData")]
    *falls, parabola = [item for item in items if not item.opts.get("symbol")]
    assert len(falls) == 3, "one curve a session"
    assert len({item.opts["symbol"] for item in items if item.opts.get("symbol")}) == 3
    assert parabola.yData == pytest.approx(
        500.0 * panel.facts.findings.sessions[0].series.g_m_s2.mean * parabola.xData**2, rel=0.02
    )
    for fall in falls:
        known = np.isfinite(fall.yData)
        assert np.count_nonzero(~known) == 2, "two drops, each with its end"
        on_parabola = np.interp(fall.xData[known], parabola.xData, parabola.yData)
        assert fall.yData[known] == pytest.approx(on_parabola, abs=1.5)
    ends = sorted(float(np.nanmax(fall.yData)) for fall in falls)
    assert ends == pytest.approx(sorted(1e3 * np.array(HEIGHTS_M)), rel=0.05)
    assert "180 mm" in panel.pages.page("falls").key.text().replace("&nbsp;", " ")

    # in words, and as rows for a spreadsheet
    assert found.sentence in panel.words.toPlainText()
    panel.pages.setCurrentWidget(panel.table)
    panel.table.selectAll()
    window.activateWindow()
    wait_for(window.isActiveWindow)
    panel.table.setFocus()
    QTest.keyClick(panel.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = [line.split("\t") for line in QApplication.clipboard().text().splitlines()]
    assert lines[0] == [title.replace("\n", " ") for title in COLUMNS]
    assert len(lines) == 13
    assert lines[1:] == [cells(panel.table, row) for row in range(12)]

    panel.alone.click()
    wait_for(lambda: len(panel.facts.sessions) == 1)
    assert panel.table.rows.rowCount() == 4


def test_the_series_runs_along_with_each_run_and_reads_nothing_unseen(
    own_window: MainWindow, wait_for: Any, record_one: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []
    glance = facts.glance
    monkeypatch.setattr(facts, "glance", lambda path, normal: read.append(path.stem) or glance(path, normal))
    record_one(own_window)
    idle(own_window, wait_for)
    assert read == []
    own_window.show_view("table")
    wait_for(lambda: own_window.series.facts is not None and own_window.series.table.rows.entries[0].found.n == 1)
    assert own_window.series.table.rows.entries[0].found == own_window.runs.model.series.e
    assert own_window.series._title.text().endswith("simulated, 1 run")
    # Record goes where it is measured; who comes back sees the series run along
    own_window.actions_.record.trigger()
    own_window.show_view("table")
    wait_for(lambda: own_window.series.table.rows.entries[0].found.n == 2)
    assert own_window.series.table.rows.entries[0].found == own_window.runs.model.series.e
    assert cells(own_window.series.table, 0)[2] == "2"
    assert read.count("run-0001") == 1, "what did not change is not read again"


def test_of_several_samples_each_fit_says_of_which_it_is(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    folder = tmp_path / "data"
    paths = [
        make_height(folder, 4, 0.26, sample="steel", target="glass"),
        make_height(folder, 5, 0.18, sample="agate", target="glass"),
    ]
    opened(window, paths[0], wait_for)
    window.show_view("table")
    window.series.show_beside(tuple(paths[1:]))
    panel = window.series
    wait_for(lambda: panel.facts is not None and len(panel.facts.sessions) == 2)
    fits = [line for line in panel.words.toPlainText().splitlines() if "constant: e0" in line]
    assert [line.partition(":")[0] for line in fits] == ["steel on glass", "agate on glass"]
    panel.pages.setCurrentWidget(panel.pages.page("speeds"))
    panel.pages.page("speeds").model.setCurrentIndex(panel.pages.page("speeds").model.findData("power"))
    assert [
        one.partition(":")[0] for one in panel.pages.page("speeds").words.text().split("; ") if " law: " in one
    ] == [
        "steel on glass",
        "agate on glass",
    ]
    panel.alone.click()


def test_the_key_of_many_sessions_takes_the_lines_it_needs(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    paths = [make_height(tmp_path / "data", 10 + day, 0.18) for day in range(5)]
    opened(window, paths[0], wait_for)
    window.show_view("table")
    window.series.show_beside(tuple(paths[1:]))
    panel = window.series
    wait_for(lambda: panel.facts is not None and len(panel.facts.sessions) == 5)
    for page in (panel.pages.page("speeds"), panel.pages.page("falls")):
        panel.pages.setCurrentWidget(page)
        key = page.key
        wait_for(lambda key=key: key.height() >= key.heightForWidth(key.width()))
        assert key.height() > key.fontMetrics().height() * 1.5
        assert "2026-05-14" in key.text()
        assert window.panels.docks["run"].widget().verticalScrollBar().maximum() == 0, "the plots have room beside it"
    panel.alone.click()


def answering(words: str) -> Callable[[QInputDialog], int]:
    """Return what the operator does who is asked, and says this."""

    def answer(ask: QInputDialog) -> int:
        ask.setTextValue(words)
        return 1

    return answer


def test_a_run_is_left_out_with_a_reason_that_window_and_report_know(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_height(tmp_path / "data", 7, 0.18, n_runs=3)
    opened(window, path, wait_for)
    window.show_view("table")
    wait_for(lambda: window.series.facts is not None and window.series.table.rows.entries[0].found.n == 3)
    window.runs.table.selectRow(1)
    idle(window, wait_for)
    said = "touched the rail"
    monkeypatch.setattr("PySide6.QtWidgets.QInputDialog.exec", answering(said))
    window.actions_.exclude.trigger()
    wait_for(lambda: window.series.table.rows.entries[0].found.n == 2)
    session = window.control.session
    assert session is not None
    assert Session.open(path, write=False).rejected == {"run-0002.h5": f"{BY_OPERATOR}: {said}"}
    entry = window.runs.model.entries[1]
    assert entry.verdict == f"set aside, SIMULATED: {said}"
    assert (entry.label, window.runs.model.entries[2].label) == ("2", "3"), "it was a drop and keeps its number"
    facts = study_session(session, stored_result)
    assert report_facts([facts], "").findings.sessions[0].series.e == window.series.table.rows.entries[0].found
    assert any(said in str(block) for block in front_chapters(report_facts([facts], ""))[0].blocks)
    assert said in window.series.words.toPlainText()
    assert [run.label for run in facts.runs] == ["1", "3"]
    # taken back by the same key as one without a reason
    window.runs.rejected.setChecked(True)
    window.runs.table.selectRow(1)
    window.actions_.reject.trigger()
    wait_for(lambda: window.series.table.rows.entries[0].found.n == 3)
    assert Session.open(path, write=False).rejected == {}


def test_a_reason_is_chosen_or_typed_and_cancel_is_no_reason(window: MainWindow) -> None:
    offered: list[list[str]] = []

    def answer(accept: bool) -> None:
        dialog = QApplication.activeModalWidget()
        assert isinstance(dialog, QInputDialog)
        offered.append(dialog.comboBoxItems())
        dialog.setTextValue(" bumped ")
        dialog.accept() if accept else dialog.reject()

    QTimer.singleShot(0, lambda: answer(True))
    assert window.keeping.ask_words("Reject", "Why?", REASONS) == "bumped"
    QTimer.singleShot(0, lambda: answer(False))
    assert window.keeping.ask_words("Note", "What?", ()) == ""
    assert offered == [list(REASONS), []]


def test_nothing_happens_where_no_reason_is_given(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened(window, make_session(tmp_path / "data", 4), wait_for)
    monkeypatch.setattr("PySide6.QtWidgets.QInputDialog.exec", lambda _ask: 0)
    window.actions_.exclude.trigger()
    window.actions_.note_run.trigger()
    idle(window, wait_for)
    assert window.control.session.rejected == {}
    assert window.control.session.info.journal == ()


def test_many_runs_are_selected_rejected_and_copied(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    opened(window, make_height(tmp_path / "data", 7, 0.18, n_runs=3), wait_for)
    chosen: list[Any] = []
    window.runs.run_chosen.connect(chosen.append)
    table = window.runs.table
    table.selectRow(0)
    QTest.mouseClick(
        table.viewport(),
        Qt.MouseButton.LeftButton,
        Qt.KeyboardModifier.ShiftModifier,
        table.visualRect(table.model().index(2, 0)).center(),
    )
    assert [entry.name for entry in table.all_chosen] == ["run-0001", "run-0002", "run-0003"]
    assert [entry.name for entry in chosen] == ["run-0001"], "who selects many wants to look at none"
    table.copy_rows()
    lines = [line.split("\t") for line in QApplication.clipboard().text().splitlines()]
    assert lines[0] == [title for title in RUN_COLUMNS if title not in ("Note", "e of times")], (
        "what is hidden is not copied"
    )
    assert [line[0] for line in lines[1:]] == ["1", "2", "3"]
    assert lines[1][4] == window.runs.model.entries[0].restitution()
    window.actions_.reject.trigger()
    wait_for(lambda: sum(bool(one.rejected) for one in window.runs.model.entries) == 3)
    idle(window, wait_for)
    assert len(window.control.session.rejected) == 3
    assert window.board.notices[0].text.startswith("3 runs are rejected")


def test_a_note_about_a_run_stands_in_the_list_and_in_the_report(
    window: MainWindow, wait_for: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_session(tmp_path / "data", 4)
    opened(window, path, wait_for)
    note = list(RUN_COLUMNS).index("Note")
    assert window.runs.table.isColumnHidden(note)
    assert not window.runs.table.columns_chosen, "nobody set a width"
    monkeypatch.setattr("PySide6.QtWidgets.QInputDialog.exec", answering("polished <b>before</b>"))
    window.actions_.note_run.trigger()
    wait_for(lambda: window.runs.model.entries[0].note)
    assert not window.runs.table.isColumnHidden(note)
    assert cells(window.runs.table, 0)[note] == "polished <b>before</b>"
    (entry,) = Session.open(path, write=False).info.journal
    assert (entry.run, entry.index) == ("run-0001.h5", None)
    window.control.use_session(None)
    opened(window, path, wait_for)
    assert window.runs.model.entries[0].note == "polished <b>before</b>"
    session = Session.open(path, write=False)
    chapters = front_chapters(report_facts([study_session(session, stored_result)], "now"))
    assert "run-0001: polished <b>before</b>" in str(chapters)


def test_a_click_on_a_title_sorts_by_size_and_rows_stay_what_they_are(
    own_window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    opened(own_window, make_height(tmp_path / "data", 7, 0.18, n_runs=3), wait_for)
    table = own_window.runs.table
    e = list(RUN_COLUMNS).index("e")
    table.sortByColumn(e, Qt.SortOrder.DescendingOrder)
    shown = [cells(table, row)[e] for row in range(3)]
    assert shown == sorted(shown, reverse=True)
    assert len(set(shown)) > 1
    entries = sorted(own_window.runs.model.entries, key=lambda one: one.summary["e"], reverse=True)
    for row, entry in enumerate(entries):
        table.selectRow(row)
        assert table.chosen.name == entry.name
    own_window.runs.change(entries[0].path, rejected=BY_OPERATOR)
    assert [table.isRowHidden(row) for row in range(3)] == [True, False, False]
    table.sortByColumn(-1, Qt.SortOrder.AscendingOrder)
    assert [cells(table, row)[0] for row in range(3)] == ["1", "2", "3"]
    idle(own_window, wait_for)


def test_numbers_come_before_words_and_dashes_last() -> None:
    given = ["–", "good", "0.801 ± 0.002", "", "0.79999 ± 0.00026", "12", "-3", "(9.81 ± 0.01) m/s²", "4.6 × 10⁻⁶"]
    expected = ["-3", "4.6 × 10⁻⁶", "0.79999 ± 0.00026", "0.801 ± 0.002", "(9.81 ± 0.01) m/s²", "12", "good", "–", ""]
    assert sorted(given, key=sort_key) == expected


def test_a_reason_of_the_operator_is_told_from_what_was_no_drop() -> None:
    assert was_drop(reason_of(""))
    assert was_drop(reason_of("bumped"))
    assert not was_drop("no fall")
    assert not was_drop("rejected by the operators of old")


def test_twenty_sessions_look_different_and_neighbours_in_colour_and_mark() -> None:
    looks = [(role_of(number), *mark_of(number)) for number in range(20)]
    assert len(set(looks)) == 20
    assert all(one[0] != other[0] and one[1] != other[1] for one, other in pairwise(looks))


def test_a_statistics_table_of_long_figures_fits_its_panel(qtbot: Any) -> None:
    table = RowTable(RowModel(COLUMNS), "series")
    qtbot.addWidget(table)
    table.setColumnHidden(0, True)
    table.resize(488, 200)
    table.show()
    found = statistics_of([0.80000123, 0.80000456, 0.79999789], [1e-7] * 3, [1.2e-6] * 3)
    table.show_rows([SeriesRow("", "Impact [m/s]", found)])
    QApplication.processEvents()
    assert table.horizontalScrollBar().maximum() == 0


def test_an_empty_series_says_what_to_wait_for(window: MainWindow, wait_for: Any) -> None:
    window.show_view("table")
    idle(window, wait_for)
    assert window.series._title.text() == "No session"
    window.series.pages.setCurrentWidget(window.series.pages.page("speeds"))
    assert window.series.pages.page("speeds").plot.when_empty == "No valid impact yet."
    window.series.pages.setCurrentWidget(window.series.pages.page("falls"))
    assert window.series.pages.page("falls").fallen.when_empty == "No fall was fitted yet."


def test_preliminary_results_are_counted_beside_the_means_in_which_they_are_not(
    window: MainWindow, tmp_path: Path
) -> None:
    final = study_session(Session.open(make_session(tmp_path, 4, n_runs=2), write=False), stored_result)
    quick = [replace(one, figures={**(one.figures or {}), "preliminary": True}) for one in final.runs]
    panel = window.series
    panel.show_facts(report_facts([replace(final, runs=(final.runs[0], quick[1]))], ""))
    assert words_in(panel, f"{final.info.name}: simulated, 2 runs, 1 preliminary")
    assert panel.table.rows.entries[0].found.n == 1
    panel.show_facts(report_facts([final], ""))
    assert words_in(panel, f"{final.info.name}: simulated, 2 runs")
    panel.show_facts(None)


def words_in(panel: QWidget, words: str) -> bool:
    return words in [one.text() for one in panel.findChildren(QLabel)]


def test_the_distribution_and_what_e_depends_on_are_those_of_the_report(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    path = make_height(tmp_path / "data", 4, 0.26, n_runs=5, sample="steel", target="glass")
    opened(window, path, wait_for)
    window.show_view("table")
    panel = window.series
    wait_for(lambda: panel.facts is not None and len(panel.facts.sessions[0].runs) == 5)
    (own,) = report_facts([study_session(Session.open(path, write=False), stored_result)], "").findings.sessions
    spread = panel.pages.page("spread")
    panel.pages.setCurrentWidget(spread)
    assert own.distribution is not None
    assert spread.words.text() == own.distribution.words
    density, histogram = (item for item in spread.plot.getPlotItem().items if hasattr(item, "xData"))
    assert density.yData == pytest.approx(own.distribution.density)
    assert np.trapezoid(histogram.yData, histogram.xData) == pytest.approx(1.0)
    (low, high), _ = spread.plot.getPlotItem().viewRange()
    assert low < own.distribution.prediction_low < own.distribution.prediction_high < high

    speeds = panel.pages.page("speeds")
    panel.pages.setCurrentWidget(speeds)
    speeds.against.setCurrentIndex(speeds.against.findData("drop"))
    dots = [item for item in speeds.plot.getPlotItem().listDataItems() if item.opts.get("symbol")]
    assert set(dots[0].xData) == {1.0, 2.0, 3.0, 4.0, 5.0}
    assert "number of the drop" in speeds.words.text()
    assert not speeds.model.isEnabled()
    speeds.against.setCurrentIndex(speeds.against.findData("diameter_m"))
    assert "all impacts have one diameter" in speeds.words.text()
    assert not [item for item in speeds.plot.getPlotItem().listDataItems() if item.opts.get("symbol")]
    speeds.against.setCurrentIndex(speeds.against.findData("speed"))
    assert speeds.model.isEnabled()
    assert "of 5 drops" in panel.words.toPlainText() or "5 simulated drops" in panel.words.toPlainText()
    assert own.distribution.words in panel.words.toPlainText()
