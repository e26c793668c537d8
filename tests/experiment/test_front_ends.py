"""Runs of a session processed in order: each is given what those before it found out about the front ends."""

from __future__ import annotations

import shutil
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest
from support.changed import changed
from support.stored_runs import SETUP, store_runs

from radargui.experiment.batch import BatchTask, work_on
from radargui.experiment.finished import FinishedJob, process_finished
from radargui.files.run_results import write_results
from radargui.files.run_writer import RunWriter
from radargui.files.stored_results import read_prior
from radargui.model.channel_quality import ChannelQuality
from radargui.model.recording import Block
from radargui.model.result import RunResult
from radargui.model.setup import dump_setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import process
from radargui.session.known_setup import known_front_ends
from radargui.session.session import Session

JOINT = changed(SETUP, processing={"correction": "joint"})


@pytest.fixture
def runs(tmp_path: Path) -> tuple[Path, Path]:
    """Two runs of a session, of which the first found its front ends by the joint correction."""
    session = Session.create(tmp_path, JOINT, now=datetime(2026, 11, 20, tzinfo=UTC))
    (recorded,) = store_runs(tmp_path / "recorded", 1)
    whole, first = read_for_processing(recorded), session.path / "run-0001.h5"
    with RunWriter(first, whole.digitisation, started_at="", setup_toml=dump_setup(JOINT)) as writer:
        # the joint estimate takes longest over the last small bounces
        writer.write(Block(whole.raw[:, :1500], 0))
    second = Path(shutil.copy(first, session.path / "run-0002.h5"))
    write_results(first, found(first))
    return first, second


def found(path: Path) -> RunResult:
    result = process(read_for_processing(path), SETUP)
    assert result.corrected is not None
    constants = {"gain_ratio": 1.0, "u_gain_ratio": 1e-3, "quadrature_error_deg": 0.0, "u_quadrature_error_deg": 0.1}
    channels = tuple(ChannelQuality(channel.name, **constants) for channel in result.corrected.channels)
    return replace(result, setup=JOINT, corrected=replace(result.corrected, method="joint", channels=channels))


def test_a_run_just_recorded_is_given_the_runs_before_it_and_a_batch_keeps_that(runs: tuple[Path, Path]) -> None:
    result, _ = process_finished(FinishedJob(runs[1], JOINT, 0, None), lambda _: None, lambda _: None)
    had = result.front_end_prior
    assert had is not None
    assert had.runs == ("run-0001",)
    assert read_prior(runs[1], JOINT) == had
    # before the first there is none
    assert known_front_ends(runs[0], JOINT) is None
    # whoever of a batch ends first: what a result had stays its prior
    assert work_on(BatchTask(runs[1], JOINT, {"processing.geometry": "plane"})).state == "done"
    kept = read_prior(runs[1])
    assert kept is not None
    assert (kept.runs, kept.front_ends) == (had.runs, had.front_ends)
