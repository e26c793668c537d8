"""What a paper takes: the methods paragraph in plain words, tables for LaTeX (booktabs), the BibTeX entry."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence

from radargui import __version__
from radargui.model.rounding import alone, concise, plain
from radargui.report.facts import ReportFacts, SessionFacts
from radargui.restitution.findings import Findings, SampleFindings, SessionFindings
from radargui.restitution.speed_models import MODELS
from radargui.restitution.statistics import OUTLIER_RULE, probability

_CORRECTIONS = {
    "joint": (
        "motion, IQ mismatch (offset, gain ratio, quadrature error), amplitudes and mirrored paths of all receivers "
        "were estimated together from the samples of all channels, impacts as steps of the velocity"
    ),
    "adaptive": (
        "the IQ mismatch of each receiver was estimated by least squares on the circle of I and Q, together with "
        "offsets and amplitudes that change smoothly with the position"
    ),
    "published": (
        "bias and amplitude of I and Q of each receiver were followed by splines through their extremes (Rech & Huang "
        "2019, arXiv:1911.00750)"
    ),
    "ellipse": "one ellipse was fitted to I and Q of each receiver and mapped to a circle",
    "none": "I and Q were used as they were recorded",
}
_GEOMETRIES = {
    "exact": "the position followed from the exact bistatic path lengths (near field)",
    "plane": "the position followed from the path lengths in the plane-wave approximation",
}


def methods(facts: ReportFacts) -> str:
    """Return the paragraph; what differs between sessions is said of each."""
    found = facts.findings
    pairs = list(zip(found.sessions, facts.sessions, strict=True))
    said = [_dropped(one, session, alone=len(pairs) == 1) for one, session in pairs]
    ways: dict[str, list[str]] = {}
    for one, session in pairs:
        ways.setdefault(_followed(session), []).append(one.name)
    said += [way if len(ways) == 1 else f"{', '.join(names)}: {way}" for way, names in ways.items()]
    said.append(
        "The coefficient of restitution of an impact is the ratio of the speeds along the floor's normal just after "
        "and just before it, both from fits of the flights."
    )
    said.append(_uncertainty(found))
    most = _most_drops(found)
    if most > 1:
        said.append("Intervals are 95 %, Student's t.")
    if most > 2:
        said.append(f"Outliers were flagged by the {OUTLIER_RULE} and kept.")
    if found.model:
        model = MODELS[found.model]
        source = f" ({model.source})" if model.source else ""
        fits = [fit for one in found.samples if (fit := one.fit(found.model)).parameters]
        how = _each(fit.u_from for fit in fits)
        said.append(
            f"e against the impact speed v was described by {model.equation}{source}, fitted by weighted least squares "
            f"with the scatter between impacts as a free parameter; uncertainties: {how}."
            if fits
            else f"{model.equation}{source} could not be fitted to e against the impact speed v."
        )
    said.append(f"All results were computed with RadarGUI {__version__}.")
    return " ".join(filter(None, said))


def _most_drops(found: Findings) -> int:
    return max(one.series.e.n for one in found.sessions)


def _uncertainty(found: Findings) -> str:
    most, combined = _most_drops(found), any(one.series.e.combined is not None for one in found.sessions)
    if most == 0:
        return ""
    if most == 1:
        shared = ", calibration and sphere (GUM, JCGM 100)" if combined else ""
        return f"A single drop stands with the statistical uncertainty of its own fit{shared}."
    if not combined:
        return "The mean stands with the standard error from the scatter of the drops."
    return (
        "The mean stands with its combined standard uncertainty: the standard error from the scatter of the drops, and "
        "calibration and sphere, common to all drops, which do not average out (GUM, JCGM 100)."
    )


def _dropped(found: SessionFindings, session: SessionFacts, *, alone: bool) -> str:
    """Return what fell, how often and from where."""
    height, diameter = found.series.drop_height_m, session.info.setup.tracer.diameter_m
    sphere = f"{'A' if alone else f'{found.name}: a'} sphere" + (f" of {1e3 * diameter:g} mm diameter" * bool(diameter))
    label = f" ({found.label})" if found.label else ""
    dropped = f" from {plain(height.mean, 4, 'mm', 1e3)}" if height.n else ""
    n, n_valid = sum(not run.failure and run.status != "no_motion" for run in session.runs), found.series.e.n
    are = "runs are" if n > 1 else "run is"
    simulated = f" The {are} simulated." if found.series.kind == "simulated" else ""
    times = {1: "once", 2: "twice"}.get(n, f"{n} times")
    said = f"{sphere}{label} was dropped {times}{dropped}; {n_valid} drop{'s' * (n_valid != 1)} gave a valid e."
    return said + simulated


def _followed(session: SessionFacts) -> str:
    """Return how its motion was measured and computed."""
    setup, used = session.info.setup, [run for run in session.runs if run.status == "ok"]
    radar, n = setup.radar, setup.n_receivers
    air = "" if radar.refractive_index is None else f", refractive index of the air {radar.refractive_index:g}"
    said = (
        f"The motion was followed by a continuous-wave radar at {radar.frequency_hz / 1e9:g} GHz (wavelength "
        f"{plain(radar.wavelength_m, 5, 'mm', 1e3)}{air}) with one transmitter and {n} receiver{'s' * (n > 1)}."
    )
    if rates := _each(f"{run.rate_hz:g}" for run in used if run.rate_hz):
        said += f" I and Q of each receiver were digitised at {rates} samples per second."
    ways = (
        _each(_CORRECTIONS.get(run.correction or "", "") for run in used),
        _each(_GEOMETRIES.get(run.geometry or "", "") for run in used),
    )
    way = "; ".join(filter(None, ways))
    return f"{said} {way[0].upper()}{way[1:]}." if way else said


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


def typeset(cell: str) -> str:
    """Return a cell of a table: escaped, its numbers with a minus and powers of ten as papers print them."""
    shown = _MINUS.sub("$-$", escaped(cell))
    return _POWER.sub(lambda found: rf"{found[1]} $\times 10^{{{int(found[2])}}}$", shown)


def latex_tables(facts: ReportFacts) -> str:
    """Return the tables of a report, one below the other."""
    found, needs = facts.findings, r"\usepackage{booktabs, longtable}"
    tables = [
        f"% Tables of RadarGUI {__version__}: {needs}. In parentheses: standard uncertainty.",
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
    return _table(f"Impacts of {escaped(name)}, times from {since}", header, rows)


def _table(caption: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [" & ".join(map(typeset, row)) + r" \\" for row in rows]
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
