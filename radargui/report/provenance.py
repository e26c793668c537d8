"""Collect where a session's numbers come from: programs, settings, calibration, files and their changes."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from radargui.files.access import reading, sha256_of
from radargui.files.hdf5 import text
from radargui.files.run_card import read_health, read_origin, read_run_card
from radargui.files.run_file import opened_run, read_gaps, read_run_setup
from radargui.files.stored_results import StoredResult, read_stored_results
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup, dump_setup
from radargui.model.setup_error import changed_settings
from radargui.report.run_facts import RunFacts, in_session
from radargui.session.info import versions
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
            _run(path, session, runs.get(path.stem, RunFacts(path.stem)))
            for path in session.run_paths(with_rejected=True)
        ),
    )


_SOURCES = {"measured": "device", "simulated": "simulation", "replay": "replay", "unknown": ""}


def _run(path: Path, session: Session, facts: RunFacts) -> RunProvenance:
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
