"""The figures of a series for other programs: CSV of impacts, CSV of statistics, JSON of everything."""

import csv
import io
from collections.abc import Iterable, Iterator, Sequence

from radargui import __version__
from radargui.geometry.antennas import place_antennas
from radargui.geometry.plane_wave import condition_number, t_matrix
from radargui.report.run_facts import RunFacts
from radargui.report.tables import free_fall_document, number
from radargui.restitution.series import Statistics, series_of
from radargui.session.info import SessionInfo

IMPACT_HEADER = (
    "run",
    "verdict",
    "impact",
    "time_s",
    "time_from_zero_s",
    "speed_before_m_s",
    "speed_after_m_s",
    "e",
    "u_e",
    "u_e_combined",
    "valid",
    "method",
    "drop_height_m",
    "g_m_s2",
    "u_g_m_s2",
    "source",
    "reason",
)
SERIES_HEADER = ("quantity", "n", "mean", "standard_error", "standard_deviation", "u_combined")
_LEAST_RECEIVERS = 3
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")


def safe_cell(text: str) -> str:
    """Return a text that no spreadsheet takes for a formula: an apostrophe is put before one."""
    return "'" + text if text.lstrip(" ").startswith(_FORMULA) else text


def impacts_csv(runs: Sequence[RunFacts]) -> bytes:
    """Return one row an impact of each run; a run without impact has one row in which these columns are nan."""
    return _csv(IMPACT_HEADER, (row for run in runs for row in _impact_rows(run)))


def series_csv(runs: Sequence[RunFacts]) -> bytes:
    """Return the statistics of the series, one row a quantity."""
    rows = (
        [
            name,
            str(found.n),
            *map(_number, (found.mean, found.standard_error, found.standard_deviation, found.combined)),
        ]
        for name, found in _statistics(runs).items()
    )
    return _csv(SERIES_HEADER, rows)


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
        "condition_number": condition_number(antennas) if info.setup.n_receivers >= _LEAST_RECEIVERS else None,
        "series": _statistics(runs),
        "series_kind": series.kind,
        "left_out_of_series": series.left_out,
        "runs": [_run_document(run) for run in runs],
    }


def _statistics(runs: Sequence[RunFacts]) -> dict[str, Statistics]:
    series = series_of([run.drop for run in runs])
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


def _impact_rows(run: RunFacts) -> Iterator[list[str]]:
    keys = ("drop_height_m", "g_m_s2", "u_g_m_s2")
    tail = [*(_number(run.figure(key)) for key in keys), run.source.kind, safe_cell(run.failure or run.reason)]
    begin = [safe_cell(run.name), safe_cell(run.verdict)]
    if not run.bounces.impacts:
        yield [*begin, "", *["nan"] * 7, "", "", *tail]
    for place, impact in enumerate(run.bounces.impacts, 1):
        times = (impact.time_s, impact.time_s - run.zero_s)
        speeds = (impact.speed_before_m_s, impact.speed_after_m_s)
        figures = (*times, *speeds, impact.e, impact.u_e, impact.u_e_combined)
        cells = [*map(_number, figures), str(int(impact.valid)), safe_cell(impact.method)]
        yield [*begin, str(place), *cells, *tail]


def _number(value: float | None) -> str:
    return "nan" if value is None else number(value)


def _csv(header: Iterable[str], rows: Iterable[Sequence[str]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue().encode(errors="replace")
