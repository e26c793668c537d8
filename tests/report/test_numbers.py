"""The report for programs: every key documented, operators' text stays text, where each number comes from."""

from __future__ import annotations

import csv
import hashlib
import json
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from support.changed import changed
from support.results import default_setup, drop_result

from radargui.files.run_results import write_results
from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block, Gap
from radargui.model.result import RunResult
from radargui.model.setup import Setup, dump_setup
from radargui.model.setup_error import changed_settings
from radargui.report.facts import ReportFacts, SessionFacts, provenance_of, report_facts
from radargui.report.numbers import FILES, escaped, methods, report_document, typeset, write_numbers
from radargui.report.run_facts import RunFacts, take_facts
from radargui.report.tables import json_bytes
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
EVIL = "=cmd()|' /C calc'!A0\n<script>alert(1)</script> \\input{x} 50 % & _^~{}{$"


@cache
def drop(number: int, e: float = 0.8) -> RunResult:
    return drop_result(rate_hz=2000.0, e=e, seed=number, name=f"run-{number:04d}")


def facts_of(folder: Path, name: str, es: tuple[float, ...], **about: str) -> SessionFacts:
    """A session with stored results, the last run set aside."""
    session = Session.create(folder, default_setup(), name=name, now=NOW, **about)
    runs: list[RunFacts] = []
    for number, e in enumerate(es, 1):
        result = drop(number, e)
        with session.new_run(result.recording.digitisation, started_at=NOW.isoformat()) as writer:
            writer.write(Block(result.recording.raw, 0))
        write_results(writer.path, result)
        runs.append(take_facts(result, writer.path.stem, columns=0))
    session.reject(writer.path, EVIL)
    kept = tuple(runs[:-1])
    provenance = provenance_of(session, {run.name: run for run in kept}, "now")
    session.close()
    return SessionFacts(session.info, kept, provenance)


@pytest.fixture(scope="module")
def series(tmp_path_factory: pytest.TempPathFactory) -> tuple[SessionFacts, SessionFacts]:
    folder = tmp_path_factory.mktemp("sessions")
    steel = facts_of(folder, "a", (0.79, 0.80, 0.81, 0.5), sample=EVIL, target="glass", operator=EVIL)
    return steel, facts_of(folder, "b", (0.69, 0.70, 0.72, 0.5), sample="brass")


def document_of(facts: ReportFacts) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(json_bytes(report_document(facts)))
    return found


def validator() -> Draft202012Validator:
    schema = json.loads((resources.files("radargui.report") / "report.schema.json").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def test_the_schema_documents_every_key_of_one_session_and_of_a_series(
    series: tuple[SessionFacts, SessionFacts],
) -> None:
    for sessions in (series[:1], series):
        document = document_of(report_facts(sessions, "now", "power"))
        validator().validate(document)
        # a key that nobody documented would be refused
        assert not validator().is_valid({**document, "surprise": 1})
    run = document["sessions"][0]["runs"][0]
    assert not validator().is_valid({**document, "sessions": [{**document["sessions"][0], "runs": [{**run, "x": 1}]}]})


def test_a_report_without_any_run_fits_the_schema_too(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), now=NOW)
    facts = report_facts([SessionFacts(session.info, (), provenance_of(session, {}, "now"))], "now")
    session.close()
    document = document_of(facts)
    validator().validate(document)
    assert document["series"]["e_first_bounce"]["mean"] is None
    assert all(fit["problem"] for fit in document["samples"][0]["fits"])


def test_the_numbers_are_those_computed_from_the_truth(series: tuple[SessionFacts, SessionFacts]) -> None:
    document = document_of(report_facts(series[:1], "now"))
    e = document["series"]["e_first_bounce"]
    values = np.array([0.79, 0.80, 0.81])
    assert e["n"] == 3
    assert e["mean"] == pytest.approx(values.mean(), abs=1e-12)
    assert e["standard_deviation"] == pytest.approx(0.01)
    half = 4.302653 * 0.01 / np.sqrt(3.0)
    assert (e["interval_low"], e["interval_high"]) == pytest.approx((0.8 - half, 0.8 + half), abs=1e-7)
    assert document["excluded"] == [{"run": "run-0004", "kind": "set aside", "reason": EVIL}]
    fits = {fit["model"]: fit for fit in document["samples"][0]["fits"]}
    assert fits["constant"]["n_runs"] == 3
    fall = document["runs"][0]["free_fall"]
    assert fall["last_time_from_zero_s"] == pytest.approx(fall["last_time_s"] - document["runs"][0]["zero_time_s"])
    first = document["runs"][0]["bounces"][0]
    assert first["time_from_zero_s"] == pytest.approx(first["time_s"] - document["runs"][0]["zero_time_s"])


@pytest.mark.parametrize(
    ("cell", "shown"),
    [
        ("8.9e-06", r"8.9 $\times 10^{-6}$"),
        ("3.66e+10", r"3.66 $\times 10^{10}$"),
        ("-774.96", "$-$774.96"),
        ("n = -0.0002(18); a = 1e-07", r"n = $-$0.0002(18); a = 1 $\times 10^{-7}$"),
        ("2026-11-23T04-05-17", "2026-11-23T04-05-17"),
        ("run-0001", "run-0001"),
        ("0.80000(22)", "0.80000(22)"),
        ("sample 3e-4x", "sample 3e-4x"),
    ],
)
def test_numbers_in_latex_have_a_minus_and_powers_of_ten(cell: str, shown: str) -> None:
    assert typeset(cell) == shown


