"""Banner, list, view across the room, series, title and footer say one thing of the run, after whatever was done."""

from __future__ import annotations

import re
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from support.changed import changed
from support.compare_dialog import keep_new_result
from support.gui_sessions import make_session
from support.stored_runs import SETUP
from support.window_clocks import SeenClock

from radargui.acquisition.run_plan import Ending
from radargui.experiment.event import RecordedRun
from radargui.experiment.processing_apart import ProcessingApart, ProcessingHere
from radargui.experiment.reprocess import own_setup
from radargui.files.run_card import RunCard
from radargui.files.run_file import read_run
from radargui.gui.control.state import AppState, RunWord
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.run_model import COLUMNS, entry_of_recorded
from radargui.gui.runs.situation import Situation
from radargui.model.result import Bounce
from radargui.model.rounding import quantity
from radargui.processing.process import process
from radargui.restitution.series import series_of
from radargui.sources.factory import make_source


@pytest.fixture
def one_window(own_window: MainWindow, wait_for: Any) -> MainWindow:
    """A window with the keys, beside it the view across the room."""
    own_window.activateWindow()
    wait_for(own_window.isActiveWindow)
    own_window.show_view("table")
    return own_window


def settled(window: MainWindow, wait_for: Any) -> None:
    wait_for(lambda: not window.control.state.running and not window.jobs.running and not window.work.busy)
    window.situation.look()


def agree(window: MainWindow, wait_for: Any, word: str, e: str) -> None:
    """Check that all six places say `word` and `e` of one run; `e` empty: that it has none."""
    settled(window, wait_for)
    window.actions_.across.setChecked(True)
    across = window.across.situation
    window.actions_.across.setChecked(False)
    entry = across.entry
    assert entry is not None
    said = f"e = {e}" if e else {"NOT COMPUTED": "e = –"}.get(word, "no e")
    # the line of the list, as it is drawn
    row = window.runs.model.entries.index(entry)
    cell = window.runs.model.index(row, list(COLUMNS).index("e")).data()
    assert cell == (e or "–")
    assert window.bar.state.text.startswith(f"{word}   ")
    assert f"{entry.called}: {said}" in window.bar.state.text
    assert (across.word, across.result, across.run) == (word, said, entry.called)
    assert f"{entry.called}: {said}" in window.windowTitle()
    assert f"({word})" in window.windowTitle()
    assert window.health.run.text().startswith(f"{entry.name}: {word}, {said}")
    # the line of the series, and its panel, which reads the files
    series = series_of([one.drop for one in window.runs.model.entries if not one.rejected])
    assert (f"e = {series.words}" if series.e.n else "") == (window.runs.series.text() if series.e.n else "")
    window.show_view("table")
    wait_for(lambda: window.series.facts is not None and not window.jobs.running)
    (found,) = window.series.facts.findings.sessions
    assert (found.series.e.n, found.series.e.mean) == (series.e.n, series.e.mean)


def shown_e(window: MainWindow, row: int = 0) -> str:
    return window.runs.model.entries[row].restitution()


def test_all_six_agree_after_a_drop_another_rejection_undo_and_an_edited_setup(
    one_window: MainWindow, wait_for: Any, record_one: Any
) -> None:
    window = one_window
    record_one(window)
    first = shown_e(window)
    agree(window, wait_for, "FINAL", first)
    record_one(window)
    agree(window, wait_for, "FINAL", shown_e(window, 1))
    assert "drop 2: " in window.bar.state.text

    # the chosen run is spoken of
    window.runs.table.selectRow(0)
    agree(window, wait_for, "FINAL", first)
    assert "drop 1: " in window.bar.state.text

    window.actions_.reject.trigger()
    agree(window, wait_for, "REJECTED", first)
    assert window.runs.model.series.e.n == 1
    window.actions_.reject.trigger()
    agree(window, wait_for, "FINAL", first)
    assert window.runs.model.series.e.n == 2

    # another result in place of the stored one
    window.setup_model.assign("tracer.diameter_m", 0.03)
    window.panels.go_to("runs")
    QTest.keyClick(window, Qt.Key.Key_F8)
    dialog = window.transfer.dialog
    dialog.compare.click()
    settled(window, wait_for)
    agree(window, wait_for, "FINAL", first)
    keep_new_result(window, wait_for)
    settled(window, wait_for)
    agree(window, wait_for, "FINAL", shown_e(window))
    assert shown_e(window) != first

    path = window.control.session.path
    window.actions_.new_session.trigger()
    settled(window, wait_for)
    assert window.bar.state.text == "IDLE"
    assert window.health.run.text() == ""
    assert "drop" not in window.windowTitle()
    window.sessions.open(path)
    wait_for(lambda: len(window.runs.model.entries) == 2 and window.runs.model.entries[1].summary)
    window.runs.table.selectRow(1)
    agree(window, wait_for, "FINAL", shown_e(window, 1))


