"""Every figure alone, as wide as a column."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import pytest
from support.gui_sessions import make_session
from support.pdf_text import pdf_streams, pdf_words

from radargui.model.errors import UsageError
from radargui.processing.result_of_run import result_of_run
from radargui.report.report import parse_width, write_figures
from radargui.session.session import Session


@pytest.mark.parametrize(("text", "width_mm"), [("86mm", 86.0), ("8.6 cm", 86.0), ("3.4in", 86.36)])
def test_a_width_has_a_unit(text: str, width_mm: float) -> None:
    assert parse_width(text) == pytest.approx(width_mm)


@pytest.mark.parametrize("text", ["86", "wide", "5mm", "-86mm", "1e9mm", "86mm; rm", ""])
def test_a_width_that_no_column_has_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="60mm to 250mm"):
        parse_width(text)


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
