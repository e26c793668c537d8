"""Pages draw whatever a run holds, and nothing leaves the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.text import Text
from support.changed import changed
from support.figure_text import faults_of
from support.pdf_text import pdf_pages
from support.results import default_setup, drop_result, quiet_result, rejected_result

from radargui.model.finding import as_stored
from radargui.model.recording import Gap
from radargui.model.result import Bounces, RunResult
from radargui.report.content import Chapter, Facts, Grid, Note
from radargui.report.curves import COMPACT, take_curves
from radargui.report.facts import ReportFacts, SessionFacts, report_facts
from radargui.report.plots import page_style
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_page, run_section
from radargui.report.series_figures import speeds_figure
from radargui.report.typesetting import Paper, Typesetter
from radargui.session.info import SessionInfo


@pytest.fixture(autouse=True)
def style() -> Iterator[None]:
    with page_style():
        yield


def pages(result: RunResult) -> dict[str, Figure]:
    section = run_section(take_facts(result, "run-0001"), result.setup)
    return {picture.title: picture.draw() for picture in section.pictures}


def texts_of(figure: Figure) -> list[str]:
    return [one.get_text() for one in figure.findobj(Text)]


def test_a_whole_drop_has_four_pages_and_nothing_leaves_them() -> None:
    drawn = pages(drop_result(rate_hz=5000.0))
    assert list(drawn) == [
        "raw and corrected IQ",
        "steps of the published correction",
        "phase and path length",
        "track",
    ]
    for page in drawn.values():
        assert faults_of(page) == []


@pytest.mark.parametrize("n_receivers", [1, 2])
def test_fewer_receivers_have_no_track_page(n_receivers: int) -> None:
    drawn = pages(drop_result(rate_hz=5000.0, n_receivers=n_receivers))
    assert "track" not in drawn
    assert len(drawn) == 3


@pytest.mark.parametrize("make", [quiet_result, rejected_result])
def test_a_run_without_result_shows_its_raw_signals_only(make: object) -> None:
    drawn = pages(make())
    assert list(drawn) == ["raw IQ"]
    assert faults_of(drawn["raw IQ"]) == []


def test_lost_samples_are_shaded_and_break_the_curves() -> None:
    result = drop_result(rate_hz=5000.0, gap=Gap(3000, 200))
    curves = take_curves(result)
    assert curves is not None
    (gap_s,) = curves.gaps_s
    assert np.asarray(gap_s) + result.zero[0] == pytest.approx([0.6, 0.64])
    assert np.isnan(curves.receivers[0].raw.i.y).any()
    inside = (curves.receivers[0].raw.i.x > gap_s[0]) & (curves.receivers[0].raw.i.x < gap_s[1])
    assert not inside.any()
    drawn = pages(result)
    assert len(drawn) == 4


def test_no_curve_joins_two_pieces_of_a_path_and_the_recorded_signals_go_on() -> None:
    result = drop_result(rate_hz=5000.0)
    assert result.paths is not None
    piece = (np.arange(result.recording.n_samples) >= 4001).astype(np.intp)
    result = replace(result, paths=replace(result.paths, piece=piece))
    curves = take_curves(result)
    assert curves is not None
    assert curves.track is not None
    at_s = 4001 / 5000.0 - result.zero[0]
    assert curves.restarts_s == (at_s,)
    one = curves.receivers[0]
    pieces = (one.phase, one.phase_difference, one.change, one.whole_change, one.u_change, *curves.track.u)
    for curve in (*pieces, curves.track.x, curves.track.y, curves.track.height):
        assert curve.x[np.isnan(curve.y)].tolist() == [at_s]
    for curve in (one.raw.i, one.corrected.i, one.phase_raw):
        assert np.isfinite(curve.y).all()
    assert np.isnan(curves.track.places_m).all(axis=0).sum() == 1
    drawn = pages(result)
    assert sum("path lost" in text for text in texts_of(drawn["phase and path length"])) == 3
    assert faults_of(drawn["phase and path length"]) == []


def test_the_raw_phase_of_an_inverted_q_goes_the_same_way_and_its_voltages_are_drawn_as_recorded() -> None:
    result = drop_result(rate_hz=5000.0)
    raw = result.recording.raw.copy()
    raw[1::2] *= -1
    setup = changed(result.setup, radar={"phase_sign": -1})
    straight = take_curves(result)
    inverted = take_curves(replace(result, recording=replace(result.recording, raw=raw), setup=setup))
    assert straight is not None
    assert inverted is not None
    for one, other in zip(straight.receivers, inverted.receivers, strict=True):
        assert other.phase_raw.y == pytest.approx(one.phase_raw.y, abs=1e-9)
        assert other.raw.plane.y == pytest.approx(-one.raw.plane.y)


def test_a_track_without_impacts_or_fall_is_drawn() -> None:
    assert "track" in pages(replace(drop_result(rate_hz=5000.0), bounces=Bounces()))


def test_nothing_known_anywhere_still_draws() -> None:
    result = drop_result(rate_hz=2000.0)
    assert result.track is not None
    assert result.paths is not None
    unknown = np.full_like(result.track.position_m, np.nan)
    change = np.full_like(result.paths.change_m, np.nan)
    result = replace(
        result,
        track=replace(result.track, position_m=unknown, u_position_m=unknown),
        paths=replace(result.paths, change_m=change, phase_rad=change, u_m=change),
    )
    assert "track" not in pages(result)


def test_the_residual_is_height_less_the_fitted_parabola() -> None:
    curves = take_curves(drop_result(rate_hz=5000.0))
    assert curves is not None
    assert curves.track is not None
    assert curves.track.residual is not None
    assert curves.track.residual.largest < 1e-12
    assert curves.track.parabola is not None
    assert curves.track.parabola.y[-1] == pytest.approx(-0.14, abs=1e-6)


@pytest.mark.parametrize("rate_hz", [20_000.0, 100_000.0])
def test_however_many_samples_there_are_a_curve_has_a_thousand_points_and_the_plane_2500(rate_hz: float) -> None:
    curves = take_curves(drop_result(rate_hz=rate_hz, seconds=1.6))
    assert curves is not None
    assert 900 < len(curves.receivers[0].raw.i.x) < 1100
    assert 2000 < len(curves.receivers[0].corrected.plane.x) <= 2500


def test_figures_are_white_for_print() -> None:
    drawn = pages(drop_result())
    assert drawn
    for title, page in drawn.items():
        assert page.get_facecolor() == (1.0, 1.0, 1.0, 1.0), title
        assert all(axes.get_facecolor() == (1.0, 1.0, 1.0, 1.0) for axes in page.axes), title


def set_on(paper: Paper, folder: Path, *chapters: Chapter) -> list[str]:
    """Return the words of the pages that chapters fill."""
    folder.mkdir(exist_ok=True)
    pages = Typesetter(folder)
    for one in chapters:
        pages.put(one)
    pages.write(folder / "pages.pdf", paper, "title", "", "2026-11-20T15:04:05+00:00")
    return pdf_pages(folder / "pages.pdf")


def test_long_tables_flow_over_pages_with_their_heads_and_a_long_word_is_broken(tmp_path: Path) -> None:
    rows = tuple((f"run-{k:04d}", "0.8000 ± 0.0012", "a reason that is long " * 6) for k in range(120))
    section = Chapter(
        "Long",
        (
            Facts((("Notes", "word " * 2000), ("name $x_1$", "$\\frac{broken"))),
            Grid(("run", "e", "reason"), rows, "Runs", left=(0, 2)),
            Note("w" * 3000, warning=True),
        ),
    )
    made = set_on("a4", tmp_path, section)
    assert len(made) > 3
    assert "$\\frac{broken" in "".join(made)
    of_table = [words for words in made if "run-00" in words or "run-01" in words]
    assert len(of_table) > 1
    assert all("reason" in words for words in of_table)
    assert sum(words.count("0.8000 ± 0.0012") for words in made) == len(rows), "no number is broken"
    assert sum(words.count("w" * 20) for words in made) > 20, "many lines of it"


@pytest.mark.parametrize("paper", ["a4", "letter"])
@pytest.mark.parametrize("n_receivers", [1, 3])
def test_a_run_is_one_page_on_any_paper_whatever_it_warns_of(tmp_path: Path, paper: Paper, n_receivers: int) -> None:
    result = drop_result(rate_hz=5000.0, n_receivers=n_receivers)
    long = replace(result, findings=(as_stored("a warning that does not end " * 40),) * 5)
    (words,) = set_on(paper, tmp_path, run_page(take_facts(long, "run-0001", COMPACT)))
    assert "Phase / rad" in words


@pytest.mark.parametrize("make", [quiet_result, rejected_result])
def test_a_run_without_result_is_one_page_too(tmp_path: Path, make: Callable[[], RunResult]) -> None:
    (words,) = set_on("a4", tmp_path, run_page(take_facts(make(), "run-0001", COMPACT)))
    assert "raw IQ" in words


def test_the_adaptive_estimate_shows_the_circle_that_it_found_and_what_that_leaves() -> None:
    result = drop_result(rate_hz=5000.0)
    assert result.corrected is not None
    curves = take_curves(replace(result, corrected=replace(result.corrected, method="adaptive", steps=())), COMPACT)
    assert curves is not None
    for receiver in curves.receivers:
        for one in receiver.circles:
            assert one.kind == "circle"
            # amplitude 1 to 1.03 over the drop, quadrature error 0.1, noise 0.005
            assert 0.9 < one.fitted.largest < 1.2
            assert one.rest.largest < 0.1


def test_the_joint_estimate_shows_its_model_and_what_the_samples_add_to_it() -> None:
    result = drop_result(rate_hz=5000.0)
    assert result.corrected is not None
    assert result.paths is not None
    phase = result.paths.phase_rad
    # everything that the samples add is 0.02 amplitudes along I
    made = replace(result.corrected, method="joint", steps=(), i=np.cos(phase) + 0.02, q=np.sin(phase))
    curves = take_curves(replace(result, corrected=made), COMPACT)
    assert curves is not None
    for receiver in curves.receivers:
        in_i, in_q = receiver.circles
        assert in_i.kind == in_q.kind == "model"
        assert in_i.rest.largest == pytest.approx(0.02, rel=0.1)
        assert in_q.rest.largest < 0.2 * in_i.rest.largest, "only through the quadrature error"
        assert in_i.fitted.largest == pytest.approx(in_i.signal.largest, abs=0.03)


def test_what_the_model_leaves_is_in_volts_wherever_the_sphere_is() -> None:
    result = drop_result(rate_hz=5000.0)
    assert result.corrected is not None
    assert result.paths is not None
    assert result.segment is not None
    first, last = result.segment.first, result.segment.last
    phase, generator = result.paths.phase_rad, np.random.default_rng(7)
    amplitude_v = np.interp(np.arange(phase.shape[1]), [first, last], [1.0, 0.25])
    left_v = 0.01 * generator.standard_normal((2, *phase.shape))
    i_v, q_v = amplitude_v * np.cos(phase) + left_v[0] + 0.3, amplitude_v * np.sin(phase) + left_v[1] - 0.2
    raw = np.stack([i_v, q_v], axis=1).reshape(-1, phase.shape[1])
    i, q = np.cos(phase) + left_v[0] / amplitude_v, np.sin(phase) + left_v[1] / amplitude_v
    assert result.recording is not None
    digitised = replace(result.recording, raw=raw)
    made = replace(result.corrected, method="joint", steps=(), i=i, q=q)
    curves = take_curves(replace(result, recording=digitised, corrected=made), COMPACT)
    assert curves is not None
    for receiver in curves.receivers:
        for one in receiver.circles:
            late = one.rest.x > np.quantile(one.rest.x, 0.8)
            # extremes of some tens of samples: two to three deviations
            assert 0.015 < np.abs(one.rest.y[late]).mean() < 0.03
            assert np.abs(one.rest.y[late]).mean() == pytest.approx(np.abs(one.rest.y[~late]).mean(), rel=0.2)


def compared(n: int) -> ReportFacts:
    """Return so many sessions of one drop each, with names as sessions have them."""
    sessions = []
    for number in range(n):
        drop = drop_result(rate_hz=2000.0, e=0.78 + 0.004 * number, seed=number)
        info = SessionInfo(name=f"2026-11-20T15-04-{number:02d}", created_at="", setup=default_setup())
        sessions.append(SessionFacts(info, (take_facts(drop, "run-0001", COMPACT),)))
    return report_facts(sessions, "now")


@pytest.mark.parametrize("n", [2, 20])
def test_sessions_beside_each_other_look_different_and_their_names_lie_on_nothing(n: int) -> None:
    facts = compared(n)
    drawn = speeds_figure(facts, (180.0, 80.0))
    (legend,) = drawn.legends
    labels = [text.get_text() for text in legend.get_texts()]
    names = [one.name for one in facts.findings.sessions]
    assert [name for name in labels if name in names] == names
    (axes,) = drawn.axes
    bars = [one for one in axes.containers if isinstance(one, ErrorbarContainer)]
    looks = [(one.lines[0].get_color(), one.lines[0].get_marker()) for one in bars]
    assert len(set(looks)) == n
    for one, other in pairwise(looks):
        assert one[0] != other[0]
        assert one[1] != other[1]
    assert faults_of(drawn) == []


def test_sessions_too_many_to_look_different_are_counted() -> None:
    drawn = speeds_figure(compared(21), (88.0, 88.0))
    assert any("; 21 sessions" in " ".join(text.split()) for text in texts_of(drawn))
    assert faults_of(drawn) == []
