"""The scopes: spectrum, waterfall, bars for aligning, gain and offset, and a pause that can be scrolled back."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDoubleSpinBox
from support.changed import changed
from support.controlled_source import VOLTS_PER_CODE, ControlledSource, digitisation
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.gui.main_window import MainWindow
from radargui.gui.plots.plot import Plot
from radargui.gui.scopes.scope import Gain, GainDialog
from radargui.model.arrays import RawArray
from radargui.model.setup import write_setup

RATE_HZ, DOPPLER_HZ = 10_000.0, 137.0


class Signal:
    """Samples of three receivers: a pointer that turns at a Doppler frequency, and a hum."""

    def __init__(self) -> None:
        self._next = 0
        self._random = np.random.default_rng(3)

    def codes(self, seconds: float, *, amplitudes_v: tuple[float, ...], hum_v: float = 0.0) -> RawArray:
        count = round(seconds * RATE_HZ)
        time_s = (self._next + np.arange(count)) / RATE_HZ
        self._next += count
        rows = []
        for amplitude in amplitudes_v:
            z = amplitude * np.exp(2j * np.pi * DOPPLER_HZ * time_s) + 0.2 - 0.1j
            z += (1.0 + 1.0j) * hum_v * np.cos(2.0 * np.pi * 50.0 * time_s)
            rows += [z.real, z.imag]
        volts = np.stack(rows) + 1e-3 * self._random.standard_normal((2 * len(amplitudes_v), count))
        return np.round(volts / VOLTS_PER_CODE).astype(np.int16)


@pytest.fixture
def source() -> ControlledSource:
    return ControlledSource(digitisation())


@pytest.fixture
def live(
    window: MainWindow, source: ControlledSource, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> Iterator[MainWindow]:
    """The module's window while it shows what the source gives."""
    monkeypatch.setattr(window.control, "_make", lambda *_args, **_options: source)
    window.actions_.reset_layout.trigger()
    window.actions_.start.trigger()
    yield window
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)
    if window.actions_.pause.isChecked():
        window.actions_.pause.trigger()
    window.scopes.view.setCurrentText("Time")
    window.scopes.let_go.click()
    for scope in window.scopes.time.scopes:
        scope.set_gains(Gain(), Gain())
    for plot in window.scopes.findChildren(Plot):
        plot.show_cursors(False)
        plot.view.show_all()


def give(source: ControlledSource, window: MainWindow, wait_for: Any, samples: RawArray) -> None:
    wait_for(source.running.is_set)
    source.push_all(samples, size=1000)
    wait_for(lambda: window.control.feed is not None and window.control.feed.ring.latest == source.next_index)


def test_the_spectrum_reads_frequency_speed_and_amplitude(
    live: MainWindow, source: ControlledSource, wait_for: Any
) -> None:
    live.scopes.view.setCurrentText("Spectrum")
    give(source, live, wait_for, Signal().codes(4.0, amplitudes_v=(0.5, 0.25, 0.1)))
    view = live.scopes.spectrum
    wait_for(lambda: view.spectrum is not None and view.spectrum.span_s > 2.9)
    wavelength = live.setup_model.setup.radar.wavelength_m
    for receiver, amplitude in enumerate((0.5, 0.25, 0.1)):
        line = view.spectrum.strongest(receiver)
        assert line.frequency_hz == pytest.approx(137.0, abs=0.05)
        assert line.amplitude_v == pytest.approx(amplitude, rel=0.02)
    assert f"+137.0 Hz = +{137.0 * wavelength:.3f} m/s, -6.0 dB" in view.words.text()
    top = view.plots[0].getPlotItem().getAxis("top")
    assert top.scale == wavelength
    assert "[m/s]" in top.labelText
    view.plots[0].show_cursors(True)
    view.plots[0].cursors.put(0, 137.0, -6.0)
    at_cursor = view.plots[0].cursors.text.splitlines()[0].partition(" = ")[2]
    assert at_cursor.split()[1] == "m/s"
    assert float(at_cursor.split()[0]) == pytest.approx(137.0 * wavelength, abs=0.5 * wavelength)


