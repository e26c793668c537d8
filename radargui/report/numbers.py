"""Write the report for programs: JSON (report.schema.json documents each key), CSV, LaTeX tables, BibTeX.

Write what a paper takes over: the methods paragraph, LaTeX tables (booktabs) and the BibTeX entry.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path

from radargui import __version__
from radargui.files.access import write_whole
from radargui.model.recording import Gap
from radargui.model.result import Bounce
from radargui.model.rounding import alone, concise, plain
from radargui.physics.path_length import MIN_RECEIVERS, condition_number, place_antennas, t_matrix
from radargui.report.content import templates
from radargui.report.facts import Provenance, ReportFacts, SessionFacts, fit_cells, session_cells
from radargui.report.run_facts import RunFacts
from radargui.report.tables import csv_bytes, free_fall_document, json_bytes
from radargui.restitution.dependence import Dependence
from radargui.restitution.findings import SampleFindings, SessionFindings
from radargui.restitution.series import Series
from radargui.restitution.speed_models import preferred, speed_model, title_of
from radargui.restitution.statistics import OUTLIER_RULE, Consistency, Statistics
from radargui.session.info import SessionInfo


def methods(facts: ReportFacts) -> str:
    """Return the paragraph; what differs between sessions is said of each."""
    found = facts.findings
    pairs = list(zip(found.sessions, facts.sessions, strict=True))
    ways: dict[str, list[str]] = {}
    for one, session in pairs:
        ways.setdefault(_followed(session), []).append(one.name)
    fits = [fit for one in found.samples if found.model and (fit := one.fit(found.model)).parameters]
    return _paragraph(
        "methods.txt",
        pairs=pairs,
        ways=ways,
        most=max(one.series.e.n for one in found.sessions),
        combined=any(one.series.e.combined is not None for one in found.sessions),
        outlier_rule=OUTLIER_RULE,
        model=found.model and speed_model(found.model),
        how=_each(fit.u_from for fit in fits),
        version=__version__,
    )


def _followed(session: SessionFacts) -> str:
    """Return how its motion was measured and computed."""
    setup, used = session.info.setup, [run for run in session.runs if run.status == "ok"]
    return _paragraph(
        "followed.txt",
        radar=setup.radar,
        n=setup.n_receivers,
        rates=_each(f"{run.rate_hz:g}" for run in used if run.rate_hz),
        used=used,
        each=lambda words, runs, key: _each(words.get(getattr(run, key), "") for run in runs),
    )


def _paragraph(name: str, **facts: object) -> str:
    """Return a template with its lines, one sentence each, as one paragraph."""
    lines = templates().get_template(name).render(plain=plain, **facts).splitlines()
    return " ".join(filter(None, map(str.strip, lines)))


def _each(values: Iterable[str]) -> str:
    """Return the values that occur, the most frequent first, as one phrase."""
    return " or ".join(value for value, _ in Counter(filter(None, values)).most_common())


_SPECIAL = {
    **{character: f"\\{character}" for character in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    "–": "--",
    "±": r"$\pm$",
    "°": r"$^\circ$",
    "χ": r"$\chi$",
    "²": r"$^2$",
    "·": r"$\cdot$",
}


def escaped(text: str) -> str:
    """Return a text on one line in which nothing is a command."""
    one_line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return "".join(_SPECIAL.get(character, character) for character in one_line)


_MINUS, _POWER = re.compile(r"(?<![\w)])-(?=\d)"), re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]\d+)(?![\w.])")


_Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]
"""Caption, header and rows."""


def typeset(cell: str) -> str:
    """Return a cell of a table: escaped, its numbers with a minus and powers of ten as papers print them."""
    shown = _MINUS.sub("$-$", escaped(cell))
    return _POWER.sub(lambda found: rf"{found[1]} $\times 10^{{{int(found[2])}}}$", shown)


def latex_tables(facts: ReportFacts) -> str:
    """Return the tables of a report, one below the other."""
    found = facts.findings
    tables = [
        (
            "Coefficient of restitution of the first impact",
            ("session", "fell on", "$n$", "$h$ / mm", "$v$ / (m/s)", "$e$", "$s$", "$s/\\sqrt{n}$", "$g$ / (m/s$^2$)"),
            [[cell for title, cell in session_cells(one).items() if title != "χ²/ν"] for one in found.sessions],
        ),
        *map(_fits, found.samples),
        *(_runs(name.name, one) for name, one in zip(found.sessions, facts.sessions, strict=True)),
    ]
    text = templates().get_template("tables.tex").render(tables=tables, typeset=typeset, version=__version__)
    return f"{text}\n"


def _fits(sample: SampleFindings) -> _Table:
    rows = [
        (
            title_of(fit.model),
            "; ".join(f"{one.name} = {concise(one.value, one.u_combined or one.u, one.unit)}" for one in fit.parameters)
            or fit.problem,
            *fit_cells(fit).values(),
            plain(fit.aicc, 5),
        )
        for fit in sample.fits
    ]
    of = f" of {escaped(sample.label)}" if sample.label else ""
    header = ("model", "parameters", "$\\chi^2$", "degrees of freedom", "$p$", "AICc")
    return f"Dependence of $e$ on the impact speed{of}", header, rows


def _runs(name: str, session: SessionFacts) -> _Table:
    rows = [
        (
            run.name,
            str(number),
            f"{impact.time_s - run.zero_s:.5f}",
            plain(impact.speed_before_m_s, 5),
            concise(impact.e, impact.u_stated),
            # the uncertainty is that of e: as in the report these only end at its decimal
            alone(impact.e_flight_time, impact.u_stated),
            alone(impact.e_height, impact.u_stated),
            "yes" if impact.valid else "no",
        )
        for run in session.runs
        for number, impact in enumerate(run.bounces.impacts, 1)
    ]
    header = ("run", "impact", "$t$ / s", "$v$ / (m/s)", "$e$", "$e$ of flight time", "$e$ of height", "valid")
    since = " or ".join(dict.fromkeys(run.since for run in session.runs))
    return f"Impacts of {escaped(name)}, times from {since}", header, rows


def bibtex(facts: ReportFacts) -> str:
    """Return one entry a session, and one of the program."""
    # BibTeX counts braces that LaTeX would only print
    plain_braces = str.maketrans("{}", "()")
    text = (
        templates()
        .get_template("references.bib")
        .render(
            sessions=[(found.name, one) for found, one in zip(facts.findings.sessions, facts.sessions, strict=True)],
            in_braces=lambda text: escaped(text.translate(plain_braces)),
            made_at=facts.made_at,
            version=__version__,
        )
    )
    return f"{text}\n"


FILES = ("report.csv", "report.json", "report-series.csv", "report.tex", "report.bib")
IMPACT_HEADER = (
    *("session", "run", "verdict", "impact", "time_s", "time_from_zero_s", "speed_before_m_s", "speed_after_m_s"),
    *("e", "u_e", "u_e_combined", "valid", "method", "drop_height_m", "g_m_s2", "u_g_m_s2", "source", "reason"),
    *("e_flight_time", "e_height", "x_m", "y_m", "z_m", "u_position_m", "u_speed_before_m_s", "u_speed_after_m_s"),
    *("angle_deg", "u_angle_deg", "vt_before_m_s", "vt_after_m_s", "e_t", "u_e_t", "mu", "u_mu"),
    *("e_times", "u_e_times"),
)
SERIES_HEADER = (
    *("session", "quantity", "n", "mean", "standard_error", "standard_deviation", "u_combined", "interval_low"),
    *("interval_high", "expanded", *(one.name for one in fields(Consistency))),
)


def write_numbers(facts: ReportFacts, folder: Path) -> None:
    """Write `FILES` into a folder; those there are replaced, each in one step.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    contents = (
        impacts_csv(facts),
        json_bytes(report_document(facts)),
        series_csv(facts),
        latex_tables(facts).encode(errors="replace"),
        bibtex(facts).encode(errors="replace"),
    )
    for name, content in zip(FILES, contents, strict=True):
        write_whole(folder / name, [content])


