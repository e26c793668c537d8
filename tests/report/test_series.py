"""Statistics and tables of a series of runs."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given, strategies as st
from support.results import default_setup, drop_result, quiet_result

from radargui.model.result import Bounces
from radargui.report.facts import Provenance, ReportFacts, SessionFacts, report_facts
from radargui.report.numbers import IMPACT_HEADER, impacts_csv, report_document, series_csv
from radargui.report.run_facts import RunFacts, take_facts
from radargui.report.tables import json_bytes, plain_value, safe_cell
from radargui.restitution.series import series_of
from radargui.restitution.statistics import Statistics
from radargui.session.info import SessionInfo


def runs() -> list[RunFacts]:
    drops = [drop_result(rate_hz=2000.0, e=e, seed=k, name=f"run-{k:04d}") for k, e in enumerate((0.79, 0.80, 0.81), 1)]
    facts = [take_facts(drop, drop.recording.name) for drop in drops]
    return [*facts, take_facts(quiet_result(), "run-0004"), RunFacts("run-0005", failure="=cmd damaged")]


def facts(**about: str) -> ReportFacts:
    info = SessionInfo(name="s", created_at="2026-11-20T15:04:05+00:00", setup=default_setup(), **about)
    empty = Provenance({}, "", {}, ())
    return report_facts([SessionFacts(info, tuple(runs()), empty)], "now")


def table(content: bytes) -> list[list[str]]:
    return list(csv.reader(content.decode().splitlines()))


def e_of(facts: Sequence[RunFacts]) -> Statistics:
    return series_of([run.drop for run in facts]).e


def test_the_series_counts_only_runs_that_saw_the_release() -> None:
    found = e_of(runs())
    assert (found.n, found.mean) == (3, pytest.approx(0.80))
    late = [
        replace(run, figures={**(run.figures or {}), "from_rest": False}) if run.name == "run-0001" else run
        for run in runs()
    ]
    assert series_of([run.drop for run in late]).drop_height_m.n == e_of(late).n == 2


def test_a_first_bounce_that_is_not_valid_is_not_replaced_by_the_second() -> None:
    first, *others = drop_result(rate_hz=2000.0).bounces.impacts
    result = drop_result(rate_hz=2000.0)
    facts = take_facts(replace(result, bounces=Bounces((replace(first, valid=False), *others))), "run-0001")
    assert facts.drop.e is None


def test_the_csv_has_a_row_for_each_impact_and_one_for_each_run_without() -> None:
    rows = table(impacts_csv(facts()))
    assert tuple(rows[0]) == IMPACT_HEADER
    impacts = sum(len(run.bounces.impacts) for run in runs())
    assert len(rows) == 1 + impacts + 2
    assert {len(row) for row in rows} == {len(IMPACT_HEADER)}
    assert rows[1][:2] == ["s", "run-0001"]
    first = dict(zip(rows[0], rows[1], strict=True))
    assert float(first["e"]) == pytest.approx(0.79)
    zero_s, since = drop_result(rate_hz=2000.0).zero
    assert float(first["time_s"]) - float(first["time_from_zero_s"]) == pytest.approx(zero_s)
    assert since == "the first motion"
    assert rows[-2][1:5] == ["run-0004", "no motion", "", "nan"]
    assert rows[-1][2] == "failed"
    assert rows[-1][IMPACT_HEADER.index("reason")] == "'=cmd damaged"


def test_the_statistics_table_has_one_row_a_quantity() -> None:
    rows = table(series_csv(facts()))
    assert [row[1] for row in rows[1:]] == ["e_first_bounce", "g_m_s2", "drop_height_m", "impact_speed_m_s"]
    assert float(rows[1][3]) == pytest.approx(0.80)


@given(st.text(max_size=50))
def test_no_cell_begins_like_a_formula(text: str) -> None:
    cell = safe_cell(text)
    assert not cell.lstrip(" ").startswith(("=", "+", "-", "@", "\t", "\r"))
    assert cell.endswith(text)


def test_the_session_document_is_strict_json_with_every_run() -> None:
    document = json.loads(json_bytes(report_document(facts(operator="@x"))))
    assert [run["name"] for run in document["runs"]] == [f"run-000{k}" for k in range(1, 6)]
    assert document["runs"][0]["free_fall"]["g_m_s2"] == pytest.approx(9.8123)
    assert document["runs"][4]["reason"] == "=cmd damaged"
    assert document["series"]["e_first_bounce"]["n"] == 3
    assert document["condition_number"] > 1.0
    assert document["setup"]["schema"] == 1


json_like = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(json_like)
def test_any_value_becomes_json_without_nan(value: object) -> None:
    def refuse(text: str) -> None:
        raise AssertionError(text)

    assert json.loads(json_bytes(value), parse_constant=refuse) == plain_value(value)
