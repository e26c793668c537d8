"""What a report is made of: records and runs of one or several sessions, what they found, where it comes from."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from radargui.report.provenance import Provenance
from radargui.report.run_facts import RunFacts
from radargui.restitution.findings import Findings, SeriesRun, SeriesSession, findings_of
from radargui.restitution.speed_models import ModelName
from radargui.session.info import SessionInfo


@dataclass(frozen=True, slots=True)
class SessionFacts:
    """One session: its record, its runs in the order of their numbers (without those set aside), its provenance.

    Where it comes from is left out of a page that says only what was found.
    """

    info: SessionInfo
    runs: tuple[RunFacts, ...] = field(repr=False)
    provenance: Provenance | None = field(default=None, repr=False)


@dataclass(frozen=True, slots=True)
class ReportFacts:
    """All that a report says: `findings.sessions` are in the order of `sessions`."""

    sessions: tuple[SessionFacts, ...]
    findings: Findings
    made_at: str


def report_facts(sessions: Sequence[SessionFacts], made_at: str, model: ModelName | None = None) -> ReportFacts:
    """Return what sessions found.

    Parameters
    ----------
    sessions
        One or several; of those with one name the second and further get a number.
    made_at
        Date and time of the report.
    model
        The dependence of e on the speed that the user chose; None: all are shown.
    """
    names: list[str] = []
    for one in sessions:
        taken = sum(known.partition(" (")[0] == one.info.name for known in names)
        names.append(f"{one.info.name} ({taken + 1})" if taken else one.info.name)
    found = findings_of([_session(name, one) for name, one in zip(names, sessions, strict=True)], model)
    return ReportFacts(tuple(sessions), found, made_at)


def _session(name: str, one: SessionFacts) -> SeriesSession:
    info = one.info
    set_aside = {Path(run).stem: reason for run, reason in info.rejected.items()}
    return SeriesSession(name, info.setup, tuple(map(_run, one.runs)), set_aside, info.sample, info.target)


def _run(run: RunFacts) -> SeriesRun:
    impacts, budget = run.bounces.impacts, run.uncertainty_budget
    return SeriesRun(run.drop, run.status, run.failure or run.reason, run.preliminary, impacts, budget)
