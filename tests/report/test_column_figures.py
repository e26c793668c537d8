"""Every figure alone, as wide as a column."""

from __future__ import annotations

import struct
from dataclasses import replace
from pathlib import Path

import pytest
from pypdf import PdfReader
from support.figure_text import faults_of
from support.gui_sessions import make_session
from support.pdf_text import pdf_words
from support.results import default_setup, drop_result, quiet_result, rejected_result

from radargui.model.errors import UsageError
from radargui.processing.result_of_run import result_of_run
from radargui.report.facts import SessionFacts
from radargui.report.plots import page_style
from radargui.report.run_facts import RunFacts, take_facts
from radargui.report.run_figures import single_figures
from radargui.report.series_figures import parse_width, session_figures, write_figures
from radargui.session.info import SessionInfo
from radargui.session.session import Session


@pytest.mark.parametrize(("text", "width_mm"), [("86mm", 86.0), ("8.6 cm", 86.0), ("3.4in", 86.36)])
def test_a_width_has_a_unit(text: str, width_mm: float) -> None:
    assert parse_width(text) == pytest.approx(width_mm)


@pytest.mark.parametrize("text", ["86", "wide", "5mm", "-86mm", "1e9mm", "86mm; rm", ""])
def test_a_width_that_no_column_has_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="60mm to 250mm"):
        parse_width(text)


def run_figures() -> list[tuple[str, RunFacts]]:
    drop = drop_result(rate_hz=5000.0)
    assert drop.corrected is not None
    modelled = replace(drop, corrected=replace(drop.corrected, method="adaptive", steps=()))
    results = {"published": drop, "adaptive": modelled, "quiet": quiet_result(), "rejected": rejected_result()}
    return [(name, take_facts(result, name)) for name, result in results.items()]


@pytest.mark.parametrize("width_mm", [60.0, pytest.param(86.0, marks=pytest.mark.slow)])
def test_in_the_narrowest_figures_no_text_lies_on_another_or_leaves_them(width_mm: float) -> None:
    facts = run_figures()
    drawn = {}
    with page_style():
        session = SessionFacts(
            SessionInfo(name="s", created_at="", setup=default_setup()), tuple(one for _, one in facts)
        )
        for name, run in facts:
            assert run.curves is not None
            drawn |= dict(single_figures(name, run.curves, width_mm))
        drawn |= dict(session_figures(session, width_mm))
        faults = {name: found for name, figure in drawn.items() if (found := faults_of(figure))}
    assert faults == {}
    assert {"published-fall", "published-phase", "adaptive-receiver-1-correction", "restitution", "falls"} < set(drawn)


@pytest.mark.slow
def test_every_figure_is_there_as_pdf_svg_and_png_in_this_width(tmp_path: Path) -> None:
    session = Session.open(make_session(tmp_path / "data", 4), write=False)
    names = write_figures(session, result_of_run, tmp_path / "out", 86.0, dpi=100)
    of_receivers = [f"run-0001-receiver-{k}-{part}" for k in (1, 2, 3) for part in ("iq", "correction")]
    assert names == [*of_receivers, "run-0001-phase", "run-0001-fall", "restitution", "falls"]
    made = {path.name for path in (tmp_path / "out").iterdir()}
    assert made == {f"{name}.{kind}" for name in names for kind in ("pdf", "svg", "png")}
    for name in names:
        path = tmp_path / "out" / name
        (page,) = PdfReader(path.with_suffix(".pdf")).pages
        assert float(page.mediabox.width) * 25.4 / 72.0 == pytest.approx(86.0, abs=0.05)
        (width,) = struct.unpack(">I", path.with_suffix(".png").read_bytes()[16:20])
        assert width == pytest.approx(86.0 / 25.4 * 100, abs=1.0)
        assert "</svg>" in path.with_suffix(".svg").read_text(encoding="utf-8")
    assert "Height" in pdf_words(tmp_path / "out" / "run-0001-fall.pdf")
