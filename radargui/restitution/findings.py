"""What sessions found, computed once: the window, the report's first page and its JSON read the same values."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from radargui.model.drop import Drop
from radargui.model.result import Bounce
from radargui.model.rounding import alone, concise, plain
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import BudgetLine, UncertaintyBudget
from radargui.restitution.comparison import Comparison, Repeatability, compare, repeatability_of
from radargui.restitution.dependence import Dependence, dependences
from radargui.restitution.distribution import Distribution, distribution_of
from radargui.restitution.series import PRELIMINARY, Series, series_of
from radargui.restitution.site_gravity import SiteCheck, check_against_site
from radargui.restitution.speed_models import (
    ImpactPoint,
    ModelName,
    SpeedFit,
    fit_speed_models,
    preferred,
    title_of,
)
from radargui.restitution.statistics import Statistics, probability


@dataclass(frozen=True, slots=True)
class SeriesRun:
    """What is needed of one run that was not set aside.

    Attributes
    ----------
    drop
        Its name within the session, where its samples come from, its first fall and bounce.
    status, reason
        ok, no_motion, rejected, or failed: it could not be read or processed.
    impacts, budget
        Of its result.
    """

    drop: Drop
    status: str = "ok"
    reason: str = ""
    impacts: tuple[Bounce, ...] = ()
    budget: UncertaintyBudget | None = None


@dataclass(frozen=True, slots=True)
class SeriesSession:
    """One session of a series: its record, its runs, and those set aside by name, each with the reason."""

    name: str
    setup: Setup
    runs: tuple[SeriesRun, ...] = ()
    set_aside: Mapping[str, str] = field(default_factory=dict)
    sample: str = ""
    target: str = ""


@dataclass(frozen=True, slots=True)
class Excluded:
    """A run that is not in the mean of e: what it is called, what it is in a word or two, and why."""

    run: str
    kind: str
    reason: str


@dataclass(frozen=True, slots=True)
class SessionFindings:
    """What one session found.

    Attributes
    ----------
    name, sample, target
        As in its record.
    series
        Statistics of e (first bounce), g, drop height and impact speed over the drops that count; outliers of e.
    e_budget, g_budget_m_s2
        Of the two means: `statistical` is the standard error (of a single drop its own statistical u), the others do
        not average out.
    site
        Mean g against the site's; None without a fall or a site.
    excluded
        Every run that is not in the mean of e, with the reason.
    preliminary
        Names of runs whose correction is still to be computed.
    distribution
        Of e over the drops that are in its mean; None of fewer than four.
    """

    name: str
    sample: str
    target: str
    series: Series
    e_budget: BudgetLine
    g_budget_m_s2: BudgetLine
    site: SiteCheck | None
    excluded: tuple[Excluded, ...]
    preliminary: tuple[str, ...]
    distribution: Distribution | None = None

    @property
    def kind(self) -> str:
        """What is said before "drops" of what is no measurement: "simulated "; empty of measurements."""
        return f"{self.series.mark} " if self.series.mark else ""

    @property
    def label(self) -> str:
        """What fell on what."""
        return sample_label(self.sample, self.target)

    @property
    def sentence(self) -> str:
        """What can be quoted: e with its combined standard uncertainty, of how many drops, from where, how fast."""
        e, height, speed = self.series.e, self.series.drop_height_m, self.series.impact_speed_m_s
        of = f" of {self.label}" if self.label else ""
        if e.mean is None:
            return f"No drop{of} gave a valid coefficient of restitution."
        drops = f"mean of {e.n} {self.kind}drops" if e.n > 1 else f"one {self.kind}drop"
        high = f" from {plain(height.mean, 4, 'mm', 1e3)}" if height.n else ""
        fast = f" at {plain(speed.mean, 4, 'm/s')}" if speed.n else ""
        behind = "combined standard uncertainty" if e.combined else "standard uncertainty without calibration"
        parts = (("standard deviation", e.standard_deviation), ("standard error", e.standard_error))
        scatter = ", ".join(f"{name} {plain(value, 2)}" for name, value in parts if value is not None)
        return (
            f"Coefficient of restitution{of}: e = {e.brief()}{fast}, {drops}{high} "
            f"(in parentheses the {behind}{'; ' if scatter else ''}{scatter})."
        )


@dataclass(frozen=True, slots=True)
class SampleFindings:
    """What all sessions of one sample on one target found together.

    Attributes
    ----------
    label
        What fell on what; empty where the records do not say.
    sessions
        Their names.
    fits
        Every model of e against the impact speed, over the valid impacts of the drops that count.
    repeatability
        Of e within and between the sessions; None of one session, and where their speeds differ and no model says by
        how much e differs for that.
    reduced
        How e was brought to one speed for it, in words; empty where the sessions had one.
    dependences
        Slopes of e along what it may depend on besides the speed.
    """

    label: str
    sessions: tuple[str, ...]
    fits: tuple[SpeedFit, ...]
    repeatability: Repeatability | None
    reduced: str = ""
    dependences: tuple[Dependence, ...] = ()

    def fit(self, model: ModelName) -> SpeedFit:
        """Return the fit of one model."""
        return next(fit for fit in self.fits if fit.model == model)


@dataclass(frozen=True, slots=True)
class Findings:
    """What a report says in numbers.

    Attributes
    ----------
    model
        Which dependence on the speed the user chose; None: all are shown.
    sessions, samples
        In the order given.
    sessions_compared, samples_compared
        Tests of their means of e; None with one. Samples are compared by the means of their sessions where each has
        several, else by their drops.
    cautions
        What must be known to read these comparisons.
    """

    model: ModelName | None
    sessions: tuple[SessionFindings, ...]
    samples: tuple[SampleFindings, ...]
    sessions_compared: Comparison | None = None
    samples_compared: Comparison | None = None
    cautions: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """What can be quoted."""
        if len(self.sessions) == 1:
            return self.sessions[0].sentence
        said = []
        for sample in self.samples:
            found = sample.repeatability
            if found is None:
                several = len(sample.sessions) > 1
                own = [one for one in self.sessions if one.name in sample.sessions]
                # of several sessions of a sample it must be said which one gave none
                said += [
                    f"{one.name}: {one.sentence}" if several and one.series.e.mean is None else one.sentence
                    for one in own
                ]
                continue
            low, high = (alone(one, found.u_mean) for one in (found.interval_low, found.interval_high))
            kinds = dict.fromkeys(one.kind for one in self.sessions if one.name in sample.sessions)
            model = f" {sample.fit(self.model).words}." if self.model else ""
            said.append(
                f"{sample.label or 'All sessions'}: mean of {found.n_groups} {''.join(kinds)}sessions e = "
                f"{concise(found.mean, found.u_mean)}{f' {sample.reduced}' if sample.reduced else ''}, 95 % interval "
                f"{low} to {high} (standard error and Student's t between sessions, without what these share, such as "
                f"calibration and sphere), repeatability s_r = {plain(found.repeatability_sd, 2)}, reproducibility "
                f"between sessions s_R = {plain(found.reproducibility_sd, 2)} (F-test that sessions do not differ: p "
                f"{probability(found.p)}).{model}"
            )
        return " ".join(said)


UNNAMED = "(sample not named)"
"""A sample of which no record says what it is, beside others."""
_SAME_SPEED = 0.02
"""Relative: an e ~ v^(-1/4) changes by 0.5 %."""


def findings_of(sessions: Sequence[SeriesSession], model: ModelName | None = None) -> Findings:
    """Return what sessions found, each drop once, all of the best kind that there is (see `series_of`).

    Parameters
    ----------
    sessions
        One or several, with different names.
    model
        The dependence of e on the speed that the user chose.
    """
    # over all sessions: a drop that was imported into another one is still the same drop
    counted = series_of([replace(run.drop, name=f"{one.name}/{run.drop.name}") for one in sessions for run in one.runs])
    found = tuple(_session_findings(one, counted) for one in sessions)
    labels = list(dict.fromkeys(one.label for one in found))
    values = {one.name: _values(session, one) for session, one in zip(sessions, found, strict=True)}
    samples, of_samples = [], {}
    for label in labels:
        names = tuple(one.name for one in found if one.label == label)
        points = [point for one in sessions if one.name in names for point in _points(one, counted)]
        fits = fit_speed_models(points)
        own = [one for one in sessions if one.name in names]
        best = next((fit for fit in fits if fit.model == model), None) if model else next(iter(preferred(fits)), None)
        besides = dependences(points, best)
        samples.append(SampleFindings(label, names, fits, *_repeated(own, counted, fits, model or "power"), besides))
        of_samples[label or UNNAMED] = [values[name] for name in names if values[name]]
    # drops of a session share a setup and a day: where there are several, only they are independent
    means = all(len(groups) > 1 for groups in of_samples.values())
    grouped = {
        label: [sum(group) / len(group) for group in groups] if means else [e for group in groups for e in group]
        for label, groups in of_samples.items()
    }
    return Findings(model, found, tuple(samples), compare(values), compare(grouped), tuple(_cautions(sessions, found)))


def sample_label(sample: str, target: str) -> str:
    """Return what fell on what, in one line."""
    return " on ".join(" ".join(part.split()) for part in (sample, target) if part.strip())


def _session_findings(session: SeriesSession, counted: Series) -> SessionFindings:
    left_out = {
        run.drop.name: why.replace(f" {session.name}/", " ")
        for run in session.runs
        if (why := counted.left_out.get(f"{session.name}/{run.drop.name}"))
    }
    kept = [run.drop for run in session.runs if run.drop.name not in left_out]
    series = replace(series_of(kept), kind=counted.kind, left_out=left_out)
    used = [run for run in session.runs if run.drop.name in series.seen]
    e_budget = _budget(series.e, [run for run in used if run.drop.e is not None], lambda one: one.e)
    g_budget = _budget(series.g_m_s2, [run for run in used if run.drop.g_m_s2 is not None], lambda one: one.g_m_s2)
    g = series.g_m_s2
    site = None if g.mean is None else check_against_site(g.mean, g.u, session.setup, g.combined)
    excluded = [Excluded(run, "set aside", why) for run, why in session.set_aside.items()]
    excluded += [one for run in session.runs if (one := _why_excluded(run, left_out))]
    preliminary = tuple(run.drop.name for run in session.runs if run.drop.preliminary)
    spread = distribution_of([run.drop.e for run in used], [run.drop.u_e for run in used])
    about = session.name, session.sample, session.target
    return SessionFindings(*about, series, e_budget, g_budget, site, tuple(excluded), preliminary, spread)


def _why_excluded(run: SeriesRun, left_out: Mapping[str, str]) -> Excluded | None:
    name = run.drop.name
    if name in left_out:
        kind = "preliminary" if left_out[name] == PRELIMINARY else run.drop.origin.mark or "twice"
        return Excluded(name, kind, left_out[name])
    if run.status != "ok":
        return Excluded(name, run.status.replace("_", " "), run.reason)
    if not run.drop.from_rest:
        return Excluded(name, "release not seen", "the rest before the fall was not recorded")
    if run.drop.e is None:
        return Excluded(name, "no valid first bounce", run.reason)
    return None


def _budget(
    found: Statistics, runs: Sequence[SeriesRun], line_of: Callable[[UncertaintyBudget], BudgetLine]
) -> BudgetLine:
    """Return the budget of a mean: its standard error, and what all share, which adds without squares."""
    lines = [line_of(run.budget) for run in runs if run.budget is not None]
    own = found.u_single if found.standard_error is None else found.standard_error

    def mean(parts: Sequence[float | None]) -> float | None:
        # of one run unknown, what all share is unknown
        known = [part for part in parts if part is not None]
        return sum(known) / len(known) if known and len(known) == len(runs) else None

    shares = mean([one.calibration for one in lines]), mean([one.sphere for one in lines])
    return BudgetLine(own, *shares, found.combined)


def _points(session: SeriesSession, counted: Series) -> list[ImpactPoint]:
    # slopes are sought against ln v, weights are 1 / u^2: neither speed nor u may be zero
    return [
        ImpactPoint(
            f"{session.name}/{run.drop.name}",
            impact.speed_before_m_s,
            impact.e,
            impact.u_e,
            impact.u_e_combined if math.isfinite(impact.u_e_combined) else None,
            impact.angle_deg,
            session.setup.tracer.diameter_m,
            number,
            impact.e_t,
            impact.u_e_t,
        )
        for number, run in enumerate(session.runs, 1)
        if f"{session.name}/{run.drop.name}" not in counted.left_out
        for impact in run.impacts
        if impact.valid and math.isfinite(impact.e) and impact.u_e > 0.0 and impact.speed_before_m_s > 0.0
    ]


def _values(session: SeriesSession, found: SessionFindings) -> list[float]:
    seen = {run.drop.name: run.drop.e for run in session.runs}
    return [e for name in found.series.seen if (e := seen[name]) is not None]


def _repeated(
    sessions: Sequence[SeriesSession], counted: Series, fits: Sequence[SpeedFit], model: ModelName
) -> tuple[Repeatability | None, str]:
    """Return the scatter of e within and between sessions, all at one speed, and how they were brought to it."""
    pairs = [
        [
            (run.drop.impact_speed_m_s, run.drop.e)
            for run in one.runs
            if f"{one.name}/{run.drop.name}" in counted.seen and run.drop.e is not None and run.drop.impact_speed_m_s
        ]
        for one in sessions
    ]
    speeds = [speed for group in pairs for speed, _ in group]
    if not speeds or max(speeds) <= (1.0 + _SAME_SPEED) * min(speeds):
        return repeatability_of([[e for _, e in group] for group in pairs]), ""
    fit = next(fit for fit in fits if fit.model == model)
    # a model that does not describe e would move sessions apart that agree
    if fit.problem or fit.describes is False:
        return None, ""
    at = sum(speeds) / len(speeds)
    expected = dict(zip([at, *speeds], fit.e(np.array([at, *speeds]))[0].tolist(), strict=True))
    # by the ratio: what a drop is above the model stays the same share of e
    groups = [[e * expected[at] / expected[speed] for speed, e in group] for group in pairs]
    return repeatability_of(groups), f"at {plain(at, 3, 'm/s')} (brought there by the {title_of(model)})"


def _cautions(sessions: Sequence[SeriesSession], found: Sequence[SessionFindings]) -> list[str]:
    if len(found) < 2:
        return []
    said = []
    antennas = [(one.setup.transmitter, one.setup.receiver) for one in sessions]
    speeds = [one.series.impact_speed_m_s.mean for one in found if one.series.impact_speed_m_s.mean]
    if speeds and max(speeds) > (1.0 + _SAME_SPEED) * min(speeds):
        said.append(
            f"The impact speeds of the sessions differ ({plain(min(speeds), 3)} to {plain(max(speeds), 3, 'm/s')}): a "
            "part of what they differ by may be the dependence of e on the speed."
        )
    if any(one != antennas[0] for one in antennas):
        said.append(
            "The sessions were not recorded with the same antennas: their calibrations differ, which no test of the "
            "scatter knows."
        )
    return said
