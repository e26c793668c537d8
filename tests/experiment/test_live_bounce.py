"""e of the first bounce, live: soon after touch-down, once a run, within its u; nothing where no place is known."""

from __future__ import annotations

import threading
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.controlled_source import LONGEST_S, ControlledSource
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.acquisition.stream import LIVE_BLOCK_S
from radargui.experiment.event import LIVE, Event, EventKind, ExperimentState
from radargui.experiment.live_bounce import first_bounce
from radargui.experiment.series import Experiment
from radargui.live.processor import LiveProcessor
from radargui.live.track import LiveTrack
from radargui.model.recording import Recording, Truth
from radargui.model.result import Bounce
from radargui.model.rounding import quantity
from radargui.model.setup import Setup
from radargui.session.session import Session


def drop(**simulation: object) -> tuple[Recording, Truth, Setup]:
    setup = changed(quick_setup(), daq={"rate_hz": 10_000.0}, simulation={"restitution": 0.7, **simulation})
    return *simulate_recording(setup), setup


class Followed:
    """The live track of a recording, block by block."""

    def __init__(self, recording: Recording, setup: Setup) -> None:
        self.recording, self.setup, self.rate_hz = recording, setup, recording.digitisation.sample_rate_hz
        self._processor = LiveProcessor(setup, recording.digitisation)
        self.track = LiveTrack(setup.n_receivers, self.rate_hz, recording.n_samples / self.rate_hz)

    def told(self, lost: slice = slice(0)) -> tuple[float, Bounce | None]:
        """Return when the first bounce is told, in s, and the bounce; samples that are `lost` never come."""
        block = round(LIVE_BLOCK_S * self.rate_hz)
        for first in range(0, self.recording.n_samples, block):
            if not lost.start or not lost.start <= first < lost.stop:
                samples = self.recording.raw[:, first : first + block]
                self.track.append(self._processor.push(samples, first))
            if (bounce := first_bounce(self.track, 0, self.setup)) is not None:
                return (first + block) / self.rate_hz, bounce
        return np.inf, None


@pytest.mark.parametrize("restitution", [0.3, 0.7, 0.9])
def test_e_is_told_a_tenth_of_a_second_after_touch_down_within_its_u(restitution: float) -> None:
    recording, truth, setup = drop(restitution=restitution)
    told_s, bounce = Followed(recording, setup).told()
    assert bounce is not None
    impact_s = float(truth.impact_time_s[0])
    assert 0.0 < told_s - impact_s < 0.15
    assert bounce.time_s == pytest.approx(impact_s, abs=1e-3)
    assert bounce.e == pytest.approx(restitution, abs=2.0 * bounce.u_stated)
    assert bounce.u_stated < 0.01 * restitution


def test_nothing_is_told_of_a_fall_that_ends_dead_or_across_a_gap() -> None:
    recording, truth, setup = drop(restitution=0.0)
    assert Followed(recording, setup).told()[1] is None
    recording, truth, setup = drop()
    impact = int(truth.impact_time_s[0] * 10_000.0)
    assert Followed(recording, setup).told(lost=slice(impact - 300, impact + 100))[1] is None


def test_of_a_run_that_has_just_begun_nothing_is_told() -> None:
    recording, _, setup = drop()
    followed = Followed(recording, setup)
    assert first_bounce(followed.track, 0, setup) is None
    followed.told()
    assert first_bounce(followed.track, recording.n_samples, setup) is None


def test_two_receivers_tell_no_place_and_no_e() -> None:
    plain = changed(quick_setup(), daq={"rate_hz": 10_000.0}).model_dump(by_alias=True, exclude_unset=True)
    plain["receiver"], plain["daq"]["channels"] = plain["receiver"][:2], ["ai0", "ai1", "ai2", "ai3"]
    setup = Setup.model_validate(plain)
    recording, _ = simulate_recording(setup)
    assert Followed(recording, setup).told()[1] is None