def test_of_two_runs_that_wait_each_is_said_with_its_own_result_and_share(
    own_window: MainWindow, record_one: Any
) -> None:
    window, said, shares = own_window, list[tuple[str, str]](), dict[str, list[int]]()
    is_said = {f"run-000{number}": threading.Event() for number in (1, 2)}

    class InTwoSteps(ProcessingHere):
        """Gives a preliminary result, as the joint estimate does, and the other one once that was said."""

        def process(self, job: Any, progress: Any, on_preliminary: Any) -> Any:
            result, live = super().process(job, lambda share: progress(0.5 * share), on_preliminary)
            on_preliminary(replace(result, preliminary=True))
            while not is_said[job.path.stem].wait(0.01):
                progress(0.6)
            return result, live

    window.control.processing = InTwoSteps
    window.setup_model.replace(changed(SETUP, recording={"maximum_s": 0.6}))

    def hear() -> None:
        now, computed = window.situation.now, window.runs.model.entry_of(window.control.backlog.computed)
        if now.state is not AppState.PROCESSING:
            return
        for run, share in re.findall(r"(.*?) ?(\d+) %", now.doing):
            shares.setdefault(run, []).append(int(share))
        # a later one may have its preliminary result already
        if computed is not None and computed.word is not RunWord.NOT_COMPUTED:
            said.append((now.says, f"{computed.called}: {computed.result}"))
            is_said[computed.path.stem].set()

    window.situation.changed.connect(hear)
    window.bar.runs.setValue(2)
    record_one(window)
    assert all(shown.startswith(run) for shown, run in said), said
    assert {run.partition(":")[0] for _, run in said} == {"drop 1", "drop 2"}
    # after the last step of the last one no share of none begins anew
    assert "drop 1" in shares
    assert set(shares) <= {"drop 1", "drop 2"}
    assert all(one == sorted(one) for one in shares.values()), shares


def test_all_six_agree_where_a_preliminary_result_is_left_for_later(
    one_window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    window = one_window
    session = make_session(tmp_path / "data", 4, finish=False)
    window.sessions.open(session)
    settled(window, wait_for)
    path = session / "run-0001.h5"
    quick = replace(process(read_run(path), own_setup(path)), preliminary=True)
    recorded = RecordedRun(1, path, quick, Ending.QUIET, "")
    window.control.run_preliminary.emit(recorded)
    wait_for(lambda: window.bar.state.text.startswith("PRELIMINARY   drop 1: e = "))
    assert window.run.result is quick
    wait_for(lambda: window.runs.series.text() == "no e yet, simulated, 1 preliminary")
    window.control.run_recorded.emit(replace(recorded, result=None))
    agree(window, wait_for, "NOT COMPUTED", "")
    assert window.run.result is None, "no figure stands there that is kept nowhere"


def test_all_six_agree_where_a_recording_is_ended_by_hand_and_where_it_is_read_again(
    seen_window: MainWindow, wait_for: Any
) -> None:
    window = seen_window
    window.activateWindow()
    wait_for(window.isActiveWindow)
    window.show_view("table")
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state is AppState.RECORDING)
    wait_for(lambda: window.control.recorded_s > 0.9)
    QTest.keyClick(window, Qt.Key.Key_Escape)
    settled(window, wait_for)
    (entry,) = window.runs.model.entries
    agree(window, wait_for, entry.word.value, entry.restitution() if entry.has_e else "")
    assert "ended by hand" in window.bar.state.text
    assert "ended by hand" in entry.verdict
    path = window.control.session.path
    window.actions_.new_session.trigger()
    window.sessions.open(path)
    wait_for(lambda: window.runs.model.entries and window.runs.model.entries[0].summary)
    assert "ended by hand" in window.runs.model.entries[0].verdict


def test_esc_while_armed_leaves_a_trace(make_window: Any, setup_path: Path, wait_for: Any) -> None:
    window = make_window(setup_path)
    window.setup_model.assign("simulation.scene", "rest")
    window.setup_model.assign("simulation.rest_s", 60.0)
    window.actions_.record.trigger()
    wait_for(lambda: window.control.state is AppState.ARMED)
    window.actions_.stop.trigger()
    wait_for(lambda: window.bar.state.text == "IDLE   the last recording was ended by hand, no run was kept")
    assert window.situation.now.why == "The last recording was ended by hand, no run was kept."
    window.actions_.start.trigger()
    wait_for(lambda: window.bar.state.text == "LIVE   NOT RECORDED")


