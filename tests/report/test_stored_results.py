"""A report of runs whose files hold their results says what one of computed results says, without computing."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.changed import changed
from support.gui_sessions import make_session
from support.stored_runs import SETUP

from radargui.experiment.reprocess import process_run
from radargui.files.run_card import read_run_card
from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.model.words import sentence
from radargui.processing.process import STOPPED, cut_short, process
from radargui.processing.result_of_run import result_of_run, stored_or_computed, stored_result
from radargui.report.content import Note
from radargui.report.facts import SessionFacts, provenance_of, report_facts
from radargui.report.findings_section import front_chapters
from radargui.report.numbers import write_numbers
from radargui.report.report import study_session
from radargui.report.run_facts import study, take_facts
from radargui.report.run_section import run_section
from radargui.report.tables import write_tables
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)


def assert_close(found: object, wanted: object, name: str = "") -> None:
    """Want equal texts and numbers; curves equal to single precision."""
    if isinstance(wanted, np.ndarray):
        np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-6, err_msg=name)
    elif is_dataclass(wanted):
        for one in fields(wanted):
            assert_close(getattr(found, one.name), getattr(wanted, one.name), one.name)
    elif isinstance(wanted, tuple):
        assert isinstance(found, tuple)
        for one, other in zip(found, wanted, strict=True):
            assert_close(one, other, name)
    else:
        np.testing.assert_equal(found, wanted, err_msg=name)


@pytest.mark.parametrize("correction", ["adaptive", "published"])
def test_tables_are_equal_and_curves_to_single_precision(tmp_path: Path, correction: str) -> None:
    run = make_session(tmp_path / "data", 4) / "run-0001.h5"
    setup = changed(SETUP, processing={"correction": correction})
    computed = process(read_run(run), setup)
    write_results(run, computed)
    wanted = replace(take_facts(computed, "run-0001"), source=read_run_card(run).origin)
    write_tables(computed, tmp_path / "computed")
    # which computes nothing
    assert_close(study(run, setup, stored_result), wanted)
    assert wanted.curves is not None
    assert bool(wanted.curves.receivers[0].steps) == (correction == "published")

    write_tables(stored_result(run, setup), tmp_path / "stored")
    names = sorted(path.name for path in (tmp_path / "computed").iterdir())
    assert names == ["bounces.csv", "motion.csv", "result.json", "track.csv"]
    for name in names:
        assert (tmp_path / "stored" / name).read_bytes() == (tmp_path / "computed" / name).read_bytes()


def test_the_report_does_not_compute_what_the_files_hold(tmp_path: Path) -> None:
    def numbers(name: str) -> Path:
        write_numbers(report_facts([study_session(session, result_of_run)], "now"), tmp_path / name)
        return tmp_path / name

    session = Session.open(make_session(tmp_path / "data", 4))
    wanted = numbers("wanted")
    (run,) = session.run_paths()
    with h5py.File(run, "r+") as file:
        del file["results"]
    computed = numbers("computed")
    for name in ("report.csv", "report-series.csv", "report.tex"):
        assert (wanted / name).read_bytes() == (computed / name).read_bytes()
    documents = [json.loads((one / "report.json").read_bytes()) for one in (wanted, computed)]
    # the file is another one without its results, and its checksum says so
    provenances = [one.pop("provenance")["runs"][0] for one in documents]
    assert documents[0] == documents[1]
    assert provenances[0]["sha256"] != provenances[1]["sha256"]
    assert provenances[0]["samples_crc32"] == provenances[1]["samples_crc32"]
    process_run(run)
    assert study(run, session.setup, stored_result).status == "ok"


def test_the_report_says_what_is_preliminary(tmp_path: Path) -> None:
    session = Session.open(make_session(tmp_path / "data", 4, n_runs=2))
    run = session.run_paths()[1]
    write_results(run, cut_short(replace(process(read_run(run), SETUP), preliminary=True)))
    facts = [study(path, session.setup, stored_result) for path in session.run_paths()]
    assert [one.verdict for one in facts] == ["good", "good, preliminary"]
    assert [one.said for one in facts] == ["simulated, good", "simulated, good, preliminary, 1 warning"]
    one = SessionFacts(session.info, tuple(facts), provenance_of(session, {}, "now"))
    first, *_ = front_chapters(report_facts([one], "now"))
    told = [block.text for block in first.blocks if isinstance(block, Note) and block.warning]
    assert told == [
        "All runs are simulated: no measurement.",
        "Preliminary, because the correction was stopped before it ended: run-0002. radargui batch makes up for it.",
    ]
    assert Note(sentence(STOPPED.text), warning=True) in run_section(facts[1], session.setup).blocks


def test_what_another_setup_gave_is_shown_and_not_computed_again(tmp_path: Path) -> None:
    session = Session.open(make_session(tmp_path / "data", 4))
    (run,) = session.run_paths()
    other = changed(SETUP, tracer={"diameter_m": 0.012})
    wanted = process_run(run, other)
    assert (
        stored_or_computed(run, session.setup).setup == stored_result(run, session.setup).setup == wanted.setup == other
    )
