"""What the plots draw: ranges that stay, gaps, words that have room."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
import pyqtgraph as pg
import pytest
from pyqtgraph.opengl import GLLinePlotItem, GLTextItem
from PySide6.QtCore import QPointF, QRectF, QSize
from PySide6.QtGui import QFont, QFontMetrics, QFontMetricsF, QPainter, QPicture, QResizeEvent, QVector3D
from PySide6.QtWidgets import QApplication
from support.small_setups import quick_setup

from radargui.gui.layout import having
from radargui.gui.plots.items import Band
from radargui.gui.plots.plot import Plot, SteadyRange, round_up
from radargui.gui.scopes.iq_plane_panel import IQPlane
from radargui.gui.theme import Theme, even_font, inside_pt
from radargui.gui.track.shown_track import space_of
from radargui.gui.track.space_view import SpaceView, spaced
from radargui.gui.track.speed_colours import SpeedColours, segments
from radargui.gui.track.track_panel import Projections


def test_a_range_grows_at_once_and_shrinks_only_later() -> None:
    steady = SteadyRange(patience=5)
    assert steady.fit(-1.0, 1.0)
    assert not steady.fit(-0.9, 0.9)
    assert steady.fit(-3.0, 3.0)
    assert steady.span[1] >= 3.0
    assert [steady.fit(-0.1, 0.1) for _ in range(5)] == [False] * 4 + [True]
    assert steady.span[1] < 0.3
    assert not steady.fit(float("nan"), 1.0)


@pytest.mark.parametrize(("value", "rounded"), [(0.9, 1.0), (1.0, 1.0), (1.2, 1.5), (4.0, 5.0), (0.031, 0.05), (0, 1)])
def test_ranges_are_round(value: float, rounded: float) -> None:
    assert round_up(value) == pytest.approx(rounded)


def test_the_line_in_space_does_not_run_across_what_is_unknown() -> None:
    points = np.cumsum(np.ones((40, 3), dtype=np.float32), axis=0)
    points[20] = np.nan
    kept = points[spaced(points)]
    assert len(kept) < 40
    pairs = kept[segments(kept)].reshape(-1, 2, 3)
    assert np.isfinite(pairs).all()
    assert not any(pair[0, 0] < 20.0 < pair[1, 0] for pair in pairs)


def test_a_low_view_in_space_names_its_axes_and_leaves_out_what_would_overlap(theme: Theme) -> None:
    view = SpaceView(theme, SpeedColours(theme), space_of(quick_setup()))
    view.show_space(space_of(quick_setup()))
    shown = {}
    for height in (300, 120, 300):
        before = view.size()
        view.resize(473, height)
        # it is not shown, for which there must be OpenGL: Qt would tell it later
        QApplication.sendEvent(view, QResizeEvent(QSize(473, height), before))
        shown[height] = {item.text for item in view.items if isinstance(item, GLTextItem)}
    assert shown[120] == {"x [mm]", "y [mm]", "z [mm]"}
    assert shown[300] >= {*shown[120], "0", "100", "Tx", "Rx 1"}
    # a panel that holds the projections holds it too, and is not scrolled
    assert view.minimumHeight() <= Projections(theme, SpeedColours(theme)).minimumSizeHint().height()


@pytest.mark.parametrize("size", [(480, 90), (490, 110), (490, 230), (590, 320), (720, 420)])
@pytest.mark.parametrize("receivers", [3, 4])
def test_the_words_in_space_are_crossed_by_nothing(theme: Theme, size: tuple[int, int], receivers: int) -> None:
    setup = quick_setup()
    setup = setup.model_copy(update={"receiver": (*setup.receiver, setup.receiver[0])[:receivers]})
    view = SpaceView(theme, SpeedColours(theme), space_of(setup))
    view.show_space(space_of(setup))
    before = view.size()
    view.resize(*size)
    QApplication.sendEvent(view, QResizeEvent(QSize(*size), before))
    view.setProjection(view.getViewport(), view.getViewport())
    view.setModelview()
    boxes = [(one.text, box_of(one)) for one in view.items if isinstance(one, GLTextItem)]
    assert len(boxes) >= 3
    for (text, box), (other, beside) in itertools.combinations(boxes, 2):
        # two antennas may stand behind one another
        assert "Rx" in text or not box.intersects(beside), (text, other)
    (grid, frame) = (one for one in view._fixed if isinstance(one, GLLinePlotItem))
    project = boxes and view._fixed[-1].compute_projection()
    space = space_of(setup)
    # and by no sphere that falls in the middle
    fall = [(0.0, 0.0, space.floor_mm), (0.0, 0.0, float(space.high_mm[2]) - 20.0)]
    for points in (grid.pos.tolist(), frame.pos.tolist(), fall):
        ends = [project.map(QVector3D(*point)).toPointF() for point in points]
        for start, end in zip(ends[::2], ends[1::2], strict=True):
            for text, box in boxes:
                assert not crosses(box, start, end), text


def box_of(item: GLTextItem) -> QRectF:
    """Return the box of a text on the screen."""
    place = item.align_text(item.compute_projection().map(QVector3D(*item.pos)).toPointF())
    box = QRectF(QFontMetrics(item.font).tightBoundingRect(item.text))
    return box.translated(place)


def crosses(box: QRectF, start: QPointF, end: QPointF) -> bool:
    """Return whether a piece of a line lies within a box."""
    share = np.linspace(0.0, 1.0, 200)[:, None]
    x, y = ((1.0 - share) * start.toTuple() + share * end.toTuple()).T
    return bool(((x > box.left()) & (x < box.right()) & (y > box.top()) & (y < box.bottom())).any())


@pytest.mark.parametrize("size", [(104, 145), (111, 132), (111, 158)])
def test_a_small_plane_comes_to_rest(theme: Theme, size: tuple[int, int]) -> None:
    plane, turn = IQPlane(theme, 1, corrected=False), np.linspace(0.0, 6.0, 200)
    plane.resize(*size)
    plane.show()
    plane.draw(0.9 * np.cos(turn), 0.9 * np.sin(turn))
    for _ in range(4):
        QApplication.processEvents()
    resized: list[object] = []
    plane.view.sigResized.connect(resized.append)
    # words that needed more room made equal units show another range, and that other words: for ever
    for _ in range(4):
        QApplication.processEvents()
    plane.close()
    assert not resized


@pytest.mark.parametrize("size", [(101, 92), (101, 145), (300, 120)])
def test_the_circle_of_a_small_plane_lies_beneath_its_words(theme: Theme, size: tuple[int, int]) -> None:
    plane = IQPlane(theme, 2, corrected=True)
    plane.resize(*size)
    plane.show()
    for _ in range(4):
        QApplication.processEvents()
    # amplitudes of a long swing leave the unit circle
    top = plane.view.mapViewToScene(QPointF(0.0, 1.28)).y() - plane.view.sceneBoundingRect().top()
    plane.close()
    assert top >= plane.height_inside > 0


def numbers_of(axis: pg.AxisItem, least: float, most: float, size: float) -> list[tuple[float, str]]:
    """Return the places that get numbers between two values, on so many pixels, and the numbers."""
    levels = axis.tickValues(least, most, size)
    return [
        (value, words)
        for spacing, values in levels[: axis.style["maxTextLevel"] + 1]
        for value, words in zip(values, axis.tickStrings(values, axis.scale, spacing), strict=True)
    ]


@pytest.mark.parametrize("width", [26, 34, 44, 60, 90, 300])
def test_numbers_beneath_a_narrow_plot_stand_apart(theme: Theme, width: int) -> None:
    axis = Plot(theme, "I [V]", "Q [V]").getPlotItem().getAxis("bottom")
    metrics = QFontMetricsF(axis.font())
    for least, most in ((-2.2, 2.2), (0.0, 2.5), (-3.0, 4.0), (0.0, 1.5e-3), (5.0, 6e4)):
        shown = dict(numbers_of(axis, least, most, width))
        places = [(value - least) / (most - least) * width for value in sorted(shown)]
        widths = [metrics.horizontalAdvance(shown[value]) for value in sorted(shown)]
        apart = [0.5 * (one + other) for one, other in itertools.pairwise(widths)]
        assert all(b - a > room for (a, b), room in zip(itertools.pairwise(places), apart, strict=True)), shown


@pytest.mark.parametrize("name", ["left", "bottom"])
@pytest.mark.parametrize("size", [44, 90, 150, 220, 300, 460, 700])
def test_numbers_of_an_axis_have_all_as_many_decimals(theme: Theme, name: str, size: int) -> None:
    axis = Plot(theme, "time [s]", "I [V]").getPlotItem().getAxis(name)
    finest = 0
    for least, most in ((-1.2, 1.2), (-3.0, 0.0), (0.0, 2.3), (0.78, 0.82), (-4e-4, 9e-4), (0.0, 16666.0), (9.7, 12.4)):
        shown = numbers_of(axis, least, most, size)
        decimals = {len(words.partition(".")[2]) for _, words in shown}
        assert len(decimals) == 1, shown
        finest += max(decimals)
        # rounded nowhere, and nothing is -0
        assert all(float(words) == pytest.approx(value, abs=1e-9 * (most - least)) for value, words in shown)
        assert not any(words.startswith("-") and float(words) == 0.0 for _, words in shown)
    assert finest


def test_finer_ticks_get_numbers_where_there_is_room(theme: Theme) -> None:
    axis = Plot(theme, "time [s]", "I [V]").getPlotItem().getAxis("left")
    assert [words for _, words in numbers_of(axis, -1.2, 1.2, 120)] == ["-1.0", "0.0", "1.0", "-0.5", "0.5"]
    assert [words for _, words in numbers_of(axis, -1.2, 1.2, 40)] == ["-1", "0", "1"]


@pytest.mark.parametrize("height", [26, 34, 44, 60, 90, 300])
def test_numbers_beside_a_low_plot_stand_apart(theme: Theme, height: int) -> None:
    plot = Plot(theme, "Time [s]", "Speed [m/s]")
    axis = plot.getPlotItem().getAxis("left")
    digit = QFontMetricsF(axis.font()).capHeight()
    for least, most in ((0.0, 1.0), (0.0, 2.5), (-3.0, 4.0), (0.0, 1.5e-3), (5.0, 6e4)):
        spacing = axis.tickSpacing(least, most, height)[0][0]
        assert spacing * height / (most - least) >= 1.2 * digit
        assert round(spacing / 10.0 ** np.floor(np.log10(spacing * 1.001)), 9) in (1.0, 2.0, 5.0)
        # one number alone would tell no scale
        assert height < 40 or (most - least) / spacing >= 1.0
        # no farther than they must, or than pyqtgraph has them
        usual = pg.AxisItem.tickSpacing(axis, least, most, height)[0][0]
        assert spacing == usual or spacing * height / (most - least) < 3.5 * digit


def test_a_band_lies_between_its_curves_and_is_broken_where_either_is_unknown() -> None:
    x = np.arange(7.0)
    low = np.array([0.0, 1.0, 2.0, np.nan, 4.0, 5.0, 6.0])
    high = low + 2.0
    high[5] = np.nan
    band = Band()
    band.show_band(x, low, high)
    first, *rest = band.path().toSubpathPolygons()
    corners = dict.fromkeys((point.x(), point.y()) for point in first)
    assert list(corners) == [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (2.0, 4.0), (1.0, 3.0), (0.0, 2.0)]
    # a point alone is no area
    assert all(polygon.boundingRect().width() == 0.0 for polygon in rest)
    inside = [band.path().contains(QPointF(*place)) for place in ((1.0, 2.0), (1.0, 0.5), (3.0, 4.0), (4.5, 5.5))]
    assert inside == [True, False, False, False]
    band.show_band(x, np.full(7, np.nan), high)
    assert band.path().isEmpty()


@pytest.mark.parametrize("corrected", [False, True])
def test_the_name_of_a_plane_is_never_cut(theme: Theme, corrected: bool) -> None:
    plane = IQPlane(theme, 3, corrected=corrected)
    for width, words in ((160, "Rx 3 / A" if corrected else "Rx 3 [V]"), (56, "Rx 3")):
        plane.resize(width, 130)
        plane.show()
        QApplication.processEvents()
        assert plane._inside is not None
        assert plane._inside.text == words
        assert plane._inside.item.boundingRect().width() <= plane.view.width()
    plane.close()


def written_beside(plot: Plot) -> tuple[pg.AxisItem, list[tuple[QRectF, int, str]]]:
    """Return the left axis and the numbers that it writes, with their places."""
    axis, picture = plot.getPlotItem().getAxis("left"), QPicture()
    painter = QPainter(picture)
    try:
        return axis, axis.generateDrawSpecs(painter)[2]
    finally:
        painter.end()


def test_an_input_that_is_dead_has_an_axis_with_numbers(theme: Theme) -> None:
    plot = Plot(theme, "time [s]", "Rx 1 [V]", left_px=50, live=True)
    plot.resize(300, 140)
    plot.show()
    QApplication.processEvents()
    plot.fit_y(0.0, 0.0)
    _, texts = written_beside(plot)
    plot.close()
    numbers = [float(words) for _, _, words in texts]
    assert len(numbers) >= 3
    assert 0.0 in numbers


@pytest.mark.parametrize("figures_below", [True, False])
def test_numbers_at_both_ends_of_the_left_axis_are_whole(theme: Theme, figures_below: bool) -> None:
    plot = Plot(theme, "time [s]" if figures_below else "", "z [mm]", figures_below=figures_below)
    plot.resize(300, 140)
    plot.show()
    QApplication.processEvents()
    plot.setYRange(0.0, 1.0, padding=0.0)
    axis, texts = written_beside(plot)
    plot.close()
    assert {words for _, _, words in texts} >= {"0.0", "1.0"}
    capital = QFontMetricsF(axis.font()).capHeight()
    for rect, _, _ in texts:
        middle = axis.mapToScene(rect.center()).y()
        assert 0.5 * capital < middle < plot.height() - 0.5 * capital - 1.0


@pytest.fixture(params=[9.0, 15.0])
def letters(qapp: QApplication, request: pytest.FixtureRequest) -> Iterator[QFont]:
    """Let the system's letters be as large meanwhile."""
    before = qapp.font()
    qapp.setFont(having(QFont(before), pointSizeF=request.param))
    yield qapp.font()
    qapp.setFont(before)


def test_the_words_of_an_axis_lie_beside_its_numbers_in_letters_of_any_size(theme: Theme, letters: QFont) -> None:
    plot = Plot(theme, "time [s]", "z [mm]", left_px=58)
    plot.resize(plot.minimumSize())
    plot.show()
    QApplication.processEvents()
    plot.setYRange(-150.0, 150.0, padding=0.0)
    axis, texts = written_beside(plot)
    words, margin = axis.label.mapRectToParent(axis.label.boundingRect()), axis.label.document().documentMargin()
    plot.close()
    assert {"-100", "0", "100"} <= {number for _, _, number in texts}
    assert words.right() - margin <= min(rect.left() for rect, _, _ in texts)
    assert words.height() <= plot.height()
    assert inside_pt() >= 0.8 * letters.pointSizeF()
    assert even_font(letters).pointSizeF() == letters.pointSizeF()
