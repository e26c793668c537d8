"""Write the first pages of a report: findings, runs, comparison, methods.

Write what the report says of a setup: antennas, sphere, acquisition, calibration.
"""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

import numpy as np

from radargui.model.calibrated_setup import (
    CORRELATED,
    calibration_words,
    correlations,
    edited_since,
    setup_key,
    unit_of,
    value_at,
)
from radargui.model.drop import gravity_words, restitution_words
from radargui.model.gravity import Air
from radargui.model.radar import Transmitter
from radargui.model.rounding import UNKNOWN, alone, plain, quantity
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import SHARES, BudgetLine, variance_shares
from radargui.model.words import percent, sentence
from radargui.physics.path_length import MIN_RECEIVERS, condition_number, place_antennas, t_matrix
from radargui.report.content import Chapter, Content, Facts, Grid, MainResult, Note, Picture, Plots
from radargui.report.facts import ReportFacts, RunProvenance, SessionFacts, dependences_on, fit_cells, session_cells
from radargui.report.numbers import bibtex, methods
from radargui.report.run_facts import RunFacts, all_simulated, badges
from radargui.restitution.dependence import COVARIATES
from radargui.restitution.findings import Findings, SampleFindings, SessionFindings
from radargui.restitution.site_gravity import SiteCheck
from radargui.restitution.speed_models import preferred, title_of
from radargui.restitution.statistics import OUTLIER_RULE, Statistics, probability
from radargui.session.info import JournalEntry

_MAX_NAMED = 8
"""Pairs in a sentence (chosen by hand); the others are counted."""
_WORST_CONDITION = 100.0
"""From here an error of L may reach the position a hundredfold."""


def setup_blocks(setup: Setup, *, recorded: bool = True, simulated: bool = False) -> list[Content]:
    """Return what the report says about the setup.

    Parameters
    ----------
    setup
        Of the session.
    recorded
        Whether the setup's device recorded: imported runs were digitised by something else, of which it knows nothing.
    simulated
        Whether no device recorded at all.
    """
    radar, tracer = setup.radar, setup.tracer
    rate = f"{setup.daq.rate_hz:g} samples per second and channel"
    release = ", ".join(f"{1e3 * x:g}" for x in tracer.release_position_m)
    floor, daq = setup.floor.height_m, setup.daq
    index = f" (n = {radar.index:.8g})" if radar.index > 1.0 else ", the air taken as vacuum"
    density = f", {tracer.density_kg_m3:g} kg/m³" if tracer.density_kg_m3 else ""
    diameter = _with_u(tracer.diameter_m, tracer.u_diameter_m, "mm", 1e3)
    inputs = f"{daq.device}: {', '.join(setup.physical_channels)}; {daq.terminal}, ±{daq.range_v:g} V"
    rows = {
        "Frequency, wavelength": f"{radar.frequency_hz / 1e9:g} GHz, {plain(radar.wavelength_m, 5, 'mm', 1e3)}{index}",
        "Air": _air(setup.air),
        "Sign of the phase": f"{radar.phase_sign:+d}",
        "Transmitter": _transmitter(setup.transmitter),
        "Sphere": f"{diameter} diameter, released at ({release}) mm{density}",
        "Floor": "found from the impacts" if floor is None else f"z = {plain(floor, 4, 'mm', 1e3)} at contact",
        "Acquisition": f"simulated, {rate}" if simulated else inputs if recorded else "",
        "Rate": f"{rate}, skew {plain(daq.channel_skew_s, 3, 'µs', 1e6)}" if recorded else "",
        "Processing": f"correction {setup.processing.correction}, geometry {setup.processing.geometry}",
    }
    return [Facts.of(rows, "Setup"), _receivers(setup), *_calibration(setup), *_matrix(setup)]


def _transmitter(transmitter: Transmitter) -> str:
    distance = transmitter.distance_m
    if distance is None:
        place = f"at ({', '.join(f'{1e3 * x:g}' for x in transmitter.place_m)}) mm"
    else:
        place = f"{_with_u(distance, transmitter.u_distance_m, 'mm', 1e3)} above the centre"
    if transmitter.polarization_deg is None:
        return f"{place}; polarisation not given: the sphere counts as a point"
    return f"{place}, polarised along {_with_u(transmitter.polarization_deg, transmitter.u_polarization_deg, '°')}"


