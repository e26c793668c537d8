"""g against the site's in the report and in the window's page of figures: said, and warned of where they differ."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.changed import changed
from support.results import drop_result

from radargui.gui.runs.figures_view import FiguresView
from radargui.gui.theme import Theme
from radargui.model.result import RunResult
from radargui.report.content import Facts, Note
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_section


def result_at(g_m_s2: float) -> RunResult:
    result = drop_result(rate_hz=1000.0)
    site = {"g_m_s2": g_m_s2, "u_g_m_s2": 1e-4}
    return replace(result, setup=changed(result.setup, site=site, tracer={"density_kg_m3": 7800.0}))


@pytest.mark.parametrize(("g_m_s2", "differ"), [(9.81, False), (9.0, True)])
def test_the_report_says_what_was_compared_and_warns_where_they_differ(g_m_s2: float, differ: bool) -> None:
    result = result_at(g_m_s2)
    blocks = run_section(take_facts(result, "run-0001"), result.setup).blocks
    (facts,) = (
        one for one in blocks if isinstance(one, Facts) and ("g (statistical u)", "(9.8123 ± 0.0034) m/s²") in one.rows
    )
    (compared,) = (value for name, value in facts.rows if name == "g against the site")
    assert "0.023 % that air takes off a sphere of 7800 kg/m³" in compared
    warned = [one.text for one in blocks if isinstance(one, Note) and one.text.startswith("g is not that of the site")]
    assert bool(warned) == differ


@pytest.mark.parametrize(("g_m_s2", "differ"), [(9.81, False), (9.0, True)])
def test_the_window_says_it_too_in_the_colour_of_an_alarm_where_they_differ(
    g_m_s2: float, differ: bool, qapp: object
) -> None:
    theme = Theme(qapp, "light")  # type: ignore[arg-type]
    view = FiguresView(theme)
    view.show()
    view.show_result(result_at(g_m_s2))
    assert "g against the site" in view.toPlainText()
    warned = view.document().find("g is not that of the site")
    assert warned.isNull() != differ
    if differ:
        assert warned.charFormat().foreground().color().name() == theme.colours.alarm


def test_without_a_site_nothing_is_compared() -> None:
    result = drop_result(rate_hz=1000.0)
    blocks = run_section(take_facts(result, "run-0001"), result.setup).blocks
    assert not [1 for one in blocks if isinstance(one, Facts) for name, _ in one.rows if name == "g against the site"]
