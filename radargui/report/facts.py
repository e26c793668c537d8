"""Collect what a report says: runs, what was found in them, and what drawings of a series share.

Collect where a session's numbers come from: programs, settings, calibration, files and their changes.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from radargui.files.access import reading, sha256_of
from radargui.files.hdf5 import text
from radargui.files.run_card import read_health, read_origin, read_run_card
from radargui.files.run_file import opened_run, read_gaps, read_run_setup
from radargui.files.stored_results import StoredResult, read_stored_results
from radargui.model.arrays import FloatArray
from radargui.model.errors import RadarGuiError
from radargui.model.rounding import COVERAGE, UNKNOWN, plain
from radargui.model.setup import Setup, dump_setup
from radargui.model.setup_error import changed_settings
from radargui.report.run_facts import RunFacts, glance, in_session
from radargui.restitution.dependence import COVARIATES, Dependence
from radargui.restitution.distribution import Distribution
from radargui.restitution.findings import Findings, SeriesRun, SeriesSession, SessionFindings, findings_of
from radargui.restitution.speed_models import ModelName, SpeedFit, preferred
from radargui.restitution.statistics import probability
from radargui.session.info import SessionInfo, versions
from radargui.session.session import Session


@dataclass(frozen=True, slots=True)
class ProcessingPass:
    """One processing of a run: when, by which version, with which correction, and what e it gave.

    `settings_changed` holds settings that were not those of the session, as in `RunProvenance`.
    """

    processed_at: str
    version: str
    correction: str | None
    e: float | None
    is_present: bool
    settings_changed: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RunProvenance:
    """Where one run comes from.

    Attributes
    ----------
    name, file, size_bytes, sha256
        Of the run file as it was when the report was made. Processing stores results in it and changes it.
    samples_crc32
        CRC-32 of each channel's samples, which processing never changes, after their number: "n:crc:crc:...".
    source
        device, simulation, replay or file (imported).
    device
        What digitised: product and serial number; empty where not known.
    imported_from, replay_of
        File that the samples come from; empty for others.
    started_at, sample_rate_hz, n_samples
        Of the recording.
    n_gaps, n_lost, fraction_clipped
        Gaps, samples of each channel lost in them, largest share of a receiver's samples at the end of the range.
    recovered_at
        When a crash's run was finished; empty for others.
    set_aside
        Why it was set aside; empty where it counts.
    settings_changed
        Settings of the run that are not those of its session, as `key: session's -> run's`.
    markers
        The operator's notes.
    processings
        The oldest first; the present one is the last.
    health
        How the recording went, as stored with it.
    problem
        Why this could not be read; empty where it could.
    """

    name: str
    file: str
    size_bytes: int = 0
    sha256: str = ""
    samples_crc32: str = ""
    source: str = ""
    device: str = ""
    imported_from: str = ""
    replay_of: str = ""
    started_at: str = ""
    sample_rate_hz: float | None = None
    n_samples: int | None = None
    n_gaps: int = 0
    n_lost: int = 0
    fraction_clipped: float | None = None
    recovered_at: str = ""
    set_aside: str = ""
    settings_changed: tuple[str, ...] = ()
    markers: tuple[str, ...] = ()
    processings: tuple[ProcessingPass, ...] = ()
    health: Mapping[str, object] | None = None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where the numbers of one session come from.

    Attributes
    ----------
    reported_with, reported_at
        Program and libraries with their versions, and when, ISO 8601; what they were recorded with is in its record.
    assumed
        Uncertainties that the setup does not give, by key, and the values taken.
    runs
        Every run file, set aside or not.
    """

    reported_with: Mapping[str, str]
    reported_at: str
    assumed: Mapping[str, float]
    runs: tuple[RunProvenance, ...]