def test_a_hum_is_found_in_the_spectrum(live: MainWindow, source: ControlledSource, wait_for: Any) -> None:
    live.scopes.view.setCurrentText("Spectrum")
    give(source, live, wait_for, Signal().codes(4.0, amplitudes_v=(0.5, 0.5, 0.5), hum_v=0.01))
    view = live.scopes.spectrum
    wait_for(lambda: "mains ▼ 50.0 Hz" in view.words.text())
    # by hand as well: a cursor near the peak stands on it
    view.plots[0].show_cursors(True)
    level = 20.0 * np.log10(0.01 / np.sqrt(2.0))
    view.plots[0].cursors.put(0, 50.2, level)
    assert view.plots[0].cursors.marks[0].pos().x() == pytest.approx(50.0, abs=view.spectrum.resolution_hz)
    assert view.plots[0].cursors.marks[0].pos().y() == pytest.approx(level, abs=1.5)


def test_the_hum_of_a_simulated_laboratory_is_found(make_window: Any, tmp_path: Path, wait_for: Any) -> None:
    hum = {"mains": 0.02, "mains_frequency_hz": 60.0, "scene": "rest", "rest_s": 4.0}
    setup = changed(quick_setup(), daq={"rate_hz": 6000.0, "channel_skew_s": 0.0}, simulation=hum)
    write_setup(setup, tmp_path / "lab.toml")
    recording, _ = simulate_recording(setup)
    # not by the clock: what comes in faster than it is drawn has no spectrum
    source = ControlledSource(recording.digitisation)
    window = make_window(tmp_path / "lab.toml", source_maker=lambda *_args, **_options: source)
    window.scopes.view.setCurrentText("Spectrum")
    window.actions_.start.trigger()
    give(source, window, wait_for, recording.raw)
    view = window.scopes.spectrum
    wait_for(lambda: view.spectrum is not None and view.spectrum.span_s > 2.9)
    for receiver in range(3):
        first = view.spectrum.mains(receiver)[0]
        assert first.frequency_hz == pytest.approx(60.0, abs=0.5 * view.spectrum.resolution_hz)
    assert "mains ▼ 60.0 Hz" in view.words.text()


def test_the_waterfall_shows_when_something_moved(live: MainWindow, source: ControlledSource, wait_for: Any) -> None:
    live.scopes.view.setCurrentText("Waterfall")
    signal = Signal()
    give(source, live, wait_for, signal.codes(2.0, amplitudes_v=(0.0, 0.0, 0.0)))
    give(source, live, wait_for, signal.codes(1.0, amplitudes_v=(0.5, 0.5, 0.5)))
    plot = live.scopes.waterfall.plots[0]
    wait_for(lambda: plot._level.size and plot._axes[0][-1] > -0.2 and plot._level.max() > -10.0)
    time_s, frequency_hz = plot._axes
    moving = plot._level.max(axis=1) > -20.0
    assert time_s[moving].min() == pytest.approx(-1.0, abs=0.15)
    assert frequency_hz[plot._level[moving].argmax(axis=1)] == pytest.approx(137.0, abs=10.0)
    names = [name for name, _ in plot.columns()]
    assert names[0].endswith("[s]")
    assert names[1].endswith("Hz [dB re 1 V]")


