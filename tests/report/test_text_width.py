"""Text fits where the page has room for it."""

from __future__ import annotations

import sys

import matplotlib as mpl
import pytest
from hypothesis import given, strategies as st

from radargui.report.sheet import page_style, printable, width_mm, wrapped


def test_a_bold_and_a_larger_text_is_wider() -> None:
    assert width_mm("run-0001", 8.0, bold=True) > width_mm("run-0001", 8.0) > width_mm("run-0001", 7.0) > 5.0


@given(st.text(max_size=300))
def test_no_line_is_wider_than_the_room(text: str) -> None:
    shown = printable(text)
    for line in wrapped(shown, 8.0, 40.0):
        assert width_mm(line, 8.0) <= 40.0 + 1e-9
    assert "".join(wrapped(shown, 8.0, 40.0)).replace(" ", "") == "".join(shown.split())


def test_what_no_font_can_draw_is_a_question_mark_and_line_ends_stay() -> None:
    assert printable("α µ ± é\nsecond\x00\x07") == "α µ ± é\nsecond"
    assert printable("\U000e0020x\ue123") in {"?x?", "x?", "x"}


def test_the_style_of_a_page_imports_nothing_that_warns_and_stays_on_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "matplotlib.style.core", raising=False)
    with mpl.rc_context({"lines.linewidth": 7.0}):
        with page_style():
            assert mpl.rcParams["lines.linewidth"] < 2.0
            assert mpl.rcParams["font.family"][0] == "DejaVu Sans"
        assert mpl.rcParams["lines.linewidth"] == 7.0
    assert "matplotlib.style.core" not in sys.modules
