"""Write what a paper takes over: the methods paragraph, LaTeX tables (booktabs) and the BibTeX entry."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence

from radargui import __version__
from radargui.model.rounding import alone, concise, plain
from radargui.report.content import templates
from radargui.report.facts import ReportFacts, SessionFacts, fit_cells, session_cells
from radargui.restitution.findings import SampleFindings
from radargui.restitution.speed_models import speed_model, title_of
from radargui.restitution.statistics import OUTLIER_RULE


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