def test_the_bar_of_a_turned_antenna_follows_and_the_highest_is_held(
    live: MainWindow, source: ControlledSource, wait_for: Any
) -> None:
    live.scopes.view.setCurrentText("Alignment")
    bars, signal = live.scopes.alignment.bars, Signal()
    give(source, live, wait_for, signal.codes(2.0, amplitudes_v=(0.5, 0.5, 0.5)))
    wait_for(lambda: np.allclose(bars.amplitude_v, 0.5, rtol=0.02))
    before = bars.shares.copy()
    # antenna 2 is turned away: half the amplitude, 6 dB
    give(source, live, wait_for, signal.codes(1.5, amplitudes_v=(0.5, 0.25, 0.5)))
    wait_for(lambda: abs(bars.amplitude_v[1] - 0.25) < 0.005)
    assert bars.shares[1] == pytest.approx(before[1] - 6.02 / 40.0, abs=0.01)
    assert bars.shares[0] == pytest.approx(before[0], abs=0.01)
    assert bars.held_v[1] == pytest.approx(0.5, rel=0.02)
    assert ", 6.0 dB below 0.500 V" in bars.text.splitlines()[1]
    # and back beyond where it was
    give(source, live, wait_for, signal.codes(1.5, amplitudes_v=(0.5, 0.6, 0.5)))
    wait_for(lambda: abs(bars.amplitude_v[1] - 0.6) < 0.012)
    assert "the highest so far" in bars.text.splitlines()[1]
    live.scopes.let_go.click()
    assert bars.held_v == pytest.approx(bars.amplitude_v)


def test_without_motion_the_bars_say_what_to_do(live: MainWindow, source: ControlledSource, wait_for: Any) -> None:
    live.scopes.view.setCurrentText("Alignment")
    assert "swing the sphere" in live.scopes.alignment.words.text()
    give(source, live, wait_for, Signal().codes(2.0, amplitudes_v=(0.0, 0.0, 0.0)))
    wait_for(lambda: live.scopes.alignment.words.text().startswith("Nothing moves"))


def test_gain_and_offset_change_the_picture_and_neither_axis_nor_copy_lies(
    live: MainWindow, source: ControlledSource, wait_for: Any, qtbot: Any
) -> None:
    give(source, live, wait_for, Signal().codes(2.0, amplitudes_v=(0.5, 0.5, 0.5)))
    scope = live.scopes.time.scopes[0]
    live.scopes.time.gain.click()
    (dialog,) = live.findChildren(GainDialog)
    factor, offset = dialog.fields[0]
    assert isinstance(factor, QDoubleSpinBox)
    factor.setValue(10.0)
    offset.setValue(0.2)
    give(source, live, wait_for, Signal().codes(0.2, amplitudes_v=(0.5, 0.5, 0.5)))
    # before its first picture there is nothing on it
    wait_for(lambda: np.nanmax(scope.points_of(scope._curves[0])[1], initial=0.0) > 4.5)
    axis = scope.getPlotItem().getAxis("left")
    assert axis.labelText == "scaled"
    assert scope._inside_text == "Rx 1: 10 × (I − 0.2 V),  Q"
    _, volts = scope.data_of(scope._curves[0])
    assert np.nanmax(volts) == pytest.approx(0.7, abs=0.01)
    assert [name for name, _ in scope.columns()][1:] == ["I [V]", "Q [V]"]
    # the cursor on the curve says volts; beside the curves nothing can be said
    scope.show_cursors(True)
    x, y = scope.points_of(scope._curves[0])
    top = int(np.nanargmax(y))
    scope.cursors.put(0, float(x[top]), float(y[top]))
    scope.cursors.put(1, float(x[top]), 100.0)
    a, b, _ = scope.cursors.text.splitlines()
    assert a.endswith("V")
    assert float(a.split()[-2]) == pytest.approx(0.7, abs=0.02)
    assert b.endswith("–")
    dialog.reset()
    assert axis.labelText == "Rx 1 [V]"
    dialog.accept()


