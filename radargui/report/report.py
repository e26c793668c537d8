"""The report of a session: PDF, HTML, CSV and JSON."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from pathlib import Path

from radargui import __version__
from radargui.files.access import Progress, fresh_files, write_whole
from radargui.geometry.path_length import condition_number, place_antennas, t_matrix
from radargui.model.drop import RunOrigin
from radargui.processing.locate import LEAST_RECEIVERS
from radargui.report.document import Document
from radargui.report.rendering import render
from radargui.report.run_section import ResultOf, RunFacts, all_simulated, run_section, study
from radargui.report.session_section import session_section
from radargui.report.tables import csv_bytes, free_fall_document, json_bytes
from radargui.restitution.series import Series, drop_labels, series_of
from radargui.restitution.statistics import Statistics
from radargui.session.info import REPORT_FOLDER, SessionInfo, own_subfolder
from radargui.session.session import BY_OPERATOR, Session

_READING_SHARE = 0.5


@dataclass(frozen=True, slots=True)
class Report:
    """Where the report is.

    Attributes
    ----------
    pdf, html, json
        The report for people, on paper and on the screen, and for programs.
    csv
        One row an impact of each run.
    series_csv
        Statistics of the series.
    """

    pdf: Path
    html: Path
    csv: Path
    json: Path
    series_csv: Path


def write_report(
    session: Session,
    result_of: ResultOf,
    output: Path | None = None,
    progress: Progress | None = None,
    *,
    now: datetime | None = None,
) -> Report:
    """Write what all runs of a session give with its setup.

    Parameters
    ----------
    session
        A run of it that cannot be read or processed gets a section that says why.
    result_of
        Gives the result of each run, see `study`.
    output
        Folder of the report's files, which are replaced there; the session's own `report` folder where left out.
    progress
        Called with the share done, 0 to 1.
    now
        Date and time of the report with offset from UTC; the clock's where left out.

    Raises
    ------
    FileError
        The folder cannot be written.
    SessionError
        The session's own report folder is a link out of the session.
    """
    report_progress = progress or (lambda _: None)
    folder = output or own_subfolder(session.path, REPORT_FOLDER)
    made_at = (now or datetime.now().astimezone()).isoformat(sep=" ", timespec="seconds")
    names = ("report.pdf", "report.html", "report.csv", "report.json", "report-series.csv")
    report = Report(*(folder / name for name in names))
    runs = _study_all(session, result_of, report_progress)
    write_whole(report.csv, [impacts_csv(runs)])
    write_whole(report.series_csv, [series_csv(runs)])
    write_whole(report.json, [json_bytes(session_document(session.info, runs, made_at))])
    with fresh_files((report.pdf, report.html), force=True) as (pdf, html):
        render(
            compose(session.info, runs, made_at),
            pdf,
            html,
            lambda share: report_progress(_READING_SHARE + (1.0 - _READING_SHARE) * share),
        )
    report_progress(1.0)
    return report


def _study_all(session: Session, result_of: ResultOf, report_progress: Progress) -> list[RunFacts]:
    paths = session.run_paths()
    runs = []
    for number, path in enumerate(paths):

        def part(done: float, number: int = number) -> None:
            report_progress(_READING_SHARE * (number + done) / len(paths))

        runs.append(study(path, session.setup, result_of, part))
        part(1.0)
    labels = _labels(session, {run.name: run.source for run in runs})
    return [replace(run, label=labels[run.name]) for run in runs]


def _labels(session: Session, origins: dict[str, RunOrigin]) -> dict[str, str]:
    """Return what the drops are called, also with those in mind that were rejected and keep their number."""
    rejected = session.rejected
    return drop_labels(
        (path.stem, origins.get(path.stem), rejected.get(path.name, BY_OPERATOR) == BY_OPERATOR)
        for path in session.run_paths(with_rejected=True)
    )


def compose(info: SessionInfo, runs: Sequence[RunFacts], made_at: str) -> Document:
    """Return the report of a session: session and setup, then one section a run.

    Parameters
    ----------
    info
        The session's record.
    runs
        In the order of their numbers.
    made_at
        Date and time of the report, for people.
    """
    sections = (session_section(info, runs, made_at), *(run_section(run, info.setup) for run in runs))
    # on the foot of every page
    mark = ", simulated" if all_simulated(runs) else ""
    return Document(f"RadarGUI report: {info.name}{mark}", info.operator, sections)


IMPACT_HEADER = (
    *("run", "verdict", "impact", "time_s", "time_from_zero_s", "speed_before_m_s", "speed_after_m_s"),
    *("e", "u_e", "u_e_combined", "valid", "method", "drop_height_m", "g_m_s2", "u_g_m_s2", "source", "reason"),
)
SERIES_HEADER = ("quantity", "n", "mean", "standard_error", "standard_deviation", "u_combined")


def impacts_csv(runs: Sequence[RunFacts]) -> bytes:
    """Return one row an impact of each run; a run without impact has one row in which these columns are nan."""
    return csv_bytes(IMPACT_HEADER, (row for run in runs for row in _impact_rows(run)))


def series_csv(runs: Sequence[RunFacts]) -> bytes:
    """Return the statistics of the series, one row a quantity."""
    found = _statistics(series_of([run.drop for run in runs]))
    return csv_bytes(
        SERIES_HEADER,
        ({"quantity": name, **asdict(one), "u_combined": one.combined} for name, one in found.items()),
    )


def session_document(info: SessionInfo, runs: Sequence[RunFacts], made_at: str) -> dict[str, object]:
    """Return all that the report says in numbers, for JSON."""
    antennas = place_antennas(info.setup)
    series = series_of([run.drop for run in runs])
    return {
        "version": __version__,
        "made_at": made_at,
        "session": info.model_dump(mode="json", exclude={"setup"}),
        "setup": info.setup,
        "t_matrix": t_matrix(antennas),
        "condition_number": condition_number(antennas) if info.setup.n_receivers >= LEAST_RECEIVERS else None,
        "series": _statistics(series),
        "series_kind": series.kind,
        "left_out_of_series": series.left_out,
        "runs": [_run_document(run) for run in runs],
    }


def _statistics(series: Series) -> dict[str, Statistics]:
    return {"e_first_bounce": series.e, "g_m_s2": series.g_m_s2, "drop_height_m": series.drop_height_m}


def _run_document(run: RunFacts) -> dict[str, object]:
    return {
        "name": run.name,
        "drop": run.label,
        "source": run.source.kind,
        "replay_of": run.source.file or None,
        "status": run.status,
        "reason": run.failure or run.reason or None,
        "verdict": run.verdict,
        "started_at": run.started_at or None,
        "duration_s": run.duration_s,
        "sample_rate_hz": run.rate_hz,
        "n_samples": run.n_samples,
        "device": run.device or None,
        "imported_from": run.origin or None,
        "correction_used": run.correction,
        "geometry_used": run.geometry,
        "zero_time_s": run.zero_s,
        "zero_is": run.since,
        "summary": run.figures,
        "bounces": run.bounces.impacts,
        "free_fall": free_fall_document(run.bounces.free_fall, run.site_check),
        "channels": run.channels,
        "uncertainty_budget": run.uncertainty_budget,
        "gaps": run.gaps,
        "warnings": run.warnings,
    }


def _impact_rows(run: RunFacts) -> Iterator[dict[str, object]]:
    of_run = {"run": run.name, "verdict": run.verdict, "source": run.source.kind, "reason": run.failure or run.reason}
    of_fall = {key: run.figure(key) for key in ("drop_height_m", "g_m_s2", "u_g_m_s2")}
    if not run.bounces.impacts:
        yield {**of_run, "impact": "", "valid": "", "method": "", **of_fall}
    for place, impact in enumerate(run.bounces.impacts, 1):
        since = {"impact": place, "time_from_zero_s": impact.time_s - run.zero_s}
        yield {**of_run, **since, **asdict(impact), **of_fall}