def provenance_of(session: Session, runs: Mapping[str, RunFacts], reported_at: str) -> Provenance:
    """Return where the numbers of a session come from; what cannot be read says so.

    Parameters
    ----------
    session
        Its files are read once more, for their checksums.
    runs
        What the report knows of its runs, by name; those set aside may be missing.
    reported_at
        Date and time of the report.
    """
    budgets = [run.uncertainty_budget for run in runs.values() if run.uncertainty_budget]
    return Provenance(
        versions(),
        reported_at,
        {key: u for budget in budgets for key, u in budget.assumed.items()},
        tuple(
            _run_provenance(path, session, runs.get(path.stem, RunFacts(path.stem)))
            for path in session.run_paths(with_rejected=True)
        ),
    )


_SOURCES = {"measured": "device", "simulated": "simulation", "replay": "replay", "unknown": ""}


def _run_provenance(path: Path, session: Session, facts: RunFacts) -> RunProvenance:
    set_aside = session.rejected.get(path.name, "")
    try:
        with reading(path, "a run file"):
            size, digest = path.stat().st_size, sha256_of(path)
        card, imported = read_run_card(path), read_origin(path)
        own = read_run_setup(path)
        with opened_run(path) as file:
            gaps, device = read_gaps(file, path), text(file.attrs, "device")
        of_card = ("started_at", "sample_rate_hz", "n_samples", "recovered_at", "markers")
        clipped = [one.fraction_clipped for one in facts.channels if one.fraction_clipped is not None]
        return RunProvenance(
            path.stem,
            path.name,
            size,
            digest,
            card.origin.samples,
            "file" if imported else _SOURCES[card.origin.kind],
            device,
            imported,
            card.origin.file,
            **{key: getattr(card, key) for key in of_card},
            n_gaps=len(gaps),
            n_lost=sum(gap.count for gap in gaps),
            fraction_clipped=max(clipped, default=None),
            set_aside=set_aside,
            settings_changed=() if own is None else tuple(map(str, changed_settings(session.setup, own))),
            processings=tuple(_processing(one, session.setup) for one in read_stored_results(path)),
            health=read_health(path),
        )
    except RadarGuiError as error:
        return RunProvenance(path.stem, path.name, set_aside=set_aside, problem=in_session(path, error))


def _processing(one: StoredResult, setup: Setup) -> ProcessingPass:
    correction, e = one.summary.get("correction"), one.summary.get("e")
    own = None if one.setup_toml == dump_setup(setup) else one.setup
    return ProcessingPass(
        one.processed_at,
        one.version,
        str(correction) if correction else None,
        e if isinstance(e, float) else None,
        one.is_present,
        () if own is None else tuple(map(str, changed_settings(setup, own))),
    )


_COLOURS, _MARKS = 4, 5
MAX_LOOKS = _COLOURS * _MARKS
"""Sessions that look different where a series is drawn."""


def session_look(number: int) -> tuple[int, int]:
    """Return which colour and which mark a session of several has; neighbours differ in both."""
    return number % _COLOURS, number % _MARKS


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
    return SeriesRun(run.drop, run.status, run.failure or run.reason, impacts, budget)


class Glances:
    """Remembers what was read; for threads of work."""

    def __init__(self) -> None:
        self._known: dict[Path, tuple[int, RunFacts]] = {}

    def session_facts(self, session: Session) -> SessionFacts:
        """Return what a session found, without samples and without where it comes from."""
        return SessionFacts(session.info, tuple(self._facts(path, session) for path in session.run_paths()))

    def _facts(self, path: Path, session: Session) -> RunFacts:
        changed = path.stat().st_mtime_ns if path.exists() else 0
        known = self._known.get(path)
        if known is None or known[0] != changed:
            known = self._known[path] = changed, glance(path, session.setup.floor.normal)
        return known[1]


WORST_SHARE, _GOOD_SHARE = 0.1, 0.01
"""Of e: an e that is known to no better than the first is not drawn; the second decide how far the axis reaches."""
_MARGIN = 0.1
"""Of the range of e, left free above and below (chosen by hand)."""