def test_a_pause_says_its_time_and_scrolls_back_while_recording_goes_on(
    live: MainWindow, source: ControlledSource, wait_for: Any
) -> None:
    signal, now = Signal(), [1_000_000.0]
    live.scopes._clock = lambda: now[0]
    give(source, live, wait_for, signal.codes(4.0, amplitudes_v=(0.0, 0.0, 0.0)))
    give(source, live, wait_for, signal.codes(5.0, amplitudes_v=(0.5, 0.5, 0.5)))
    live.actions_.pause.trigger()
    now[0] += 12.4
    wait_for(lambda: live.scopes.when.text().endswith(", 12 s ago"))
    assert live.scopes.when.text().startswith("paused at ")
    assert not live.scopes._past.isHidden()
    # ten seconds more push all of that out of the ring
    give(source, live, wait_for, signal.codes(12.0, amplitudes_v=(0.1, 0.1, 0.1)))
    scope = live.scopes.time.scopes[0]

    def reach() -> float:
        return float(np.nanmax(np.abs(scope.points_of(scope._curves[0])[1] - 0.2), initial=0.0))

    wait_for(lambda: reach() == pytest.approx(0.5, abs=0.02))
    live.scopes.back.setFocus()
    for _ in range(40):
        QTest.keyClick(live.scopes.back, Qt.Key.Key_Left)
    wait_for(lambda: 0.0 < reach() < 0.02)
    time_s, _ = scope.points_of(scope._curves[0])
    assert time_s[0] == pytest.approx(-9.0, abs=0.01)
    assert live.scopes.time.scopes[-1].words("bottom") == "time before the pause [s]"
    assert live.control.feed.ring.latest == source.next_index, "nothing was held up"
    live.actions_.pause.trigger()
    wait_for(lambda: reach() == pytest.approx(0.1, abs=0.02))
    assert live.scopes._past.isHidden()


def test_receivers_that_come_and_go_leave_nothing_behind_beside_their_scopes(window: MainWindow, wait_for: Any) -> None:
    view = window.scopes.time
    layout, count = view.layout(), len(view.scopes)
    assert layout is not None
    for now in (count % 4 + 1, count):
        view.set_receivers(now, 10.0)
        # a scope and a column of levels each; what stayed crashed the window once
        assert layout.count() == 2 * now
        wait_for(lambda: view.gain.isVisibleTo(view))
        assert len(view.levels) == 2 * now


def test_what_is_held_is_seen_sample_by_sample_where_it_is_zoomed(
    live: MainWindow, source: ControlledSource, wait_for: Any
) -> None:
    give(source, live, wait_for, Signal().codes(4.0, amplitudes_v=(0.5, 0.5, 0.5)))
    live.actions_.pause.trigger()
    scope = live.scopes.time.scopes[-1]
    wait_for(lambda: scope.notes() and scope.points_of(scope._curves[0])[0].size)
    for _ in range(25):
        scope.view.meant(Qt.Key.Key_Plus)()
    wait_for(lambda: not scope.notes())
    time_s = np.unique(scope.points_of(scope._curves[0])[0])
    assert np.diff(time_s) == pytest.approx(1.0 / RATE_HZ)


def test_after_stop_the_last_seconds_can_still_be_looked_at(
    live: MainWindow, source: ControlledSource, wait_for: Any
) -> None:
    give(source, live, wait_for, Signal().codes(4.0, amplitudes_v=(0.5, 0.5, 0.5)))
    live.actions_.stop.trigger()
    wait_for(lambda: not live.control.state.running)
    live.actions_.pause.trigger()
    assert live.scopes.back.isVisible()
    live.scopes.view.setCurrentText("Spectrum")
    view = live.scopes.spectrum
    wait_for(lambda: view.spectrum is not None and view.spectrum.span_s > 2.9)
    assert view.spectrum.strongest(0).frequency_hz == pytest.approx(137.0, abs=0.05)