def _air(air: Air) -> str:
    """Return the state of the air and what follows from it; empty where the setup does not say it."""
    if not air.is_known:
        return ""
    gas = air.gas
    state = ", ".join(
        _with_u(value or 0.0, u, unit)
        for value, u, unit in (
            (air.temperature_c, air.u_temperature_c, "°C"),
            (air.pressure_hpa, air.u_pressure_hpa, "hPa"),
            (air.humidity_percent, air.u_humidity_percent, "% humidity"),
        )
    )
    return (
        f"{state}: n − 1 = {quantity(air.refractive_index - 1.0, air.u_refractive_index, 'ppm', 1e6)} (Rüeger 2002), "
        f"density {quantity(gas.density_kg_m3, gas.u_density_kg_m3, 'kg/m³')}, "
        f"viscosity {plain(gas.viscosity_m2_s, 3, 'mm²/s', 1e6)}"
    )


def _with_u(value: float, u: float | None, unit: str = "", scale: float = 1.0) -> str:
    return quantity(value, u, unit, scale) if u else f"{value * scale:g} {unit}".strip()


def _receivers(setup: Setup) -> Grid:
    rows = (
        {
            "receiver": str(number),
            "tilt / °": _with_u(receiver.tilt_deg, receiver.u_tilt_deg),
            "azimuth / °": _with_u(receiver.azimuth_deg, receiver.u_azimuth_deg),
            "distance / mm": _with_u(receiver.distance_m, receiver.u_distance_m, scale=1e3),
        }
        for number, receiver in enumerate(setup.receiver, 1)
    )
    return Grid.of(rows, "Receivers")


def _calibration(setup: Setup) -> Iterator[Content]:
    """Give the table of what a calibration found, and which of it is known only together."""
    content = setup.calibration.content
    if content is None or not content.names:
        return
    covariance = np.array(content.covariance)
    u = np.sqrt(np.diag(covariance))
    rows = (
        {
            "parameter": setup_key(name),
            "unit": unit,
            "value ± u": quantity(value, own, scale=scale),
            "in the setup": plain(value_at(setup, name), 6, scale=scale),
        }
        for name, value, own in zip(content.names, content.values, u.tolist(), strict=True)
        for unit, scale in [unit_of(name)]
    )
    words = calibration_words(setup)
    yield Note(sentence(f"{words}: {content.reason or UNKNOWN}"))
    yield Grid.of(rows, "Calibration", left=(0, 1))
    pairs = [
        f"{setup_key(a)} with {setup_key(b)}: {r:+.2f}"
        for a, b, r in correlations(covariance, content.names, CORRELATED)
    ]
    named = "; ".join(pairs[:_MAX_NAMED]) + (f" and {len(pairs) - _MAX_NAMED} more" * (len(pairs) > _MAX_NAMED))
    if pairs:
        yield Note(f"Correlated by more than {CORRELATED:g}: {named}.")
    if edited := edited_since(setup):
        yield Note(sentence(edited.text), warning=True)


def _matrix(setup: Setup) -> Iterator[Content]:
    if setup.n_receivers < MIN_RECEIVERS:
        return
    antennas = place_antennas(setup)
    rows = tuple((str(number), *(f"{value:.5f}" for value in row)) for number, row in enumerate(t_matrix(antennas), 1))
    condition = condition_number(antennas)
    yield Grid(("receiver", "sin t cos a", "sin t sin a", "1 + cos t"), rows, "Matrix T (plane wave)")
    yield Note(f"Condition number of T: {condition:.3f}", warning=condition > _WORST_CONDITION)


_HALF_MM, _WHOLE_MM, _SPREAD_MM, _FALLS_MM = (88.0, 100.0), (180.0, 100.0), (180.0, 50.0), (180.0, 80.0)
"""Sizes of figures: two beside each other, one alone, and of the second page (chosen by hand)."""
_DIGEST = 16
"""Letters of a checksum that people see; report.json has all of them."""


def front_chapters(facts: ReportFacts) -> list[Chapter]:
    """Return what stands before the runs."""
    title = _title(facts)
    chapters = [Chapter(title, tuple(findings_blocks(facts))), Chapter("Runs and series", tuple(_series(facts)))]
    for found, one in zip(facts.findings.sessions, facts.sessions, strict=True):
        of = f" of {found.name}" if len(facts.sessions) > 1 else ""
        chapters.append(Chapter(f"Setup and provenance{of}", tuple(_provenance(one)), follows=True))
    return [*chapters, Chapter("Methods and citation", (Note(methods(facts)), Note(bibtex(facts))), follows=True)]


def _title(facts: ReportFacts) -> str:
    labels = list(dict.fromkeys(one.label for one in facts.findings.sessions if one.label))
    what = ", ".join(labels) or f"Session {', '.join(one.name for one in facts.findings.sessions)}"
    marks = {run.source.mark for one in facts.sessions for run in one.runs if run.source.kind != "unknown"}
    return f"{what}, {marks.pop()}" if len(marks) == 1 and "" not in marks else what


