"""What operators of live programs ask for, where no test of a single part shows it."""

from __future__ import annotations

import pkgutil
import threading
from collections.abc import Callable
from typing import Any

import pytest
from PySide6.QtWidgets import QApplication
from support.controlled_source import ControlledSource, codes, digitisation

from radargui.gui.main_window import MainWindow
from radargui.gui.plots.plot import Plot

HEAVY = (
    "radargui.experiment.finished.process",
    "radargui.acquisition.health.white_noise_v",
    "radargui.gui.setup.uncertainty_map.map_of",
    "radargui.session.about.about_lines",
    "radargui.session.session.Session.new_run",
)
"""What computes, or waits for a disk, a device or a driver."""


def test_nothing_heavy_runs_in_the_drawing_thread(
    window: MainWindow, record_one: Any, wait_for: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: dict[str, list[threading.Thread]] = {}

    def watched(name: str, does: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **named: Any) -> Any:
            seen.setdefault(name, []).append(threading.current_thread())
            return does(*args, **named)

        return call

    for name in HEAVY:
        place, _, attribute = name.rpartition(".")
        owner = pkgutil.resolve_name(place)
        monkeypatch.setattr(owner, attribute, watched(name, getattr(owner, attribute)))
    window.panels.go_to("antennas")
    window.antennas.sections.reveal(window.antennas.map)
    before = window.antennas.map.shown
    window.antennas.map.snr.setValue(33.0)
    wait_for(lambda: window.antennas.map.shown is not None and window.antennas.map.shown is not before)
    window.actions_.moment.trigger()
    wait_for(lambda: not window.control.state.running and not window.jobs.running)
    window.actions_.bug_report.trigger()
    record_one(window)
    wait_for(lambda: not window.jobs.running)
    assert sorted(seen) == sorted(HEAVY)
    for name, threads in seen.items():
        assert threading.main_thread() not in threads, name


def test_what_the_scopes_draw_does_not_grow_with_the_rate(make_window: Any, setup_path: Any, wait_for: Any) -> None:
    drawn: dict[float, int] = {}
    for rate_hz in (10e3, 100e3):
        source = ControlledSource(digitisation(rate_hz=rate_hz))
        window = make_window(setup_path, source_maker=lambda *_args, source=source, **_options: source)
        window.actions_.start.trigger()
        source.push_all(codes(round(2.0 * rate_hz)), 2000)
        wait_for(
            lambda source=source, window=window: (
                window.control.feed is not None and window.control.feed.ring.latest >= source.next_index
            )
        )
        window.scopes.refresh(None)
        curves = [curve for plot in window.scopes.findChildren(Plot) for curve in plot.getPlotItem().listDataItems()]
        sizes = [0 if curve.getData()[0] is None else len(curve.getData()[0]) for curve in curves]
        drawn[rate_hz] = max(sizes)
        window.actions_.stop.trigger()
        wait_for(lambda window=window: not window.control.state.running)
    # two points a column of pixels, of which a scope takes 2000 at most
    assert 0 < drawn[100e3] <= 4000
    assert drawn[100e3] <= 1.1 * drawn[10e3]


def test_no_axis_has_a_prefix_of_its_own(window: MainWindow, record_one: Any) -> None:
    record_one(window)
    window.scopes.view.setCurrentText("Spectrum")
    for name in window.panels.docks:
        window.panels.go_to(name)
        QApplication.processEvents()
    # made when they are looked at
    assert all((window.scopes.spectrum.plots, window.series.pages.page("speeds"), window.series.pages.page("falls")))
    plots = window.findChildren(Plot)
    assert len(plots) > 15
    for plot in plots:
        for name in ("left", "bottom"):
            axis = plot.getPlotItem().getAxis(name)
            assert not axis.autoSIPrefix, (plot, name)
            assert axis.autoSIPrefixScale == 1.0, (plot, name)