@pytest.mark.parametrize(
    ("summary", "word"),
    [
        ({"status": "rejected", "reason": "receiver 2: clipped"}, "REJECTED"),
        ({"status": "no_motion"}, "NO e"),
        ({"status": "ok", "verdict": "good"}, "NO e"),
        ({"status": "ok", "verdict": "good", "e": 0.8, "u_e": 0.1, "preliminary": True}, "PRELIMINARY"),
        (None, "NOT COMPUTED"),
    ],
)
def test_the_large_word_says_what_has_become_of_the_run(
    window: MainWindow, wait_for: Any, tmp_path: Path, summary: Any, word: str
) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4))
    wait_for(lambda: window.runs.model.entries and not window.jobs.running)
    path = window.runs.model.entries[0].path
    window.runs.table.selectRow(0)
    wait_for(lambda: not window.jobs.running)
    window.runs.change(path, summary=summary)
    wait_for(lambda: window.bar.state.text.startswith(f"{word}   drop 1: "))
    assert window.situation.now.role != "good"


def test_all_say_the_live_e_until_the_run_is_computed(make_window: Any, setup_path: Path, wait_for: Any) -> None:
    clock = SeenClock(0.02)
    window = make_window(
        setup_path, source_maker=lambda kind, setup, **options: make_source(kind, setup, clock=clock, **options)
    )
    said: list[Situation] = []
    window.situation.changed.connect(lambda: said.append(window.situation.now))
    window.actions_.record.trigger()

    def is_told() -> bool:
        # the sphere flies on only as far as the live track follows
        if window.control.recorded_s < 0.75:
            clock.go_on()
        return window.control.live_bounce is not None

    wait_for(is_told)
    bounce = window.control.live_bounce
    live = f"live e = {quantity(bounce.e, bounce.u_stated)}"
    assert bounce.e == pytest.approx(0.6, abs=2.0 * bounce.u_stated)
    assert window.bar.state.text.endswith(f"   {live}")
    assert window.situation.now.result == live

    def is_computed() -> bool:
        clock.go_on()
        return bool(window.runs.model.entries) and window.runs.model.entries[0].summary is not None

    wait_for(is_computed)
    window.show_view("table")
    agree(window, wait_for, "FINAL", shown_e(window))
    results = [one.result for one in said if one.state.running and one.result]
    # a dash until then, and never again
    assert results[0] == "e = –"
    assert "e = –" not in results[results.index(live) :]


@pytest.mark.slow
def test_while_the_sphere_still_bounces_the_live_e_becomes_preliminary_and_at_last_final(
    make_window: Any, setup_path: Path, wait_for: Any
) -> None:
    clock = SeenClock(0.02)
    window = make_window(
        setup_path, source_maker=lambda kind, setup, **options: make_source(kind, setup, clock=clock, **options)
    )
    window.setup_model.replace(changed(window.setup_model.setup, processing={"correction": "flights"}))
    window.control.processing = ProcessingApart
    said: list[Situation] = []
    window.situation.changed.connect(lambda: said.append(window.situation.now))
    window.actions_.record.trigger()

    def is_preliminary() -> bool:
        # the sphere flies on only as far as the live track follows
        if window.control.recorded_s < 0.75:
            clock.go_on()
        return window.situation.now.result.endswith(", preliminary")

    wait_for(is_preliminary)
    bounce = window.control.live_bounce
    assert window.control.state is AppState.RECORDING
    assert window.situation.now.result == f"e = {quantity(bounce.e, bounce.u_stated)}, preliminary"
    assert bounce.e == pytest.approx(0.6, abs=3.0 * bounce.u_stated)
    assert any(one.result.startswith("live e = ") for one in said)

    def is_final() -> bool:
        clock.go_on()
        return window.control.state is AppState.DONE

    wait_for(is_final)
    window.show_view("table")
    agree(window, wait_for, "FINAL", shown_e(window))


def test_a_run_that_waits_for_its_result_has_its_live_e_in_the_list_and_in_no_mean(tmp_path: Path) -> None:
    bounce = Bounce(0.3, 2.0, 1.4, 0.7, 4e-4, "parabolas", True, u_e_combined=1.2e-3)
    path = tmp_path / "run-0001.h5"
    recorded = RecordedRun(1, path, None, Ending.QUIET, "", live=bounce)
    entry = entry_of_recorded(recorded, path, RunCard())
    assert entry.cells[list(COLUMNS).index("e")] == "0.7000 ± 0.0012 live"
    assert entry.result == "live e = 0.7000 ± 0.0012"
    assert entry.quality == "recorded, result to come"
    assert series_of([entry.drop]).e.n == 0
    # left for later: it is kept nowhere
    later = entry_of_recorded(recorded, path)
    assert (later.cells[list(COLUMNS).index("e")], later.result) == ("–", "no e")