def test_operators_text_is_text_in_every_file(series: tuple[SessionFacts, SessionFacts], tmp_path: Path) -> None:
    write_numbers(report_facts(series, "now"), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(FILES)
    for name in ("report.csv", "report-series.csv"):
        rows = list(csv.reader((tmp_path / name).read_text(encoding="utf-8").splitlines()))
        assert {len(row) for row in rows} == {len(rows[0])}
        assert not any(cell.lstrip().startswith(("=", "+", "@")) for row in rows for cell in row)
    tex = (tmp_path / "report.tex").read_text(encoding="utf-8")
    assert r"\input" not in tex
    assert r"\textbackslash{}input\{x\} 50 \% \& \_" in tex
    assert tex.count(r"\begin{longtable}") == tex.count(r"\end{longtable}") == 1 + 2 + 2
    assert all(line.replace(r"\{", "").count("{") == line.replace(r"\}", "").count("}") for line in tex.splitlines())
    bib = (tmp_path / "report.bib").read_text(encoding="utf-8")
    assert bib.count("@misc") == 2
    assert r"\input" not in bib
    assert bib.count("{") == bib.count("}")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a_b & 5 % #1", r"a\_b \& 5 \% \#1"),
        ("\\today{}", r"\textbackslash{}today\{\}"),
        ("two\nlines\t\x00 e²", "two lines e$^2$"),
        ("~ ^ < >", r"\textasciitilde{} \textasciicircum{} \textless{} \textgreater{}"),
    ],
)
def test_no_text_is_a_command_of_latex(text: str, shown: str) -> None:
    assert escaped(text) == shown


def test_the_provenance_names_every_file_with_its_checksum_and_why_it_was_set_aside(
    series: tuple[SessionFacts, SessionFacts], tmp_path: Path
) -> None:
    one = facts_of(tmp_path, "c", (0.8, 0.81)).provenance
    path = tmp_path / "c" / "run-0001.h5"
    first, second = one.runs
    assert first.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert first.size_bytes == path.stat().st_size
    assert first.samples_crc32.startswith(f"{first.n_samples}:")
    assert (first.source, first.device, first.set_aside) == ("device", "made by hand", "")
    assert [(made.correction, made.is_present) for made in first.processings] == [("published", True)]
    assert first.processings[0].e == pytest.approx(0.8)
    assert (second.set_aside, second.device) == (EVIL, "made by hand")
    assert first.settings_changed == ()
    assert "numpy" in one.reported_with
    assert not first.problem


def test_a_run_with_other_settings_or_a_damaged_file_says_so(tmp_path: Path) -> None:
    session = Session.create(tmp_path, default_setup(), name="d", now=NOW)
    result = drop_result(rate_hz=2000.0, gap=Gap(900, 20, "late"))
    other = changed(default_setup(), daq={"range_v": 2.5})
    path, made = session.path / "run-0001.h5", result.recording.digitisation
    with RunWriter(path, made, started_at=NOW.isoformat(), setup_toml=dump_setup(other)) as writer:
        writer.write(Block(result.recording.raw[:, :900], 0))
        writer.write(Block(result.recording.raw[:, 900:], 920, Gap(900, 20, "late")))
    write_results(path, replace(result, setup=other))
    (session.path / "run-0002.h5").write_bytes(b"no run")
    facts = take_facts(result, "run-0001", columns=0)
    first, broken = provenance_of(session, {"run-0001": facts}, "now").runs
    session.close()
    assert (first.n_gaps, first.n_lost) == (1, 20)
    assert first.settings_changed == ("daq.range_v: 5.0 -> 2.5",)
    assert first.processings[0].settings_changed == first.settings_changed
    assert "run-0002.h5" in broken.problem


def test_settings_of_each_receiver_are_named() -> None:
    setup = default_setup()
    moved: Setup = setup.model_copy(
        update={"receiver": (setup.receiver[0].model_copy(update={"tilt_deg": 41.0}), *setup.receiver[1:])}
    )
    assert list(map(str, changed_settings(setup, moved))) == ["receiver[1].tilt_deg: 40.0 -> 41.0"]


def test_the_methods_say_what_was_done_with_these_numbers(series: tuple[SessionFacts, SessionFacts]) -> None:
    said = methods(report_facts(series[:1], "now", "johnson"))
    for part in ("dropped 3 times", "3 drops gave a valid e", "2000 samples per second", "splines", "10 GHz", "exact"):
        assert part in said
    assert "Johnson, Contact Mechanics" in said
    none = replace(series[0], runs=tuple(replace(run, correction="none", geometry="plane") for run in series[0].runs))
    other = methods(report_facts([none], "now"))
    assert "as they were recorded" in other
    assert "plane-wave" in other
    assert "Johnson" not in other


def test_sessions_of_one_name_are_told_apart(series: tuple[SessionFacts, SessionFacts]) -> None:
    found = report_facts([series[0], series[0]], "now").findings
    assert [one.name for one in found.sessions] == ["a", "a (2)"]
    # the same files twice are the same drops
    assert [one.series.e.n for one in found.sessions] == [3, 3]
