"""What the report's runs say to the statistics of a series: facts of runs in, findings out."""

from collections.abc import Sequence
from pathlib import Path

from radargui.report.run_section import RunFacts
from radargui.restitution.findings import Findings, SeriesRun, SeriesSession, findings_of
from radargui.restitution.speed_models import ModelName
from radargui.session.info import SessionInfo


def report_findings(
    sessions: Sequence[tuple[SessionInfo, Sequence[RunFacts]]], model: ModelName | None = None
) -> Findings:
    """Return what sessions found, each given by its record and the facts of its runs.

    Parameters
    ----------
    sessions
        One or several; of two with one name the second gets a number.
    model
        The dependence of e on the speed that the user chose; None: all are shown.
    """
    names: list[str] = []
    for info, _ in sessions:
        taken = sum(name.partition(" (")[0] == info.name for name in names)
        names.append(f"{info.name} ({taken + 1})" if taken else info.name)
    return findings_of([_session(name, *one) for name, one in zip(names, sessions, strict=True)], model)


def _session(name: str, info: SessionInfo, runs: Sequence[RunFacts]) -> SeriesSession:
    set_aside = {Path(run).stem: reason for run, reason in info.rejected.items()}
    return SeriesSession(name, info.setup, tuple(map(_run, runs)), set_aside, info.sample, info.target)


def _run(run: RunFacts) -> SeriesRun:
    impacts, budget = run.bounces.impacts, run.uncertainty_budget
    return SeriesRun(run.drop, run.status, run.failure or run.reason, run.preliminary, impacts, budget)