def findings_blocks(facts: ReportFacts) -> Iterator[Content]:
    """Give the first page: it answers what fell on what, how often, and what came out."""
    found = facts.findings
    several = len(found.sessions) > 1
    value = _answer(found)
    yield MainResult(value, found.sentence) if value else Note(found.sentence)
    if several:
        yield _sessions(found)
        for words in (one.words for one in (found.samples_compared, found.sessions_compared) if one):
            yield Note(f"{words}.")
    for one, session in zip(found.sessions, facts.sessions, strict=True):
        if not several:
            yield from _found(one, session)
        for text in _marks(one, session):
            yield Note(f"{one.name}: {text}" if several else text, warning=True)
    for words in found.cautions:
        yield Note(words, warning=True)
    names = {one.name: f" ({one.name})" if several else "" for one in found.sessions}
    for one in found.sessions:
        if one.e_budget.combined is not None or one.g_budget_m_s2.combined is not None:
            yield _budget(one, names[one.name])
    yield from _overview(facts)
    for one in found.sessions:
        if one.excluded:
            rows = ({"run": run.run, "": run.kind, "reason": run.reason or UNKNOWN} for run in one.excluded)
            yield Grid.of(rows, f"Not in the mean of e{names[one.name]}", left=(0, 1, 2))


def _answer(found: Findings) -> str:
    """Return e with its uncertainty: of a session, or of the sessions of one sample; empty where there is no such e."""
    if len(found.sessions) == 1:
        e = found.sessions[0].series.e
        return f"e = {e.words()}" if e.mean is not None else ""
    pooled = [one.repeatability for one in found.samples]
    return f"e = {quantity(pooled[0].mean, pooled[0].u_mean)}" if len(pooled) == 1 and pooled[0] else ""


def _overview(facts: ReportFacts) -> Iterator[Content]:
    """Give e against the speed, beside it the tracks where there are any."""
    # matplotlib is loaded only where figures are drawn
    from radargui.report.series_figures import speeds_figure, tracks_figure

    runs = [one.runs for one in facts.sessions]
    tracks = any(run.height is not None for session in runs for run in session)
    size = _HALF_MM if tracks else _WHOLE_MM
    plots = [Picture("e against the impact speed", partial(speeds_figure, facts, size))]
    if tracks:
        plots.append(Picture("Track", partial(tracks_figure, runs, size)))
    if any(runs):
        yield Plots(tuple(plots))


def _found(one: SessionFindings, session: SessionFacts) -> Iterator[Content]:
    e, series = one.series.e, one.series
    interval = f"{alone(e.interval_low, e.standard_error)} to {alone(e.interval_high, e.standard_error)}"
    expanded = f"; ± {plain(e.expanded, 2)} with calibration and sphere" if e.expanded is not None else ""
    # behind a single value stands what it says of itself
    n_runs = len(session.runs)
    drops = f"{e.n} of {n_runs} run{'s' * (n_runs > 1)}" if n_runs else "0"
    rows = {
        "Session": one.name,
        "Fell on": one.label,
        "Source": badges(session.runs),
        "Drops": f"{drops}{f', from {_mean(series.drop_height_m, 1e3)} mm' if series.drop_height_m.n else ''}"
        f"{f', at {_mean(series.impact_speed_m_s)} m/s' if series.impact_speed_m_s.n else ''}",
        "e of the first impact": f"{e.words()} ({'combined' if e.combined is not None else 'statistical'} u)"
        if e.mean is not None
        else "",
        "Scatter": f"standard deviation {plain(e.standard_deviation, 2)}, standard error "
        f"{plain(e.standard_error, 2)}, n = {e.n}"
        if e.n > 1
        else "",
        "95 % interval": f"{interval} (scatter, Student's t){expanded}" if e.n > 1 else "",
        "Stated u": f"{e.consistency.words}." if e.consistency else "",
        "Outliers": f"{', '.join(series.outliers) or 'none'} by the {OUTLIER_RULE}; all are in the mean"
        if e.n > 2
        else "",
        "g of the first fall": quantity(series.g_m_s2.mean, series.g_m_s2.u, "m/s²") if series.g_m_s2.n else "",
        "g of the place": _site(one.site) if one.site else "",
    }
    yield Facts.of(rows)
    if not session.runs:
        yield Note("This session holds no run.", warning=True)