def impacts_csv(facts: ReportFacts) -> bytes:
    """Return one row an impact of each run; a run without impact has one row in which these columns are nan."""
    pairs = zip(facts.findings.sessions, facts.sessions, strict=True)
    rows = (row for found, one in pairs for run in one.runs for row in _impact_rows(found.name, run))
    return csv_bytes(IMPACT_HEADER, rows)


def series_csv(facts: ReportFacts) -> bytes:
    """Return the statistics of each session, one row a quantity."""
    return csv_bytes(
        SERIES_HEADER,
        (
            {"session": found.name, "quantity": name, **asdict(one), "u_combined": one.combined, **consistency}
            for found in facts.findings.sessions
            for name, one in _statistics(found.series).items()
            for consistency in [asdict(one.consistency) if one.consistency else {}]
        ),
    )


def report_document(facts: ReportFacts) -> dict[str, object]:
    """Return all that the report says in numbers, for JSON: of one session its keys stand beside the common ones."""
    findings = facts.findings
    sessions = [_session_document(found, one) for found, one in zip(findings.sessions, facts.sessions, strict=True)]
    return {
        "format": "radargui-report",
        "format_version": 1,
        "version": __version__,
        "made_at": facts.made_at,
        "sentence": findings.sentence,
        "methods": methods(facts),
        "bibtex": bibtex(facts),
        **(sessions[0] if len(sessions) == 1 else {"sessions": sessions}),
        "speed_model": findings.model,
        "samples": [
            {
                **asdict(one),
                "preferred": [fit.model for fit in preferred(one.fits)],
                "dependences": [_dependence_document(each) for each in one.dependences],
            }
            for one in findings.samples
        ],
        "sessions_compared": findings.sessions_compared,
        "samples_compared": findings.samples_compared,
        "cautions": findings.cautions,
    }


