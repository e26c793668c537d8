"""Runs of a session processed in order: each begins with what those before it found out about the front ends."""

from __future__ import annotations

import shutil
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from support.changed import changed
from support.stored_runs import SETUP, store_runs

from radargui.experiment.batch.task import BatchTask, work_on
from radargui.experiment.finished import FinishedJob, process_finished
from radargui.experiment.reprocess import process_run
from radargui.files.run_results import write_results
from radargui.files.stored_front_ends import read_prior
from radargui.model.quality import ChannelQuality
from radargui.model.result import RunResult
from radargui.processing.long_recording import read_for_processing
from radargui.processing.offline import process
from radargui.session.session import Session

JOINT = changed(SETUP, processing={"correction": "joint"})


def found_perfect(path: Path) -> RunResult:
    """Return a result of a run that found its front ends without error, as they are, by the joint correction."""
    result = process(read_for_processing(path), SETUP)
    assert result.corrected is not None
    channels = tuple(
        ChannelQuality(
            channel.name, gain_ratio=1.0, quadrature_error_deg=0.0, u_gain_ratio=1e-3, u_quadrature_error_deg=0.1
        )
        for channel in result.corrected.channels
    )
    return replace(result, setup=JOINT, corrected=replace(result.corrected, method="joint", channels=channels))


def test_the_second_run_has_the_first_as_prior_and_a_batch_keeps_it(tmp_path: Path) -> None:
    session = Session.create(tmp_path, JOINT, now=datetime(2026, 11, 20, tzinfo=UTC))
    runs = store_runs(tmp_path / "recorded", 2)
    first, second = (Path(shutil.copy(run, session.path / run.name)) for run in runs)
    write_results(first, found_perfect(first))
    result, _ = process_finished(FinishedJob(second, JOINT, 0, None), lambda _: None, lambda _: None)
    prior = result.front_end_prior
    assert prior is not None
    assert prior.used
    assert prior.runs == ("run-0001",)
    assert prior.front_ends[1].gain_ratio == 1.0
    assert result.corrected is not None
    assert result.corrected.channels[2].prior_runs == ("run-0001",)
    assert read_prior(second, JOINT) == prior
    assert process_run(second, JOINT).front_end_prior == prior
    # what stands in the first run from now on must not change the second, whoever ends first
    process_run(first, changed(JOINT, processing={"correction": "published"}))
    assert work_on(BatchTask(second, JOINT, force=True)).state == "done"
    assert read_prior(second) == prior
