"""Pages draw whatever a run holds, and nothing leaves the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from support.changed import changed
from support.results import default_setup, drop_result, quiet_result, rejected_result

from radargui.model.arrays import FloatArray
from radargui.model.finding import as_stored
from radargui.model.recording import Gap
from radargui.model.result import Bounces, RunResult
from radargui.report.canvas import Canvas, Line, Panel
from radargui.report.curves import take_curves
from radargui.report.decimation import COMPACT, Curve
from radargui.report.document import Chapter, Drawing, Facts, Grid, Note
from radargui.report.facts import ReportFacts, SessionFacts, report_facts
from radargui.report.flow import text_pages
from radargui.report.rendering import body, drawn_alone
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_page, run_section
from radargui.report.series_figures import draw_falls, draw_speeds
from radargui.report.sheet import Area, Paper, new_figure, page_style, scaled, size_mm
from radargui.session.info import SessionInfo


@pytest.fixture(autouse=True)
def style() -> Iterator[None]:
    with page_style():
        yield


def pages(result: RunResult) -> dict[str, Figure]:
    section = run_section(take_facts(result, "run-0001"), result.setup)
    return {picture.title: picture.draw("a4") for picture in section.pictures}


def everything_is_on_the_page(page: Figure) -> bool:
    width_mm, height_mm = size_mm(page)
    for canvas in (one for one in page.get_children() if isinstance(one, Canvas)):
        for left, right, base, _ in canvas.words:
            if not (left >= 0.0 and right <= width_mm and 2.0 <= base <= height_mm - 1.0):
                return False
    if not page.axes:
        return True
    renderer = FigureCanvasAgg(page).get_renderer()
    page.draw(renderer)
    boxes = [axes.get_tightbbox(renderer) for axes in page.axes]
    low = all(min(box.x0, box.y0) >= 0.0 for box in boxes)
    return low and all(box.x1 <= page.bbox.width and box.y1 <= page.bbox.height for box in boxes)


def overlapping(page: Figure) -> list[tuple[str, str]]:
    """Return words on one line that lie on each other."""
    words = [word for one in page.get_children() if isinstance(one, Canvas) for word in one.words if word[3].strip()]
    return [
        (one[3], other[3])
        for number, one in enumerate(words)
        for other in words[:number]
        if abs(one[2] - other[2]) < 1.5 and min(one[1], other[1]) - max(one[0], other[0]) > 0.1
    ]


def test_a_whole_drop_has_four_pages_and_nothing_leaves_them() -> None:
    drawn = pages(drop_result(rate_hz=5000.0))
    assert list(drawn) == [
        "raw and corrected IQ",
        "steps of the published correction",
        "phase and path length",
        "track",
    ]
    for page in drawn.values():
        assert everything_is_on_the_page(page)
        assert overlapping(page) == []
        assert 0 <= body(page).y0 < body(page).y1 < 11.69


@pytest.mark.parametrize("n_receivers", [1, 2])
def test_fewer_receivers_have_no_track_page(n_receivers: int) -> None:
    drawn = pages(drop_result(rate_hz=5000.0, n_receivers=n_receivers))
    assert "track" not in drawn
    assert len(drawn) == 3


@pytest.mark.parametrize("make", [quiet_result, rejected_result])
def test_a_run_without_result_shows_its_raw_signals_only(make: object) -> None:
    drawn = pages(make())
    assert list(drawn) == ["raw IQ"]
    assert everything_is_on_the_page(drawn["raw IQ"])


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
    canvases = [one for one in drawn["phase and path length"].get_children() if isinstance(one, Canvas)]
    assert sum("path lost" in text for one in canvases for *_, text in one.words) == 3
    assert everything_is_on_the_page(drawn["phase and path length"])


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


def test_axis_prefixes_follow_the_size_of_the_values() -> None:
    assert scaled("m", 0.26) == (1e3, "mm")
    assert scaled("m", 3e-5) == (1e6, "µm")
    assert scaled("V", 0.3) == (1e3, "mV")
    assert scaled("V", 2.0) == (1.0, "V")
    assert scaled("V", 0.0) == (1.0, "V")


def test_long_tables_and_notes_flow_over_pages_and_stay_inside() -> None:
    rows = tuple((f"run-{k:04d}", "0.8000 ± 0.0012", "a reason that is long " * 6) for k in range(120))
    section = Chapter(
        "Long",
        (
            Facts((("Notes", "word " * 2000), ("name $x_1$", "$\\frac{broken"))),
            Grid(("run", "e", "reason"), rows, "Runs", left=(0, 2)),
            Note("w" * 3000, warning=True),
        ),
    )
    made = list(text_pages(section))
    assert len(made) > 4
    for page in made:
        assert everything_is_on_the_page(page)


@pytest.mark.parametrize("paper", ["a4", "letter"])
@pytest.mark.parametrize("n_receivers", [1, 3])
def test_a_run_is_one_page_on_any_paper_and_nothing_leaves_it(paper: Paper, n_receivers: int) -> None:
    result = drop_result(rate_hz=5000.0, n_receivers=n_receivers)
    long = replace(result, findings=(as_stored("a warning that does not end " * 40),) * 5)
    (page,) = text_pages(run_page(take_facts(long, "run-0001", COMPACT)), paper)
    assert everything_is_on_the_page(page)
    assert overlapping(page) == []


@pytest.mark.parametrize("make", [quiet_result, rejected_result])
def test_a_run_without_result_is_one_page_too(make: Callable[[], RunResult]) -> None:
    (page,) = text_pages(run_page(take_facts(make(), "run-0001", COMPACT)))
    assert everything_is_on_the_page(page)


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


def test_the_page_of_a_track_fits_letter_paper() -> None:
    result = drop_result(rate_hz=5000.0)
    *_, track = run_section(take_facts(result, "run-0001"), result.setup).pictures
    assert track.title == "track"
    assert everything_is_on_the_page(track.draw("letter"))
    assert overlapping(track.draw("letter")) == []


def compared(n: int) -> ReportFacts:
    """Return so many sessions of one drop each, with names as sessions have them."""
    sessions = []
    for number in range(n):
        drop = drop_result(rate_hz=2000.0, e=0.78 + 0.004 * number, seed=number)
        info = SessionInfo(name=f"2026-11-20T15-04-{number:02d}", created_at="", setup=default_setup())
        sessions.append(SessionFacts(info, (take_facts(drop, "run-0001", COMPACT),)))
    return report_facts(sessions, "now")


@pytest.mark.parametrize("n", [2, 5, 12, 20])
def test_sessions_beside_each_other_look_different_and_their_names_lie_on_nothing(
    n: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    facts, named, dotted = compared(n), dict[str, object](), set[object]()
    write, draw = Panel.key, Panel.dots

    def key(panel: Panel, name: str, line: Line, mark: int | None = None) -> None:
        named[name] = (line.colour, mark)
        write(panel, name, line, mark)

    def dots(panel: Panel, x: FloatArray, y: FloatArray, colour: str, size: float = 0.35, mark: int = 0) -> None:
        dotted.add((colour, mark))
        draw(panel, x, y, colour, size, mark)

    monkeypatch.setattr(Panel, "key", key)
    monkeypatch.setattr(Panel, "dots", dots)
    drawn = drawn_alone(Drawing("", partial(draw_speeds, facts=facts), 62.0))
    looks = [named[one.name] for one in facts.findings.sessions]
    assert len(set(looks)) == n
    assert dotted == set(looks)
    assert overlapping(drawn) == []
    assert everything_is_on_the_page(drawn)
    for one, other in pairwise(looks):
        assert one[0] != other[0]
        assert one[1] != other[1]


def test_sessions_too_many_to_look_different_are_counted() -> None:
    drawn = drawn_alone(Drawing("", partial(draw_speeds, facts=compared(21)), 62.0))
    (canvas,) = (one for one in drawn.get_children() if isinstance(one, Canvas))
    assert any("; 21 sessions" in text for *_, text in canvas.words)
    assert overlapping(drawn) == []


def test_the_falls_of_a_session_have_its_colour_and_those_of_a_single_one_their_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    colours: list[str] = []
    draw = Panel.curve

    def curve(panel: Panel, of: Curve, line: Line, factor: float = 1.0, name: str = "") -> bool:
        colours.append(line.colour)
        return draw(panel, of, line, factor, name)

    monkeypatch.setattr(Panel, "curve", curve)
    runs = compared(1).sessions[0].runs * 3
    drawn_alone(Drawing("", partial(draw_falls, sessions=[runs]), 70.0))
    assert len(set(colours[1:4])) == 3
    colours.clear()
    drawn_alone(Drawing("", partial(draw_falls, sessions=[runs[:1], runs[:2]]), 70.0))
    first, second, third = colours[1:4]
    assert first != second == third
    assert colours[4:] == [first, second, third]


@pytest.mark.parametrize(
    ("span", "numbers"),
    [
        ((0.79, 0.8105), ["0.790", "0.795", "0.800", "0.805", "0.810"]),
        ((-0.2, 1.0), ["0.0", "0.5", "1.0"]),
        ((-210.0, 210.0), ["−200", "−100", "0", "100", "200"]),
        ((0.0, 2e-9), ["0", "5e−10", "1e−09", "1.5e−09", "2e−09"]),
    ],
)
def test_all_numbers_of_an_axis_have_the_same_decimals(span: tuple[float, float], numbers: list[str]) -> None:
    figure = new_figure(60.0, 50.0)
    Panel(Canvas(figure), Area(10.0, 5.0, 48.0, 30.0), (0.0, 10.0), span).frame("y")
    (canvas,) = (one for one in figure.get_children() if isinstance(one, Canvas))
    assert [text for _, right, _, text in canvas.words if right < 10.0] == numbers


def test_where_numbers_of_an_axis_have_no_room_some_are_left_out_and_zero_stays() -> None:
    figure = new_figure(60.0, 50.0)
    Panel(Canvas(figure), Area(10.0, 5.0, 18.0, 20.0), (-4100.0, 4100.0), (0.0, 1.0)).frame("y")
    (canvas,) = (one for one in figure.get_children() if isinstance(one, Canvas))
    assert [text for _, _, base, text in canvas.words if base > 27.0] == ["−4000", "0", "4000"]
    assert overlapping(figure) == []