def _dependence_document(one: Dependence) -> dict[str, object]:
    """Return a slope of e; the impacts are in the runs already."""
    return {key: value for key, value in asdict(one).items() if key not in ("impacts", "e")} | {"n": len(one.impacts)}


def _session_document(found: SessionFindings, one: SessionFacts) -> dict[str, object]:
    info, series = one.info, found.series
    antennas = place_antennas(info.setup)
    return {
        "name": found.name,
        "session_sentence": found.sentence,
        "session": info.model_dump(mode="json", exclude={"setup"}),
        "setup": info.setup,
        "t_matrix": t_matrix(antennas),
        "condition_number": condition_number(antennas) if info.setup.n_receivers >= MIN_RECEIVERS else None,
        "series": _statistics(series),
        "distribution": found.distribution,
        "series_kind": series.kind,
        "series_runs": series.seen,
        "left_out_of_series": series.left_out,
        "excluded": found.excluded,
        "preliminary": found.preliminary,
        "outliers": series.outliers,
        "outlier_rule": OUTLIER_RULE,
        "e_budget": found.e_budget,
        "g_budget_m_s2": found.g_budget_m_s2,
        "site": found.site and {**asdict(found.site), "verdict": found.site.verdict},
        "runs": [_run_document(run) for run in one.runs],
        "provenance": one.provenance and _provenance_document(info, one.provenance),
    }


def _provenance_document(info: SessionInfo, found: Provenance) -> dict[str, object]:
    return {
        "session": info.name,
        **{key: getattr(info, key) for key in ("created_at", "operator", "sample", "target", "notes")},
        "recorded_with": info.versions,
        "reported_with": found.reported_with,
        "reported_at": found.reported_at,
        "setup_name": info.setup_name,
        "calibration_origin": info.calibration.origin,
        "calibration_made_at": info.calibration.made_at,
        "assumed": found.assumed,
        "runs": found.runs,
    }


def _statistics(series: Series) -> dict[str, Statistics]:
    return {
        "e_first_bounce": series.e,
        "g_m_s2": series.g_m_s2,
        "drop_height_m": series.drop_height_m,
        "impact_speed_m_s": series.impact_speed_m_s,
    }


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
        "bounces": [_from_zero(run, impact) for impact in run.bounces.impacts],
        "free_fall": _fall_document(run),
        "channels": [channel.document() for channel in run.channels],
        "decisions": run.decisions,
        "uncertainty_budget": run.uncertainty_budget,
        "gaps": [_gap_document(run, gap) for gap in run.gaps],
        "warnings": run.warnings,
    }


def _fall_document(run: RunFacts) -> dict[str, object] | None:
    if (fall := run.bounces.free_fall) is None:
        return None
    ends = {"first": fall.first_time_s, "last": fall.last_time_s}
    since_zero = {f"{end}_time_from_zero_s": time_s - run.zero_s for end, time_s in ends.items()}
    return since_zero | free_fall_document(fall, run.site_check)


def _gap_document(run: RunFacts, gap: Gap) -> dict[str, object]:
    since = gap.first_index / run.rate_hz - run.zero_s if run.rate_hz else None
    return {"time_from_zero_s": since, **asdict(gap)}


def _from_zero(run: RunFacts, impact: Bounce) -> dict[str, object]:
    return {"time_from_zero_s": impact.time_s - run.zero_s, **asdict(impact)}


def _impact_rows(session: str, run: RunFacts) -> Iterator[dict[str, object]]:
    of_run = {"session": session, "run": run.name, "verdict": run.verdict, "source": run.source.kind}
    of_fall = {key: run.figure(key) for key in ("drop_height_m", "g_m_s2", "u_g_m_s2")}
    row: dict[str, object] = {**of_run, **of_fall, "reason": run.failure or run.reason}
    if not run.bounces.impacts:
        yield {**row, "impact": "", "valid": "", "method": ""}
    for place, impact in enumerate(run.bounces.impacts, 1):
        yield {**row, "impact": place, **_from_zero(run, impact)}
