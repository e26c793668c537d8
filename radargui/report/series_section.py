"""The section of a report that several sessions have in common: means, dependence on the speed, comparison."""

from collections.abc import Iterator

from radargui.model.rounding import UNKNOWN, alone, plain, quantity
from radargui.report.document import Chapter, Content, Facts, Grid, Note
from radargui.report.facts import ReportFacts
from radargui.report.methods import methods
from radargui.report.session_section import speed_picture
from radargui.restitution.findings import Findings, SampleFindings
from radargui.restitution.speed_models import MODELS, preferred
from radargui.restitution.statistics import probability


def series_section(facts: ReportFacts) -> Chapter:
    """Return what the sessions found together."""
    found = facts.findings
    blocks: list[Content] = [Note(found.sentence), _sessions(found)]
    for sample in found.samples:
        blocks += [speed_table(sample, found), *_repeatability(sample)]
    compared = (one.words for one in (found.samples_compared, found.sessions_compared) if one)
    blocks += [Note(f"{words}.") for words in compared]
    blocks += [Note(words, warning=True) for words in found.cautions]
    blocks += [Note(words, warning=True) for words in _suspects(found)]
    blocks.append(Facts.of({"Methods": methods(facts)}))
    groups = {one.name: session.runs for one, session in zip(found.sessions, facts.sessions, strict=True)}
    return Chapter(f"Series of {len(facts.sessions)} sessions", tuple(blocks), speed_picture(groups))


def _sessions(found: Findings) -> Grid:
    rows = (
        {
            "session": one.name,
            "fell on": one.label or UNKNOWN,
            "n": str(one.series.e.n),
            "height / mm": plain(one.series.drop_height_m.mean, 4, scale=1e3),
            "speed / (m/s)": plain(one.series.impact_speed_m_s.mean, 4),
            "e": one.series.e.brief(),
            "s": plain(one.series.e.standard_deviation, 2),
            "χ²/ν": UNKNOWN if one.series.e.consistency is None else plain(one.series.e.consistency.birge_ratio**2, 2),
            "g / (m/s²)": one.series.g_m_s2.brief(),
        }
        for one in found.sessions
    )
    return Grid.of(rows, "Sessions: e of the first impact with combined u, s of one drop", left=(0, 1))


def speed_table(sample: SampleFindings, found: Findings) -> Grid:
    """Return every model of e against the impact speed, the one that the user chose marked."""
    best = preferred(sample.fits)
    rows = (
        {
            "model": MODELS[fit.model].title + (" (chosen)" if fit.model == found.model else ""),
            "parameters": ", ".join(one.words for one in fit.parameters) or fit.problem,
            "χ²": plain(fit.chi2, 3),
            "ν": str(fit.degrees_of_freedom or UNKNOWN),
            "p": UNKNOWN if fit.p is None else probability(fit.p).removeprefix("= "),
            "p of the shape": UNKNOWN if fit.trend_p is None else probability(fit.trend_p).removeprefix("= "),
            "scatter": plain(fit.scatter, 2),
            "AICc": plain(fit.aicc, 5) + (" *" if fit in best else ""),
        }
        for fit in sample.fits
    )
    of = f" of {sample.label}" if sample.label else ""
    n = sample.fits[0]
    title = f"e against the impact speed{of}: {n.n_impacts} impacts of {n.n_runs} runs (* best described)"
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


def _suspects(found: Findings) -> Iterator[str]:
    for one in found.sessions:
        if one.site is not None and one.site.agrees is False:
            yield f"{one.name}: {one.site.verdict}."
        if one.series.outliers:
            yield f"{one.name}: {', '.join(one.series.outliers)} stand out; they are in the mean."
        if one.series.kind in ("simulated", "replay"):
            yield f"{one.name}: {one.series.kind}, no measurement."
        if one.preliminary:
            yield f"{one.name}: preliminary results of {', '.join(one.preliminary)}."
        if one.excluded:
            said = "; ".join(f"{run.run} {run.kind}{f': {run.reason}' if run.reason else ''}" for run in one.excluded)
            yield f"{one.name}: not in the mean of e: {said}."
