"""Tables for LaTeX (booktabs and longtable) and the BibTeX entry; operators' text stays text."""

from collections.abc import Sequence

from radargui import __version__
from radargui.model.rounding import concise, plain
from radargui.report.facts import ReportFacts, SessionFacts
from radargui.restitution.findings import SampleFindings, SessionFindings
from radargui.restitution.speed_models import MODELS
from radargui.restitution.statistics import probability

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


def latex_tables(facts: ReportFacts) -> str:
    """Return the tables of a report, one below the other."""
    found = facts.findings
    tables = [
        "% Tables of RadarGUI "
        + __version__
        + r": \usepackage{booktabs, longtable}. In parentheses: standard uncertainty.",
        _table(
            "Coefficient of restitution of the first impact",
            ("session", "fell on", "$n$", "$h$ / mm", "$v$ / (m/s)", "$e$", "$s$", "$s/\\sqrt{n}$", "$g$ / (m/s$^2$)"),
            [_session_row(one) for one in found.sessions],
        ),
        *(_fits(one) for one in found.samples),
        *(_runs(name.name, one) for name, one in zip(found.sessions, facts.sessions, strict=True)),
    ]
    return "\n\n".join(tables) + "\n"


def _session_row(found: SessionFindings) -> tuple[str, ...]:
    series = found.series
    scatter = (plain(value, 2) for value in (series.e.standard_deviation, series.e.standard_error))
    return (
        found.name,
        found.label,
        str(series.e.n),
        plain(series.drop_height_m.mean, 4, scale=1e3),
        plain(series.impact_speed_m_s.mean, 4),
        series.e.brief(),
        *scatter,
        series.g_m_s2.brief(),
    )


def _fits(sample: SampleFindings) -> str:
    rows = [
        (
            MODELS[fit.model].title,
            "; ".join(f"{one.name} = {concise(one.value, one.u_combined or one.u, one.unit)}" for one in fit.parameters)
            or fit.problem,
            plain(fit.chi2, 3),
            str(fit.degrees_of_freedom or "–"),
            "–" if fit.p is None else probability(fit.p).removeprefix("= "),
            plain(fit.aicc, 5),
        )
        for fit in sample.fits
    ]
    of = f" of {escaped(sample.label)}" if sample.label else ""
    return _table(
        f"Dependence of $e$ on the impact speed{of}",
        ("model", "parameters", "$\\chi^2$", "degrees of freedom", "$p$", "AICc"),
        rows,
    )


def _runs(name: str, session: SessionFacts) -> str:
    rows = [
        (
            run.name,
            str(number),
            f"{impact.time_s - run.zero_s:.5f}",
            plain(impact.speed_before_m_s, 5),
            concise(impact.e, impact.u_stated),
            concise(impact.e_flight_time, impact.u_stated),
            concise(impact.e_height, impact.u_stated),
            "yes" if impact.valid else "no",
        )
        for run in session.runs
        for number, impact in enumerate(run.bounces.impacts, 1)
    ]
    header = ("run", "impact", "$t$ / s", "$v$ / (m/s)", "$e$", "$e$ of flight time", "$e$ of height", "valid")
    since = " or ".join(dict.fromkeys(run.since for run in session.runs))
    return _table(f"Impacts of {escaped(name)}, times from {since}", header, rows)


def _table(caption: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [" & ".join(map(escaped, row)) + r" \\" for row in rows]
    return "\n".join(
        (
            rf"\begin{{longtable}}{{{'l' * len(header)}}}",
            rf"\caption{{{caption}}} \\",
            r"\toprule",
            " & ".join(header) + r" \\",
            r"\midrule",
            r"\endhead",
            *lines,
            r"\bottomrule",
            r"\end{longtable}",
        )
    )


def bibtex(facts: ReportFacts) -> str:
    """Return one entry a session, and one of the program."""
    entries = [_entry(found.name, one) for found, one in zip(facts.findings.sessions, facts.sessions, strict=True)]
    program = (
        f"@software{{radargui,\n  title = {{RadarGUI}},\n  version = {{{__version__}}},\n"
        f"  year = {{{facts.made_at[:4]}}},\n}}"
    )
    return "\n\n".join((*entries, program)) + "\n"


def _entry(name: str, session: SessionFacts) -> str:
    info = session.info
    key = "".join(character if character.isascii() and character.isalnum() else "-" for character in name)
    fields = {
        "author": info.operator,
        "title": f"Particle-tracking radar session {name}",
        "year": info.created_at[:4],
        "note": f"{len(session.runs)} runs, recorded {info.created_at[:10]}, analysed with RadarGUI {__version__}",
    }
    # BibTeX counts braces that LaTeX would only print
    plain_braces = str.maketrans("{}", "()")
    lines = (
        f"  {field} = {{{escaped(text.translate(plain_braces))}}},\n" for field, text in fields.items() if text.strip()
    )
    return f"@misc{{radargui-{key},\n{''.join(lines)}}}"