def _site(site: SiteCheck) -> str:
    return f"{site.verdict}; expected {quantity(site.expected_m_s2, site.u_expected_m_s2, 'm/s²')}"


def _mean(found: Statistics, scale: float = 1.0) -> str:
    return plain(found.mean, 4, scale=scale)


def _marks(one: SessionFindings, session: SessionFacts) -> Iterator[str]:
    if one.site is not None and one.site.agrees is False:
        yield f"{one.site.verdict}."
    said = {
        "simulated": ("is simulated: no measurement", "are simulated: no measurement"),
        "replay": ("is a replay, no drop of its own", "are replays, no drops of their own"),
    }
    for kind, (of_one, of_several) in said.items():
        names = [run.name for run in session.runs if run.source.kind == kind]
        if names:
            every = "The run" if len(names) == 1 else "All runs"
            who = every if len(names) == len(session.runs) else ", ".join(names)
            yield f"{who} {of_several if len(names) > 1 else of_one}."
    if one.preliminary:
        yield (
            f"Preliminary, because the correction was stopped before it ended: {', '.join(one.preliminary)}. "
            "radargui batch makes up for it."
        )


def _budget(one: SessionFindings, named: str) -> Grid:
    # of a single drop there is no scatter: its own statistical u stands there
    several = one.series.e.n > 1

    def row(name: str, line: BudgetLine) -> dict[str, str]:
        shares = variance_shares(line)
        cells = {"of": name}
        for key in SHARES:
            share = f" ({percent(shares[key])})" if key in shares and getattr(line, key) is not None else ""
            title = "standard error" if key == "statistical" and several else key
            cells[title] = f"{plain(getattr(line, key), 2)}{share}"
        return {**cells, "combined": plain(line.combined, 2)}

    rows = row("e of the first impact", one.e_budget), row("g / (m/s²)", one.g_budget_m_s2)
    of = "the mean" if several else "a single drop"
    return Grid.of(rows, f"Standard uncertainty of {of}, with shares of its square{named}")


def _series(facts: ReportFacts) -> Iterator[Content]:
    found = facts.findings
    several = len(found.sessions) > 1
    for sample in found.samples:
        if sample.fits and sample.fits[0].n_impacts:
            yield _speed_table(sample, found)
        yield from _repeatability(sample)
        yield from _besides(sample)
    spread = {one.name: sentence(one.distribution.words) for one in found.sessions if one.distribution}
    if spread:
        yield Facts.of(spread, "Distribution of e of the first impacts")
    from radargui.report.series_figures import falls_figure, spread_figure

    if spread or any(dependences_on(facts, on) for on in COVARIATES):
        title = "Distribution of e, and what it may depend on"
        yield Plots((Picture(title, partial(spread_figure, facts, _SPREAD_MM)),))

    runs = [one.runs for one in facts.sessions]
    if any(run.falls is not None for session in runs for run in session):
        colours = ", each session in its colour of e against the impact speed" if several else ""
        yield Plots((Picture(f"Falls{colours}", partial(falls_figure, runs, _FALLS_MM)),))
    for one, session in zip(found.sessions, facts.sessions, strict=True):
        if session.runs:
            yield runs_table(one, session.runs, f" of {one.name}" if several else "")


def runs_table(found: SessionFindings, runs: tuple[RunFacts, ...], of: str = "") -> Grid:
    """Return one line a run."""
    rows = (
        {
            "drop": run.label,
            "run": run.name,
            "height / mm": plain(run.figure("drop_height_m"), 4, scale=1e3),
            "speed / (m/s)": plain(run.figure("impact_speed_m_s"), 4),
            "e": restitution_words(run.figures),
            "g / (m/s²)": gravity_words(run.figures),
            "impacts": str(len(run.bounces.impacts)) if run.figures else UNKNOWN,
            "verdict": f"{run.said}{', outlier' if run.name in found.series.outliers else ''}",
        }
        for run in runs
    )
    return Grid.of(rows, f"Runs{of} (± is the combined standard uncertainty of each)", left=(0, 1, 7))


def _sessions(found: Findings) -> Grid:
    cells = map(session_cells, found.sessions)
    rows = ({title: cell for title, cell in row.items() if title != "s/√n"} for row in cells)
    return Grid.of(rows, "Sessions: e of the first impact with combined u, s of one drop", left=(0, 1))