def test_an_experiment_tells_it_once_a_run_and_hands_it_on_with_the_run(tmp_path: Path) -> None:
    recording, truth, setup = drop()
    source, told, events = ControlledSource(recording.digitisation), threading.Event(), list[Event]()

    def hear(event: Event) -> None:
        events.append(event)
        if event.kind is EventKind.BOUNCE:
            told.set()

    session = Session.create(tmp_path, setup, now=datetime(2026, 11, 24, tzinfo=UTC))
    experiment = Experiment(setup, lambda _run: source, session, listener=hear, process=False)

    def feed() -> None:
        assert source.running.wait(LONGEST_S)
        flown = int((truth.impact_time_s[0] + 0.2) * recording.digitisation.sample_rate_hz)
        source.push_all(recording.raw[:, :flown])
        # the sphere still flies
        told.wait(LONGEST_S)
        source.push_all(recording.raw[:, flown:])
        source.end()

    feeder = threading.Thread(target=feed)
    feeder.start()
    try:
        (run,) = experiment.record(1)
    finally:
        told.set()
        feeder.join()
    (bounce,) = [event for event in events if event.kind is EventKind.BOUNCE]
    (taken,) = [event for event in events if event.kind is EventKind.RECORDED]
    assert events.index(bounce) < events.index(taken)
    assert bounce.bounce is not None
    assert bounce.bounce.e == pytest.approx(0.7, abs=2.0 * bounce.bounce.u_stated)
    assert bounce.message == f"live e = {quantity(bounce.bounce.e, bounce.bounce.u_stated)}"
    assert taken.run is not None
    assert taken.run.live is bounce.bounce
    assert (bounce.number, taken.number) == (1, 1)
    assert run.path is not None
    session.close()


@pytest.mark.slow
def test_the_flights_tell_e_while_the_sphere_still_bounces_and_the_whole_record_has_the_last_word(
    tmp_path: Path,
) -> None:
    recording, truth, setup = drop()
    setup = changed(setup, processing={"correction": "flights"})
    source, told, events = ControlledSource(recording.digitisation), threading.Event(), list[Event]()

    def hear(event: Event) -> None:
        events.append(event)
        if event.message.startswith("preliminary e = "):
            told.set()

    session = Session.create(tmp_path, setup, now=datetime(2026, 11, 24, tzinfo=UTC))
    experiment = Experiment(setup, lambda _run: source, session, listener=hear)

    def feed() -> None:
        assert source.running.wait(LONGEST_S)
        flown = int((truth.impact_time_s[0] + 0.2) * recording.digitisation.sample_rate_hz)
        source.push_all(recording.raw[:, :flown])
        # what computes it is a process that has to begin first
        told.wait(3.0 * LONGEST_S)
        source.push_all(recording.raw[:, flown:])
        source.end()

    feeder = threading.Thread(target=feed)
    feeder.start()
    try:
        (run,) = experiment.record(1)
    finally:
        told.set()
        feeder.join()
    session.close()
    shown = (EventKind.BOUNCE, EventKind.RECORDED, EventKind.PRELIMINARY, EventKind.RUN)
    live, early, taken, preliminary, final = (event for event in events if event.kind in shown)
    assert [live.kind, early.kind, taken.kind, preliminary.kind, final.kind] == [EventKind.BOUNCE, *shown]
    assert live.bounce is not None
    assert early.bounce is not None
    assert (live.bounce.method, early.bounce.method) == (LIVE, "flights")
    assert early.state is ExperimentState.RECORDING
    assert early.message == f"preliminary e = {quantity(early.bounce.e, early.bounce.u_stated)}"
    # this correction has no other preliminary result
    assert preliminary.run is not None
    assert preliminary.run.result is not None
    assert run.result is not None
    assert preliminary.run.path == run.path
    assert preliminary.run.result.preliminary
    assert not run.result.preliminary
    assert preliminary.run.result.recording.n_samples < run.result.recording.n_samples
    first, last = preliminary.run.result.bounces.impacts[0], run.result.bounces.impacts[0]
    assert first == early.bounce
    assert first.e == pytest.approx(last.e, abs=3.0 * (first.u_stated + last.u_stated))
    assert first.e == pytest.approx(0.7, abs=3.0 * first.u_stated)
    assert first.time_s == pytest.approx(last.time_s, abs=2e-4)
