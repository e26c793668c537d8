"""One run of an experiment."""

from __future__ import annotations

from radargui.experiment.event import RecordedRun
from radargui.experiment.series import Experiment


def record_run(experiment: Experiment) -> RecordedRun:
    """Record one run, process it and save its results; the last one, where others were set aside before it."""
    return list(experiment.record(1))[-1]
