"""How a run was corrected, for every method, and methods laid over each other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot
from support.changed import changed
from support.gui_sessions import make_session
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.experiment.compare import OverlaidMethod, compute_methods, overlaid
from radargui.gui.main_window import MainWindow
from radargui.gui.runs.correction_view import CorrectionView
from radargui.gui.theme import Theme
from radargui.model.errors import ProcessingError
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.setup import CORRECTIONS
from radargui.processing.process import process
from radargui.report.curves import take_curves
from radargui.signals.ellipse import Ellipse

SETUP = changed(quick_setup(), daq={"rate_hz": 3000.0, "channel_skew_s": 0.0, "channels": None})


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate_recording(SETUP)[0]


@pytest.fixture(scope="module")
def by(recording: Recording) -> Any:
    made: dict[str, RunResult] = {}

    def result(method: str) -> RunResult:
        if method == "joint":
            # in its place what it would be: the estimate itself takes seconds
            found = result("published")
            decided = "A floor that reflects is kept: log evidence +12.", "Misfit (chi-square) 1.00, 0.98, 1.02."
            corrected = replace(found.corrected, method="joint", steps=(), decisions=decided)
            made[method] = replace(found, corrected=corrected)
        elif method not in made:
            made[method] = process(recording, changed(SETUP, processing={"correction": method}))
        return made[method]

    return result


@pytest.fixture
def view(qtbot: QtBot, theme: Theme) -> CorrectionView:
    view = CorrectionView(theme)
    qtbot.addWidget(view)
    view.resize(500, 500)
    view.show()
    return view


def show(view: CorrectionView, result: RunResult) -> None:
    curves = take_curves(result, result.recording.n_samples)
    assert curves is not None
    view.show_curves(result, curves)


def test_the_published_one_shows_extremes_splines_bias_and_the_pieces_of_the_scale(
    view: CorrectionView, by: Any
) -> None:
    result = by("published")
    show(view, result)
    steps = result.corrected.steps[0]
    assert view.raw[1].found["valleys"].getData()[0].size == steps.q.valleys.size > 10
    assert view.rest.isVisible()
    assert view.rest.getPlotItem().getAxis("left").labelText == "scale [V]"
    _, y = view.rest_lines[0].getOriginalDataset()
    known = np.isfinite(y)
    assert set(np.round(y[known], 12)) <= set(np.round(steps.i.scale[np.isfinite(steps.i.scale)], 12))
    assert not view.plane.isVisible()
    assert not view.decided.isVisible()


def test_the_ellipse_is_drawn_around_the_samples_and_its_numbers_are_named(view: CorrectionView, by: Any) -> None:
    result = by("ellipse")
    show(view, result)
    view.receiver.setCurrentIndex(1)
    found = result.corrected.steps[1]
    assert isinstance(found, Ellipse)
    i, q = view.outline.getOriginalDataset()
    on_circle = found.apply(np.stack([i, q]))
    assert np.hypot(*on_circle) == pytest.approx(1.0)
    samples = np.stack(view.dots.getOriginalDataset())
    assert np.hypot(*found.apply(samples)).mean() == pytest.approx(1.0, abs=0.2)
    assert f"gain Q/I {found.gain_ratio:.4f}" in view.decided.toPlainText()
    assert not view.rest.isVisible()


@pytest.mark.parametrize("method", ["joint", "flights"])
def test_a_model_of_all_channels_shows_itself_what_it_leaves_and_what_was_decided(
    view: CorrectionView, by: Any, method: str
) -> None:
    result = by("joint")
    corrected = replace(result.corrected, method=method)
    phase = result.paths.phase_rad
    # its I and Q are its unit circle and what the samples add to the model: here a wave, 20 % of an amplitude
    rest = 0.2 * np.sin(0.7 * np.arange(phase.shape[1]))
    i, q = np.cos(phase) + rest, np.sin(phase) - rest
    result = replace(result, corrected=replace(corrected, i=i, q=q))
    show(view, result)
    assert view._words.text() == f"correction: {method}"
    assert view.decided.toPlainText() == " ".join(result.corrected.decisions)
    assert "floor that reflects" in view.decided.toPlainText()
    view.show()
    for lines, scrolled in ((3, 0), (4, 1)):
        view.decided.setPlainText("\n".join(["what was decided"] * lines))
        QApplication.processEvents()
        # whole lines: of the next one nothing is seen, and what fits is not scrolled
        assert view.decided.verticalScrollBar().maximum() == scrolled
        assert view.decided.height() < 3.3 * view.fontMetrics().lineSpacing()
    raw, model = (np.stack(item.getOriginalDataset()) for item in (view.raw[0].raw, view.raw[0].found["fitted"]))
    rest_mv = view.rest_lines[0].getOriginalDataset()[1]
    assert raw.shape == model.shape
    known = np.isfinite(model[1])
    assert 1e-3 * rest_mv[known] == pytest.approx((raw - model)[1][known], abs=1e-9)
    assert np.nanmax(np.abs(rest_mv)) > 50.0, "the wave is there"
    assert "the model that was fitted" in view.key.text().replace("&nbsp;", " ")
    assert view.raw[0].found["peaks"].getData()[0] is None


def test_the_adaptive_one_shows_its_circle_and_none_only_the_samples(view: CorrectionView, by: Any) -> None:
    show(view, by("adaptive"))
    assert "circle at the phase found" in view.key.text().replace("&nbsp;", " ")
    assert view.raw[0].found["fitted"].getOriginalDataset()[0].size > 100
    show(view, by("none"))
    assert view.raw[0].found["fitted"].getOriginalDataset()[0] is None
    assert not view.rest.isVisible()
    assert "none" in view._words.text()


def test_methods_differ_by_what_their_tracks_differ_by(by: Any) -> None:
    first, other = by("ellipse"), by("published")
    one = overlaid(other, first, "published", 4000)
    difference = other.track.position_m[2] - first.track.position_m[2]
    valid = other.track.valid & first.track.valid
    assert one.largest_m == pytest.approx(np.abs(difference[valid]).max())
    assert set(one.curves) == {"z", "L1", "L2", "L3"}
    own = overlaid(first, first, "ellipse", 4000)
    assert own.differences == {}
    assert own.summary["e"] == first.bounces.impacts[0].e


def test_methods_are_computed_in_the_background_and_laid_over_the_result(
    window: MainWindow, wait_for: Any, tmp_path: Any
) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4))
    wait_for(lambda: not window.jobs.running)
    window.runs.table.selectRow(0)
    wait_for(lambda: window.run.result is not None and not window.jobs.running)
    window.panels.go_to("run")
    view = window.run.tabs.page("methods")
    window.run.tabs.setCurrentWidget(view)
    assert tuple(view.boxes)[: len(CORRECTIONS)] == CORRECTIONS
    assert view.boxes["published"].isChecked()
    assert not view.boxes["published"].isEnabled(), "it is the one that is shown"
    assert not view.compute.isEnabled()
    assert view.quantity.isHidden(), "there is nothing to choose from"
    window.empty.refresh()
    assert window.empty.labels["run"].text() == "Tick what is to be laid over “published”."
    view.boxes["ellipse"].click()
    view.boxes["none"].click()
    view.compute.click()
    assert not view.compute.isEnabled()
    assert window.work.busy
    wait_for(lambda: not window.work.busy)
    assert [one.method for one in view.table.rows.entries] == ["published", "ellipse", "none"]
    assert view.table.rows.entries[0].summary["e"] == window.run.result.bounces.impacts[0].e
    assert len(view.curves.getPlotItem().listDataItems()) == 3
    assert len(view.differences.getPlotItem().listDataItems()) == 2
    assert view.quantity.isVisible()
    view.quantity.setCurrentIndex(view.quantity.findData("L2"))
    assert view.differences.getPlotItem().getAxis("left").labelText == "ΔL2 [mm]"
    window.run.show_result(window.run.result, "again")
    assert view.table.rows.entries == [], "another result begins anew"


def test_a_method_that_cannot_be_computed_does_not_stop_the_others(by: Any) -> None:
    def computed(_run: Path, setup: Any, _progress: Any) -> RunResult:
        if setup.processing.correction == "ellipse":
            raise ProcessingError("the samples lie on no ellipse")
        return by("none")

    shares: list[float] = []
    failed, good = compute_methods(
        Path("run-0001.h5"), by("published"), ("ellipse", "none"), 100, shares.append, computed
    )
    assert (failed.problem, failed.curves) == ("the samples lie on no ellipse", {})
    assert "z" in good.differences
    assert shares == [0.0, 0.5]


def test_a_method_that_fails_says_why(qtbot: QtBot, theme: Theme, by: Any) -> None:
    from radargui.gui.runs.correction_view import MethodsView

    view = MethodsView(theme, lambda _methods: None)
    qtbot.addWidget(view)
    view.show_result(by("joint"))
    view.add(overlaid(by("joint"), by("joint"), "joint", 100))
    view.add(OverlaidMethod("ellipse", {}, {}, {}, problem="the samples lie on no ellipse"))
    model = view.table.model()
    assert model.index(1, model.columnCount() - 1).data() == "the samples lie on no ellipse"
    assert [model.index(1, column).data() for column in range(3)] == ["ellipse", "–", "–"]


def test_what_was_decided_is_wrapped_at_any_width(theme: Theme, qtbot: QtBot) -> None:
    view = CorrectionView(theme)
    qtbot.addWidget(view)
    view.show()
    view.decided.show()
    view.decided.setPlainText(
        "A floor that reflects is kept: log evidence beyond +60. The offsets drift on the rest. " * 3
    )
    for width in range(500, 600):
        view.resize(width, 600)
        QApplication.processEvents()
        assert not view.decided.horizontalScrollBar().isVisible(), width