def speed_points(runs: Sequence[RunFacts]) -> FloatArray:
    """Return speed before, e and its statistical u of the valid impacts, shape (3, n)."""
    found = [
        (impact.speed_before_m_s, impact.e, impact.u_e)
        for run in runs
        for impact in run.bounces.impacts
        if impact.valid and math.isfinite(impact.e) and impact.u_e < WORST_SHARE * impact.e
    ]
    return np.array(found, np.float64).reshape(-1, 3).T


def dependences_on(facts: ReportFacts, on: str) -> list[Dependence]:
    """Return for each sample whose impacts tell it how e depends on something, among `COVARIATES`."""
    every = [one for sample in facts.findings.samples for one in sample.dependences if one.on == on]
    return [one for one in every if not one.problem]


def points_of(found: Dependence) -> FloatArray:
    """Return what e may depend on, e and its statistical u of the impacts that tell it, shape (3, n), to be drawn."""
    e, u = np.array(found.e), found.u
    return np.stack([found.x, e, u])[:, (u < WORST_SHARE * e) | (COVARIATES[found.on].of != "e")]


def e_label(found: Sequence[Dependence]) -> str:
    """Return what is drawn of dependences: e_t, or e, at which speed where all of them were brought to one."""
    speeds = {one.reduced.partition(" (")[0] for one in found}
    return (
        f"{COVARIATES[found[0].on].of} {speeds.pop()}".strip()
        if len(speeds) == 1
        else "e, each sample at its mean speed"
    )


def histogram_of(found: Distribution) -> tuple[FloatArray, FloatArray]:
    """Return the outline of a histogram as a density, from left to right, each shape (m,)."""
    edges, counts = np.array(found.edges), np.array(found.counts, np.float64)
    height = counts / (found.n * np.diff(edges))
    return np.repeat(edges, 2), np.concatenate([[0.0], np.repeat(height, 2), [0.0]])


def shown_fits(facts: ReportFacts) -> list[SpeedFit]:
    """Return for each sample the model that the user chose, else the one that describes it best."""
    found = facts.findings
    fits = [
        sample.fit(found.model) if found.model else next(iter(preferred(sample.fits)), None) for sample in found.samples
    ]
    return [fit for fit in fits if fit is not None and fit.parameters]


def e_span(points: FloatArray) -> tuple[float, float]:
    """Return lowest and highest e drawn, for `speed_points` that are not empty: as far as the good ones reach."""
    known = points[:, points[2] < _GOOD_SHARE * points[1]]
    _, e, u = known if known.size else points
    low, high = float((e - COVERAGE * u).min()), float((e + COVERAGE * u).max())
    room = _MARGIN * (high - low) or 0.5 * abs(high) or 1.0
    return low - room, high + room


def session_cells(found: SessionFindings) -> dict[str, str]:
    """Return what is said of a session on one line, by the title of its column: e with combined u, s of one drop."""
    series, e = found.series, found.series.e
    return {
        "session": found.name,
        "fell on": found.label or UNKNOWN,
        "n": str(e.n),
        "height / mm": plain(series.drop_height_m.mean, 4, scale=1e3),
        "speed / (m/s)": plain(series.impact_speed_m_s.mean, 4),
        "e": e.brief(),
        "s": plain(e.standard_deviation, 2),
        "s/√n": plain(e.standard_error, 2),
        "χ²/ν": UNKNOWN if e.consistency is None else plain(e.consistency.birge_ratio**2, 2),
        "g / (m/s²)": series.g_m_s2.brief(),
    }


def fit_cells(fit: SpeedFit) -> dict[str, str]:
    """Return how well a model describes e against the speed."""
    p = UNKNOWN if fit.p is None else probability(fit.p).removeprefix("= ")
    return {"χ²": plain(fit.chi2, 3), "ν": str(fit.degrees_of_freedom or UNKNOWN), "p": p}


def mean_gravity(runs: Sequence[RunFacts]) -> float:
    """Return the mean of g over the runs whose fall is drawn, in m/s^2; of one parabola for all."""
    g = [run.bounces.free_fall.g_m_s2 for run in runs if run.falls is not None and run.bounces.free_fall is not None]
    return sum(g) / len(g)
