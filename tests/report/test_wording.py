"""What a reader would stumble over: statements are true of one run and of many, units whole, warnings are warnings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text
from support.pdf_text import pdf_words
from support.results import BUDGET, default_setup, drop_result, quiet_result, rejected_result

from radargui.model.drop import RunOrigin
from radargui.model.result import Bounces
from radargui.model.uncertainty_budget import budget_rows
from radargui.report.content import Chapter, Facts, Grid, MainResult, Note, Plots, templates
from radargui.report.curves import COMPACT, take_curves
from radargui.report.facts import ReportFacts, SessionFacts, report_facts
from radargui.report.findings_section import findings_blocks, front_chapters
from radargui.report.numbers import latex_tables, methods
from radargui.report.run_facts import RunFacts, take_facts
from radargui.report.run_figures import iq_figure
from radargui.report.run_section import run_page, run_section
from radargui.report.series_figures import speeds_figure
from radargui.report.typesetting import Typesetter
from radargui.session.info import SessionInfo


def texts_of(figure: Figure) -> list[str]:
    return [one.get_text() for one in figure.findobj(Text)]


def facts_of(*sessions: tuple[RunFacts, ...]) -> ReportFacts:
    infos = (SessionInfo(name=f"s{n}", created_at="", setup=default_setup()) for n in range(len(sessions)))
    return report_facts([SessionFacts(info, runs) for info, runs in zip(infos, sessions, strict=True)], "now")


def simulated(n: int, **how: float) -> tuple[RunFacts, ...]:
    drops = [drop_result(rate_hz=2000.0, seed=k, name=f"run-{k:04d}", **how) for k in range(1, n + 1)]
    origin = RunOrigin("simulated")
    return tuple(replace(take_facts(one, one.recording.name, COMPACT), source=origin) for one in drops)


def row(run: RunFacts, name: str) -> str:
    blocks = run_section(run, default_setup()).blocks
    (value,) = (value for one in blocks if isinstance(one, Facts) for key, value in one.rows if key == name)
    return value


@pytest.mark.parametrize(
    ("n", "warning", "dropped"),
    [
        (1, "The run is simulated: no measurement.", "was dropped once from 260.0 mm; 1 drop gave a valid e."),
        (2, "All runs are simulated: no measurement.", "was dropped twice from 260.0 mm; 2 drops gave a valid e."),
        (3, "All runs are simulated: no measurement.", "was dropped 3 times from 260.0 mm; 3 drops gave a valid e."),
    ],
)
def test_one_run_is_spoken_of_as_one(n: int, warning: str, dropped: str) -> None:
    facts = facts_of(simulated(n))
    assert Note(warning, warning=True) in list(findings_blocks(facts))
    assert dropped in methods(facts)
    assert ("The run is simulated." in methods(facts)) == (n == 1)
    runs = "1 run" if n == 1 else f"{n} runs"
    found = next(one for one in findings_blocks(facts) if isinstance(one, Facts))
    assert dict(found.rows)["Drops"].startswith(f"{n} of {runs}, from 260.0 mm")
    (speeds,) = (one for one in front_chapters(facts)[1].blocks if isinstance(one, Grid) and "AICc" in one.header)
    assert f" impacts of {runs} (* best described)" in speeds.title


@pytest.mark.parametrize(
    ("n", "warning"),
    [(1, "The run is a replay, no drop of its own."), (2, "All runs are replays, no drops of their own.")],
)
def test_one_replay_is_spoken_of_as_one(n: int, warning: str) -> None:
    replays = tuple(replace(one, source=RunOrigin("replay")) for one in simulated(n))
    assert Note(warning, warning=True) in list(findings_blocks(facts_of(replays)))


def test_the_answer_stands_first_with_what_it_is_of() -> None:
    facts = facts_of(simulated(3))
    first, *_ = findings_blocks(facts)
    assert first == MainResult(f"e = {facts.findings.sessions[0].series.e.words()}", facts.findings.sentence)
    quiet = facts_of((take_facts(quiet_result(), "run-0001", COMPACT),))
    assert next(iter(findings_blocks(quiet))) == Note(quiet.findings.sentence), "of no drop there is no e"


def test_the_mean_of_sessions_says_what_is_not_in_its_interval_and_what_its_p_tests() -> None:
    sentence = facts_of(simulated(2), simulated(2, e=0.81)).findings.sentence
    assert "without what these share, such as calibration and sphere" in sentence
    assert "(F-test that sessions do not differ: p " in sentence


def test_further_impacts_are_told_and_are_no_warning() -> None:
    (run,) = simulated(1)
    impacts = run.bounces.impacts
    for further, words in ((1, "1 more impact is in report.csv."), (3, "3 more impacts are in report.csv.")):
        many = replace(run, bounces=Bounces((*impacts, *impacts)[: 6 + further]))
        assert Note(words) in run_page(many).blocks


def test_g_of_a_run_has_the_combined_uncertainty_that_its_e_has() -> None:
    (run,) = simulated(1)
    assert row(run, "g (combined u)") == "(9.8123 ± 0.0050) m/s²"
    assert row(run, "g (statistical u)") == "(9.8123 ± 0.0034) m/s²"


def test_units_are_whole_and_a_rate_has_no_digits_that_nobody_set() -> None:
    assert [name for name, *_ in budget_rows(BUDGET)] == ["u of", "position / mm", "e", "g / (m/s²)"]
    (run,) = simulated(1)
    assert row(replace(run, rate_hz=33333.0), "Samples").endswith(" at 33333 Hz")
    assert row(replace(run, rate_hz=2e6), "Samples").endswith(" at 2000000 Hz")
    fall = run.bounces.free_fall
    assert fall is not None
    fitted = replace(run, bounces=replace(run.bounces, free_fall=replace(fall, residual_rms_m=4.48e-7)))
    assert row(fitted, "Residual of the fit") == "0.448 µm rms"


def test_the_figure_of_e_says_whose_uncertainty_its_bars_are_and_which_impacts_it_leaves_out() -> None:
    (run,) = simulated(1)
    first, *others = run.bounces.impacts
    vague = replace(run, bounces=replace(run.bounces, impacts=(*others, replace(first, u_e=0.2))))
    for one, left_out in ((run, ""), (vague, "; 1 with u > 10 % of e left out")):
        texts = texts_of(speeds_figure(facts_of((one,)), (180.0, 80.0)))
        assert f"e of valid impacts, bars ± 2 statistical u{left_out}" in texts
        assert any(text.endswith(" ± 2 u") for text in texts), "of the model, whose band is drawn too"


def test_a_refused_run_warns_that_nothing_of_it_is_valid_and_one_without_motion_tells_of_no_fall() -> None:
    refused, quiet = (take_facts(make(), "run-0001", COMPACT) for make in (rejected_result, quiet_result))
    told = Note("Rejected: no position, e or g of this run is valid.", warning=True)
    assert told in run_page(refused).blocks
    assert told in run_section(refused, default_setup()).blocks
    shown = run_page(quiet).blocks
    assert told not in shown
    assert [name for one in shown if isinstance(one, Facts) for name, _ in one.rows] == ["Result", "Recorded"]


def test_a_receiver_without_corrected_signal_is_said_to_have_none() -> None:
    result = drop_result(rate_hz=2000.0)
    assert result.corrected is not None
    unknown = result.corrected.i.copy()
    unknown[1] = float("nan")
    curves = take_curves(replace(result, corrected=replace(result.corrected, i=unknown, q=unknown)), COMPACT)
    assert curves is not None
    assert texts_of(iq_figure(curves)).count("not known") == 1


def test_no_figure_on_the_screen_is_without_a_caption() -> None:
    facts = facts_of(simulated(2))
    quiet = take_facts(quiet_result(), "run-0001", COMPACT)
    pages = [*front_chapters(facts), run_page(facts.sessions[0].runs[0]), run_page(quiet)]
    shown = [block for page in pages for block in (page.screen or page.blocks) if isinstance(block, Plots)]
    titles = [one.title for block in shown for one in block.plots]
    assert titles == ["e against the impact speed", "Track", "Falls", "Phase and height", "I and Q"]


def test_of_a_single_drop_no_scatter_no_interval_and_no_outlier_test_is_told() -> None:
    for n, of, first in ((1, "a single drop", "statistical"), (3, "the mean", "standard error")):
        facts = facts_of(simulated(n))
        (budget,) = (one for one in findings_blocks(facts) if isinstance(one, Grid) and "combined" in one.header)
        assert budget.title == f"Standard uncertainty of {of}, with shares of its square"
        assert budget.header[1] == first
        said = methods(facts)
        assert ("from the scatter of the drops" in said) == ("Intervals are 95 %" in said) == (n > 1)
        assert ("Outliers were flagged" in said) == (n > 2)


def test_in_latex_only_e_has_the_uncertainty_that_is_its_own() -> None:
    (run,) = simulated(1)
    first, *others = run.bounces.impacts
    first = replace(first, e_flight_time=0.80012345, e_height=0.79987654)
    run = replace(run, bounces=replace(run.bounces, impacts=(first, *others)))
    (row,) = (line for line in latex_tables(facts_of((run,))).splitlines() if line.startswith("run-0001 & 1 &"))
    e, by_time, by_height = row.split(" & ")[4:7]
    assert e.endswith(")")
    assert "(" not in by_time + by_height
    assert len(by_time) == len(by_height) == len(e.partition("(")[0])


def test_the_methods_of_a_session_without_a_valid_drop_tell_of_no_uncertainty() -> None:
    said = methods(facts_of((take_facts(quiet_result(), "run-0001", COMPACT),)))
    assert "0 drops gave a valid e" in said
    assert "stands with" not in said


def test_powers_of_ten_stand_in_html_and_pdf_as_people_write_them(tmp_path: Path) -> None:
    blocks = (
        Facts((("u", "(1.0 ± 8.9e-06) m"),)),
        Grid(("receiver", "u"), (("1", "9.6e-06"), ("2", "1.2e+07"))),
        Note("p is 4.5e-08. Taken from run 3e-05.csv."),
    )
    page = templates().get_template("blocks.html").render(blocks=blocks)
    pages = Typesetter(tmp_path)
    pages.put(Chapter("Powers", blocks))
    pages.write(tmp_path / "page.pdf", "a4", "", "", "2026-11-20T15:04:05+00:00")
    for text in (page, pdf_words(tmp_path / "page.pdf")):
        for power in ("8.9 × 10⁻⁶", "9.6 × 10⁻⁶", "1.2 × 10⁷", "4.5 × 10⁻⁸"):
            assert power in text
        assert "3e-05.csv" in text, "a name is no number"