def test_after_stop_every_view_shows_the_last_samples_and_none_of_an_earlier_look(
    live: MainWindow, source: ControlledSource, wait_for: Any
) -> None:
    scopes, signal = live.scopes, Signal()
    give(source, live, wait_for, signal.codes(4.0, amplitudes_v=(0.5, 0.5, 0.5)))
    for name in ("Spectrum", "Waterfall", "Alignment"):
        scopes.view.setCurrentText(name)
        wait_for(lambda: _level(live) == pytest.approx(0.5, rel=0.1))
    scopes.view.setCurrentText("Time")
    give(source, live, wait_for, signal.codes(4.0, amplitudes_v=(0.1, 0.1, 0.1)))
    live.actions_.stop.trigger()
    wait_for(lambda: not live.control.state.running)
    for name in ("Spectrum", "Waterfall", "Alignment"):
        scopes.view.setCurrentText(name)
        wait_for(lambda: _level(live) == pytest.approx(0.1, rel=0.1))
    assert scopes.waterfall.plots[-1].words("bottom") == "time to last sample [s]"
    # looked back at while paused the time is counted from the pause, as in the scopes
    live.actions_.pause.trigger()
    scopes.back.setValue(0)
    assert scopes.waterfall.plots[-1].words("bottom") == "time before the pause [s]"
    # and back to the newest, of which the pictures were of the past
    live.actions_.pause.trigger()
    scopes.view.setCurrentText("Time")
    newest = scopes.time.scopes[0]
    wait_for(lambda: newest.points_of(newest._curves[0])[0][-1:] == pytest.approx(0.0, abs=0.01))


@pytest.mark.parametrize(("count", "paused"), [(1, False), (4, False), (4, True)])
def test_after_stop_another_number_of_receivers_is_shown_empty(
    live: MainWindow, source: ControlledSource, wait_for: Any, count: int, paused: bool
) -> None:
    scopes = live.scopes
    give(source, live, wait_for, Signal().codes(4.0, amplitudes_v=(0.5, 0.5, 0.5)))
    scopes.view.setCurrentText("Alignment")
    wait_for(lambda: _level(live) > 0.4)
    live.actions_.stop.trigger()
    wait_for(lambda: not live.control.state.running)
    live.actions_.pause.setChecked(paused)
    scopes.set_receivers(count, 10.0)
    assert not live.actions_.pause.isChecked()
    for name in ("Time", "Spectrum", "Waterfall", "Alignment"):
        scopes.view.setCurrentText(name)
        for _ in range(12):
            scopes.refresh(None)
        assert scopes.spectrum.spectrum is None
    assert scopes.alignment.bars.amplitude_v.size == count
    scopes.set_receivers(3, 10.0)


def _level(window: MainWindow) -> float:
    """Return the highest amplitude that the view in front shows, in V."""
    scopes = window.scopes
    if scopes.view.currentText() == "Alignment":
        return float(scopes.alignment.bars.amplitude_v[0])
    if scopes.view.currentText() == "Spectrum":
        line = scopes.spectrum.spectrum and scopes.spectrum.spectrum.strongest(0)
        return line.amplitude_v if line else 0.0
    levels = scopes.waterfall.plots[0]._level
    return float(10.0 ** (np.nanmax(levels[-levels.shape[0] // 4 :]) / 20.0)) if levels.size else 0.0


def test_the_widest_band_of_the_waterfall_has_room_for_its_figures(
    live: MainWindow, source: ControlledSource, wait_for: Any
) -> None:
    live.scopes.view.setCurrentText("Waterfall")
    live.scopes.band.setCurrentIndex(live.scopes.band.findData(10_000.0))
    give(source, live, wait_for, Signal().codes(2.0, amplitudes_v=(1.0, 1.0, 1.0)))
    view = live.scopes.waterfall
    wait_for(lambda: "78 Hz apart" in view.words.text())
    axis, metrics = view.plots[0].getPlotItem().getAxis("left"), view.fontMetrics()
    assert axis.width() >= metrics.horizontalAdvance("-10000") + metrics.height()
    assert "-0 dB" not in view.words.text()
    live.scopes.band.setCurrentIndex(1)


def test_scopes_share_one_time_base(live: MainWindow) -> None:
    QApplication.processEvents()
    first, *others = live.scopes.time.scopes
    first.view.meant(Qt.Key.Key_Plus)()
    for other in others:
        assert other.view.viewRange()[0] == pytest.approx(first.view.viewRange()[0], abs=1e-6)
        assert other.view.zoomed