def _speed_table(sample: SampleFindings, found: Findings) -> Grid:
    """Return every model of e against the impact speed, the one that the user chose marked."""
    best = preferred(sample.fits)
    rows = (
        {
            "model": title_of(fit.model) + (" (chosen)" if fit.model == found.model else ""),
            "parameters": ", ".join(one.words for one in fit.parameters) or fit.problem,
            **fit_cells(fit),
            "p of the shape": UNKNOWN if fit.trend_p is None else probability(fit.trend_p).removeprefix("= "),
            "scatter": plain(fit.scatter, 2),
            "AICc": plain(fit.aicc, 5) + (" *" if fit in best else ""),
        }
        for fit in sample.fits
    )
    of = f" of {sample.label}" if sample.label else ""
    n, runs = sample.fits[0].n_impacts, sample.fits[0].n_runs
    title = f"e against the impact speed{of}: {n} impacts of {runs} run{'s' * (runs > 1)} (* best described)"
    return Grid.of(rows, title, left=(0, 1))


def _repeatability(sample: SampleFindings) -> Iterator[Content]:
    one = sample.repeatability
    if one is not None:
        low, high = (alone(end, one.u_mean) for end in (one.interval_low, one.interval_high))
        rows = {
            "Mean of the sessions": f"{quantity(one.mean, one.u_mean)}, 95 % interval {low} to {high} {sample.reduced}",
            "Repeatability s_r": f"{plain(one.repeatability_sd, 2)} within a session ({one.n} drops)",
            "Between sessions s_L": f"{plain(one.between_sd, 2)} ({one.n_groups} sessions, F = {one.f:.3g}, "
            f"p {probability(one.p)})",
            "Reproducibility s_R": plain(one.reproducibility_sd, 2),
        }
        yield Facts.of(rows, f"Within and between sessions{f': {sample.label}' if sample.label else ''} (ISO 5725-2)")


def _besides(sample: SampleFindings) -> Iterator[Content]:
    """Give what e depends on besides the speed; of what no impact tells nothing is said."""
    rows = {COVARIATES[one.on].name: sentence(one.words) for one in sample.dependences if one.n_groups > 1}
    if rows:
        yield Facts.of(rows, f"What else e depends on{f': {sample.label}' if sample.label else ''}")


def _provenance(session: SessionFacts) -> Iterator[Content]:
    info, found, runs = session.info, session.provenance, session.runs
    if found is None:
        return
    imported = bool(runs) and all(run.origin for run in runs)
    simulated = all_simulated(runs)
    rows = {
        "Session": info.name,
        "Begun": info.created_at,
        "Operator": info.operator,
        "Sample": info.sample,
        "Target": info.target,
        "Notes": info.notes,
        "Calibration": ", ".join(filter(None, (info.calibration.origin, info.calibration.made_at))),
        "Imported with" if imported else "Recorded with": _versions(info.versions),
        "Reported with": f"{_versions(found.reported_with)}; {found.reported_at}",
        "Assumed u": ", ".join(f"{key} {plain(u, 2)}" for key, u in found.assumed.items()),
    }
    yield Facts(tuple((name, said or UNKNOWN) for name, said in rows.items()))
    notes = tuple((entry.at.replace("T", " ")[:19], _noted(entry)) for entry in info.journal)
    if notes:
        yield Facts(notes, title="Noted meanwhile")
    yield from setup_blocks(info.setup, recorded=not imported and not simulated, simulated=simulated)
    if found.runs:
        yield Grid.of(
            map(_file_row, found.runs), "Files (SHA-256, its first letters; all in report.json)", left=(0, 1, 2, 6)
        )


def _noted(entry: JournalEntry) -> str:
    """Return a note; one about a whole run names it, for the time is that of the note."""
    return f"{Path(entry.run).stem}: {entry.text}" if entry.run and entry.index is None else entry.text


def _versions(of: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {text}" for name, text in of.items())


def _file_row(run: RunProvenance) -> dict[str, str]:
    notes = [
        run.problem,
        run.set_aside and f"set aside: {run.set_aside}",
        run.imported_from and f"from {run.imported_from}",
        run.replay_of and f"replay of {run.replay_of}",
        run.recovered_at and f"recovered {run.recovered_at}",
        *run.settings_changed,
        f"processed {len(run.processings)} times" if len(run.processings) > 1 else "",
    ]
    return {
        "file": run.file,
        "SHA-256": run.sha256[:_DIGEST] or UNKNOWN,
        "source": f"{run.source}{f': {run.device}' if run.device else ''}" or UNKNOWN,
        "gaps": str(run.n_gaps),
        "lost": str(run.n_lost),
        "clipped": UNKNOWN if run.fraction_clipped is None else f"{100.0 * run.fraction_clipped:.3g} %",
        "history": "; ".join(filter(None, notes)) or "as recorded",
    }
