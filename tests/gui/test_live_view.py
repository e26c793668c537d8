"""Start and Stop: the live view."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from PySide6.QtCore import Qt
from support.compare_dialog import keep_new_result
from support.controlled_source import ControlledSource, codes
from support.shown_plots import points_of, shaded_of

from radargui.experiment.processing_apart import ProcessingHere
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow


def test_the_track_moves_while_the_simulated_sphere_falls(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    window = make_window(setup_path, speed=2.0)
    # the screen of the tests is narrow: planes would stand behind the scopes
    window.actions_.reset_layout.trigger()
    window.actions_.start.trigger()
    wait_for(lambda: window.control.state is AppState.LIVE)
    heights: list[float] = []

    def falling() -> bool:
        shown = window.track.shown
        if shown is not None and np.isfinite(shown.position_mm[2, -1]):
            heights.append(float(shown.position_mm[2, -1]))
        return bool(heights) and max(heights) - min(heights) > 200.0

    wait_for(falling)
    assert all(points_of(scope) > 100 for scope in window.scopes.time.scopes)
    assert points_of(window.planes.raw[0]) > 100
    wait_for(lambda: window.health.labels["rate"].text())
    assert window.bar.state.text == "LIVE   NOT RECORDED"
    assert not window.hardware.findChild(object, "daq.rate_hz").isEnabled()

    window.actions_.stop.trigger()
    wait_for(lambda: window.control.state is AppState.IDLE)
    assert window.hardware.findChild(object, "daq.rate_hz").isEnabled()
    assert window.board.notices == ()


def test_the_key_starts_and_stops(window: MainWindow, qtbot: Any, wait_for: Any) -> None:
    qtbot.keyClick(window, Qt.Key.Key_F5)
    wait_for(lambda: window.control.state is AppState.LIVE)
    qtbot.keyClick(window, Qt.Key.Key_F5)
    wait_for(lambda: window.control.state is AppState.IDLE)


def test_closing_while_live_leaves_no_thread(own_window: MainWindow, wait_for: Any) -> None:
    # those that an earlier window leaves behind end in their own time
    before = set(threading.enumerate())
    own_window.actions_.start.trigger()
    wait_for(lambda: own_window.control.state is AppState.LIVE)
    assert set(threading.enumerate()) - before
    own_window.close()
    wait_for(own_window.isHidden)
    # those that wait for work go, too
    wait_for(lambda: not set(threading.enumerate()) - before)
    assert not own_window.jobs.running


def test_stopping_at_once_after_starting_ends_in_idle(window: MainWindow, wait_for: Any) -> None:
    window.actions_.start.trigger()
    window.actions_.stop.trigger()
    wait_for(lambda: window.control.state is AppState.IDLE)
    assert window.board.notices == ()
    assert window.health.labels["lost"].isHidden(), "nothing is counted any more, so nothing is known to be none"


def test_pausing_holds_the_picture_and_not_the_samples(own_window: MainWindow, wait_for: Any) -> None:
    own_window.actions_.start.trigger()
    wait_for(lambda: own_window.track.shown is not None)
    own_window.scopes.pause.setChecked(True)
    assert own_window.actions_.pause.isChecked()
    held = own_window.track.shown
    read = own_window.control.feed.ring.latest
    wait_for(lambda: own_window.control.feed.ring.latest > read + 6000)
    assert own_window.track.shown is held
    own_window.actions_.pause.setChecked(False)
    wait_for(lambda: own_window.track.shown is not held)


def test_lost_samples_are_shaded_and_counted(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    source = ControlledSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    window.actions_.start.trigger()
    source.push_all(codes(6000))
    source.push(codes(2000, seed=2), lost=1500)
    wait_for(lambda: shaded_of(window.scopes.time.scopes[0]) == 1)
    wait_for(lambda: window.health.labels["lost"].text() == "1500 lost in 1 gap")


def test_the_live_track_says_that_it_starts_anew_after_a_gap_in_a_motion(
    make_window: Any, setup_path: Any, wait_for: Any
) -> None:
    source = ControlledSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    window.actions_.start.trigger()
    source.push_all(codes(12000, moving=slice(8000, 12000), hangs=True))
    source.push(codes(2000, seed=2, moving=slice(0, 2000), hangs=True), lost=1500)
    source.push_all(codes(12000, seed=3, hangs=True))
    anew = "starts anew, as if from the release"
    wait_for(lambda: window.track._title.text() == f"Live track: at rest, {anew}")


def test_a_clipping_channel_lights_its_word(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    source = ControlledSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    window.actions_.start.trigger()
    samples = codes(4000)
    samples[3, 3500:] = 32767
    source.push_all(samples)
    wait_for(lambda: window.scopes.time.levels[3].clipping)
    assert not window.scopes.time.levels[2].clipping


def test_a_source_that_fails_is_told_in_its_own_words(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    source = ControlledSource()
    window = make_window(setup_path, source_maker=lambda *_args, **_options: source)
    window.actions_.start.trigger()
    source.push_all(codes(1000))
    source.fail()
    wait_for(lambda: window.control.state is AppState.FAILED)
    assert window.strip.texts() == ("The device was removed",)
    assert window.actions_.start.isEnabled()


def test_replay_without_a_file_says_what_to_do(window: MainWindow, wait_for: Any) -> None:
    window.hardware.choose("replay")
    window.actions_.start.trigger()
    wait_for(lambda: window.strip.texts())
    assert "Choose one under Hardware setup" in window.strip.texts()[0]
    assert window.control.state is AppState.IDLE


def axis_words(plot: Any) -> str:
    return str(plot.getPlotItem().getAxis("bottom").labelText)


def test_an_axis_says_now_only_while_its_edge_is_now(own_window: MainWindow, wait_for: Any) -> None:
    plots = (own_window.scopes.time.scopes[-1], own_window.track.curves.height_plot)
    held, now = "time to last sample [s]", "time before now [s]"
    assert [axis_words(plot) for plot in plots] == [held, held]
    own_window.actions_.start.trigger()
    wait_for(lambda: own_window.track.shown is not None)
    assert [axis_words(plot) for plot in plots] == [now, now]
    own_window.scopes.pause.setChecked(True)
    assert [axis_words(plot) for plot in plots] == [held, held]
    own_window.scopes.pause.setChecked(False)
    assert [axis_words(plot) for plot in plots] == [now, now]
    own_window.actions_.stop.trigger()
    wait_for(lambda: own_window.control.state is AppState.IDLE)
    assert [axis_words(plot) for plot in plots] == [held, held]


def test_while_results_are_computed_nothing_is_said_of_now(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    go = threading.Event()

    class Held(ProcessingHere):
        """Does a job once it may."""

        def process(self, job: Any, progress: Any, *rest: Any) -> Any:
            while not go.wait(0.01):
                progress(0.4)
            return super().process(job, progress, *rest)

    # slowly enough that a picture is drawn before the recording is over
    own_window = make_window(setup_path, speed=1.0)
    own_window.control.processing = Held
    own_window.setup_model.assign("processing.correction", "none")
    own_window.actions_.record.trigger()
    wait_for(lambda: points_of(own_window.scopes.time.scopes[0]) > 0)
    wait_for(lambda: own_window.control.state is AppState.PROCESSING and own_window.control.progress > 0.0)
    wait_for(lambda: own_window.health.labels["rate"].isHidden())
    plots = (own_window.scopes.time.scopes[-1], own_window.track.curves.height_plot)
    words = "time to last sample [s]"
    wait_for(lambda: [axis_words(plot) for plot in plots] == [words, words])
    wait_for(lambda: all(level.accessibleName().endswith(" –") for level in own_window.scopes.time.levels))
    assert points_of(own_window.scopes.time.scopes[0]) > 0, "the last picture stays"
    go.set()
    wait_for(lambda: own_window.control.state is AppState.DONE)


def test_keys_name_only_what_is_drawn(own_window: MainWindow, record_one: Any, wait_for: Any) -> None:
    own_window.setup_model.assign("processing.correction", "adaptive")
    record_one(own_window)
    assert "samples lost" not in own_window.scopes.key.text()
    key = own_window.track.curves.key
    wait_for(lambda: all(words in key.text() for words in ("parabola", "impacts")))
    own_window.panels.go_to("run")
    own_window.run.tabs.setCurrentWidget(own_window.run.tabs.page("steps"))
    wait_for(lambda: own_window.run.tabs.page("steps").key.text())
    assert "peaks" not in own_window.run.tabs.page("steps").key.text()
    own_window.setup_model.assign("processing.correction", "published")
    own_window.actions_.reprocess.trigger()
    keep_new_result(own_window, wait_for)
    own_window.runs.table.selectRow(0)
    wait_for(lambda: "peaks" in own_window.run.tabs.page("steps").key.text())
    # a circle asks for more samples than a drop of the tests
    own_window.setup_model.assign("daq.rate_hz", 12000.0)
    own_window.setup_model.assign("simulation.scene", "circle")
    own_window.setup_model.assign("processing.correction", "adaptive")
    own_window.setup_model.assign("recording.maximum_s", 1.5)
    own_window.actions_.new_session.trigger()
    record_one(own_window)
    # a key that is empty belongs to the live trail
    wait_for(lambda: "±&nbsp;2&nbsp;u" in key.text() and "impacts" not in key.text())
    assert "parabola" not in key.text()
    assert own_window.runs.series.text() == "no e yet, simulated"
