"""Every figure alone, as wide as a column."""

from __future__ import annotations

import re
import struct
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.transforms import Bbox
from support.gui_sessions import make_session
from support.pdf_text import pdf_streams, pdf_words
from support.results import default_setup, drop_result, quiet_result, rejected_result

from radargui.model.errors import UsageError
from radargui.processing.result_of_run import result_of_run
from radargui.report.canvas import Canvas, Panel
from radargui.report.facts import SessionFacts
from radargui.report.report import _drawn, _of_run, _of_session, parse_width, write_figures
from radargui.report.run_facts import RunFacts, take_facts
from radargui.report.sheet import Area, page_style, size_mm
from radargui.session.info import SessionInfo
from radargui.session.session import Session


@pytest.mark.parametrize(("text", "width_mm"), [("86mm", 86.0), ("8.6 cm", 86.0), ("3.4in", 86.36)])
def test_a_width_has_a_unit(text: str, width_mm: float) -> None:
    assert parse_width(text) == pytest.approx(width_mm)


@pytest.mark.parametrize("text", ["86", "wide", "5mm", "-86mm", "1e9mm", "86mm; rm", ""])
def test_a_width_that_no_column_has_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="60mm to 250mm"):
        parse_width(text)


def boxes_of(figure: Figure) -> list[tuple[Bbox, str]]:
    """Return where matplotlib writes each text, in mm from the lower left corner, and the text."""
    figure.set_dpi(600)
    to_mm = 25.4 / 600
    renderer = FigureCanvasAgg(figure).get_renderer()
    high_mm, found = size_mm(figure)[1], []

    def note(_gc: object, x: float, y: float, text: str, font: FontProperties, _angle: float) -> None:
        wide, high, below = (to_mm * size for size in renderer.get_text_width_height_descent(text, font, False))
        if text.strip():
            found.append((Bbox.from_bounds(to_mm * x, high_mm - to_mm * y - below, wide, high), text))

    renderer.draw_text = note
    figure.draw(renderer)
    return found


def faults_of(figure: Figure) -> list[tuple[str, ...]]:
    width, height = size_mm(figure)
    boxes = boxes_of(figure)
    outside = [(text,) for box, text in boxes if min(box.x0, box.y0) < 0 or box.x1 > width or box.y1 > height]
    pairs = combinations(boxes, 2)
    return outside + [(one, other) for (a, one), (b, other) in pairs if Bbox.intersection(a, b) is not None]


def run_figures() -> list[tuple[str, RunFacts]]:
    drop = drop_result(rate_hz=5000.0)
    assert drop.corrected is not None
    modelled = replace(drop, corrected=replace(drop.corrected, method="adaptive", steps=()))
    results = {"published": drop, "adaptive": modelled, "quiet": quiet_result(), "rejected": rejected_result()}
    return [(name, take_facts(result, name)) for name, result in results.items()]


@pytest.mark.parametrize("width", ["60mm", "76mm", "86mm"])
def test_in_the_narrowest_figures_no_text_lies_on_another_or_leaves_them(width: str) -> None:
    facts = run_figures()
    drawn = set()
    with page_style():
        session = SessionFacts(
            SessionInfo(name="s", created_at="", setup=default_setup()), tuple(one for _, one in facts)
        )
        figures = [figure for name, run in facts for figure in _of_run(name, run.curves)]
        for name, shape, draw in (*figures, *_of_session(session)):
            assert faults_of(_drawn(shape, draw, parse_width(width))) == [], name
            drawn.add(name)
    assert {"published-fall", "published-phase", "adaptive-receiver-1-correction", "restitution", "falls"} < drawn


def test_an_e_of_many_digits_moves_the_frame_and_stays_on_the_figure() -> None:
    def draw(figure: Figure, area: Area) -> None:
        Panel(Canvas(figure), area, (0.0, 1.0), (0.799991, 0.800012), 7.0).frame("e")

    with page_style():
        assert faults_of(_drawn(0.7, draw, 86.0)) == []


def test_every_figure_is_there_as_pdf_svg_and_png_in_this_width(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("radargui.report.report._DPI", 100)
    session = Session.open(make_session(tmp_path / "data", 4), write=False)
    names = write_figures(session, result_of_run, tmp_path / "out", 86.0)
    of_receivers = [f"run-0001-receiver-{k}-{part}" for k in (1, 2, 3) for part in ("iq", "correction")]
    assert names == [*of_receivers, "run-0001-phase", "run-0001-fall", "restitution", "falls"]
    made = {path.name for path in (tmp_path / "out").iterdir()}
    assert made == {f"{name}.{kind}" for name in names for kind in ("pdf", "svg", "png")}
    for name in names:
        path = tmp_path / "out" / name
        (box,) = re.findall(rb"/MediaBox \[ 0 0 ([\d.]+)", path.with_suffix(".pdf").read_bytes())
        assert float(box) * 25.4 / 72.0 == pytest.approx(86.0, abs=0.05)
        (width,) = struct.unpack(">I", path.with_suffix(".png").read_bytes()[16:20])
        assert width == pytest.approx(86.0 / 25.4 * 100, abs=1.0)
        assert "</svg>" in path.with_suffix(".svg").read_text(encoding="utf-8")
        sizes = re.findall(rb"/F\d+ ([\d.]+) Tf", b"".join(pdf_streams(path.with_suffix(".pdf"))))
        assert min(map(float, sizes)) >= 5.0, "readable in print"
    assert "Height / mm" in pdf_words(tmp_path / "out" / "run-0001-fall.pdf").split("\n")
