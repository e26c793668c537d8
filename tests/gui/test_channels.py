"""Bars of the channels: what each shows, a moment that is read for it; and the rate against the device's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import maximum_filter1d
from support.changed import changed
from support.ni_server import ByHand, serve
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.setup.channels import MOMENT_S
from radargui.model.setup import write_setup
from radargui.signals.noise import white_noise_v
from radargui.sources.factory import make_source
from radargui.sources.ni.discovery import NiDevice


def read(window: MainWindow, wait_for: Any) -> Any:
    words = window.channels.words
    window.actions_.moment.trigger()
    wait_for(lambda: not window.control.state.running and words.text() != "Reading …" and not window.jobs.running)
    return window.channels.bars


def test_a_moment_of_the_simulated_source_fills_the_bars_and_records_nothing(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    # turns all the time, however late the moment is read: else it may be a rest
    for key, value in (("scene", "circle"), ("rest_s", 0.0), ("settle_s", 0.0), ("turns", 1000.0)):
        window.setup_model.assign(f"simulation.{key}", value)
    assert window.setup_model.valid
    assert window.channels.bars[3].words == ("Q2 ai3: –", "")
    bars = read(window, wait_for)
    assert window.control.state is AppState.IDLE
    assert window.control.session is None
    assert not list(tmp_path.rglob("*.h5"))
    assert "nothing recorded" in window.channels.words.text()
    setup = window.setup_model.setup
    sigma_v = 0.5**0.5 * 10.0 ** (-setup.simulation.snr_db / 20.0) * setup.simulation.amplitude_v
    # which second of the circle the moment has is the clock's choice
    volts = np.abs(simulate_recording(changed(setup, simulation={"turns": 5.0}))[0].volts())
    whole_s = maximum_filter1d(volts, round(MOMENT_S * setup.daq.rate_hz), axis=1)
    for one, peaks_v in zip(bars, whole_s, strict=True):
        # of some ten thousand samples: known to a hundredth
        assert one.facts.noise_v == pytest.approx(sigma_v, rel=0.05)
        assert peaks_v.min() - 5.0 * sigma_v < one.facts.level.peak_v < peaks_v.max() + 5.0 * sigma_v
        assert not one.clipping
    assert "%" in bars[0].words[0]


def test_a_drift_is_what_the_end_of_a_moment_has_more_than_its_begin(
    window: MainWindow, wait_for: Any, tmp_path: Path
) -> None:
    noise = np.random.default_rng(5).normal(0.0, 0.01, (6, 1000))
    volts = noise + np.linspace(0.0, 0.5, 1000) * np.array([1, 0, 0, 0, 0, -1])[:, None] + 1.0
    path = tmp_path / "drifts.csv"
    table = np.column_stack([np.arange(1000) / 1000.0, volts.T])
    np.savetxt(path, table, delimiter=",", header="time_s,I1,Q1,I2,Q2,I3,Q3", comments="", fmt="%.9f")
    window.hardware.choose("replay")
    window.hardware.replay.file.line.setText(str(path))
    drifts_v = [one.facts.drift_v for one in read(window, wait_for)]
    assert drifts_v == pytest.approx([0.45, 0.0, 0.0, 0.0, 0.0, -0.45], abs=0.01)
    assert "drift" in window.channels.bars[0].toolTip()


def test_a_file_that_is_shorter_than_a_moment_is_read_whole(window: MainWindow, wait_for: Any, tmp_path: Path) -> None:
    volts = np.random.default_rng(3).normal(0.0, 0.01, (6, 600)) + np.arange(6)[:, None]
    table = np.column_stack([np.arange(600) / 1000.0, volts.T])
    path = tmp_path / "short.csv"
    np.savetxt(path, table, delimiter=",", header="time_s,I1,Q1,I2,Q2,I3,Q3", comments="", fmt="%.9f")
    window.hardware.choose("replay")
    window.hardware.replay.file.line.setText(str(path))
    bars = read(window, wait_for)
    assert "the last 0.60 s" in window.channels.words.text()
    # the rule of the corrections, and no other
    assert [one.facts.noise_v for one in bars] == pytest.approx(white_noise_v(volts).tolist(), rel=1e-5)
    assert [one.facts.offset_v for one in bars] == pytest.approx(volts.mean(axis=1).tolist(), abs=1e-6)
    # I² + Q² over twice the variance of one channel, in whole decibels
    said = [one.words[1].partition(",")[0] for one in bars]
    wanted_db = 10.0 * np.log10((np.arange(6.0) ** 2).reshape(3, 2).sum(axis=1) / 2e-4)
    assert said == [f"SNR {one:.0f} dB" for one in wanted_db.repeat(2)]


def test_a_moment_that_cannot_be_read_says_so(window: MainWindow, wait_for: Any) -> None:
    window.hardware.choose("replay")
    window.actions_.moment.trigger()
    assert "No file to replay is chosen" in window.board.notices[0].text
    assert not window.control.state.running
    assert "Nothing could be read" in window.channels.words.text()


def test_a_moment_of_a_device_is_read_through_its_own_client(
    make_window: Any, tmp_path: Path, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("radargui.sources.ni.source.EMPTY_READS", 1000)
    still = changed(
        quick_setup(),
        daq={"rate_hz": 20e6 / 2000, "channel_skew_s": 0.0},
        simulation={"scene": "rest", "rest_s": 2.0, "settle_s": 0.0},
    )
    recording, _ = simulate_recording(still)
    pace = ByHand()
    with serve(recording, pace=pace) as server:
        # the moment waits for no edge
        setup = changed(still, daq={"remote": server.address, "start": "digital", "start_source": "PFI1"})
        write_setup(setup, tmp_path / "lab.toml")
        window = make_window(tmp_path / "lab.toml", source_maker=make_source)
        window.hardware.choose("ni")
        window.actions_.moment.trigger()
        wait_for(lambda: window.control.state is AppState.LIVE)
        assert not window.channels.read.isEnabled()

        def begun() -> bool:
            # live is what is open: whether samples are taken already nobody says
            pace.advance(50)
            feed = window.control.feed
            return feed is not None and feed.ring is not None and feed.ring.latest > 0

        wait_for(begun)
        pace.advance(10_000)
        wait_for(lambda: not window.control.state.running and not window.jobs.running)
        assert not server.tasks
        bars = window.channels.bars
        # at rest any second is like the other, to the drift of the mixers
        volts = recording.volts()
        assert [one.facts.offset_v for one in bars] == pytest.approx(volts.mean(axis=1).tolist(), abs=0.03)
        window.hardware.ni.button.click()
        wait_for(window.hardware.ni.button.isEnabled)
        assert "multiplexed" in window.hardware.rates.words.text()


def test_the_bars_are_kept_up_to_date_while_samples_come_in_and_say_what_clips(
    window: MainWindow, wait_for: Any
) -> None:
    window.setup_model.assign("daq.range_v", 0.5)
    window.actions_.start.trigger()
    window.panels.go_to("channels")
    bar = window.channels.bars[0]
    wait_for(lambda: "CLIPS" in bar.words[0])
    assert bar.isEnabled()
    assert not window.hardware.source.isEnabled()
    image = bar.grab().toImage()
    place = bar.fontMetrics().height() + 4
    assert image.pixelColor(image.width() // 2, round(place * image.height() / bar.height())).name() == (
        window.theme.colours.alarm
    )
    assert "(100 %)" in bar.words[0]
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)


DEVICE = NiDevice("Dev1", "DAQPad-6015", max_rate_single_hz=200e3, max_rate_multi_hz=200e3)


def test_the_rate_of_all_channels_is_held_against_the_device_before_start(window: MainWindow) -> None:
    window.setup_model.assign("daq.rate_hz", 33333.0)
    rates = window.hardware.rates
    assert not rates.isVisibleTo(window.hardware)
    window.hardware.choose("ni")
    assert rates.isVisibleTo(window.hardware)
    assert "Find devices" in rates.words.text()
    assert not rates.bar.isVisibleTo(rates)
    window.hardware.ni._show([DEVICE])
    assert rates.words.text().startswith(
        "6 channels x 33.3 kS/s = 200 kS/s of 200 kS/s (Dev1 (DAQPad-6015), multiplexed"
    )
    assert rates.bar.value() == 1000
    assert not rates.wrong.isVisibleTo(rates)
    window.setup_model.assign("daq.rate_hz", 20000.0)
    assert rates.bar.value() == 600
    window.setup_model.assign("daq.rate_hz", 50000.0)
    assert "is not fast enough" in rates.wrong.text()
    asked: list[object] = []
    window.control._make = lambda *args, **options: asked.append(args)
    for action in (window.actions_.start, window.actions_.record, window.actions_.moment):
        window.board.clear()
        action.trigger()
        assert [notice.text for notice in window.board.notices] == [rates.fault]
        assert not window.control.state.running
    assert not asked
    window.hardware.ni._show([NiDevice("Dev1", "USB-6356", max_rate_multi_hz=1.25e6, simultaneous=True)])
    assert not rates.fault
    assert "6 channels at 50 kS/s of 1.25 MS/s each" in rates.words.text()
    assert "simultaneous" in rates.words.text()
    assert rates.bar.value() == 40
    # a device of that name elsewhere is another one
    window.setup_model.assign("daq.remote", "lab:31763")
    assert "Find devices" in rates.words.text()
