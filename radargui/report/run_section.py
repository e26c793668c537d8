"""The report's section on one run: what it keeps of the run, said in words and tables; then pictures."""

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import isfinite
from pathlib import Path

from radargui.files.access import Progress
from radargui.files.run_card import read_origin, read_run_card, summarise
from radargui.files.stored_results import read_findings
from radargui.model.drop import Drop, RunOrigin, drop_of, figure_in
from radargui.model.errors import CancelledError, RadarGuiError, fault_of
from radargui.model.recording import Gap, Recording
from radargui.model.result import Bounces, ChannelQuality, RunResult
from radargui.model.rounding import UNKNOWN, alone, plain, quantity
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import UncertaintyBudget, budget_rows, variance_shares
from radargui.report.added_pictures import added_pictures
from radargui.report.curves import COLUMNS, COMPACT, Curve, RunCurves, take_curves
from radargui.report.document import Chapter, Content, Drawing, Facts, Grid, Note, Picture
from radargui.restitution.site_gravity import SiteCheck, site_check

_logger = logging.getLogger(__name__)
ResultOf = Callable[[Path, Setup, Progress | None], RunResult]
"""Gives the result of a run file under a setup: stored or computed is not for the report to know."""


@dataclass(frozen=True, slots=True)
class RunFacts:
    """One run without its samples.

    Attributes
    ----------
    name
        Stem of the run file.
    failure
        Why the run could not be read or processed; empty where it could.
    status, reason
        Of the result; status is "failed" where there is none.
    figures
        What `summarise` says: drop height, impact speed, e, g and their uncertainties, verdict.
    started_at, duration_s, rate_hz, n_samples, device
        Of the recording; None or empty where it could not be read.
    origin
        Of an imported run: the file and the program it comes from; empty for recorded ones.
    source, label
        Where the samples come from, and what the drop is called, see `restitution.series`.
    from_rest
        Whether the rest before the motion was recorded: only then is the first impact the first, and its fall whole.
    zero_s, since
        What times shown to people count from, see `RunResult.zero`.
    falls
        Way fallen and residual of the first fall, see `TrackCurves`.
    """

    name: str
    failure: str = ""
    status: str = "failed"
    reason: str = ""
    figures: dict[str, object] | None = None
    started_at: str = ""
    duration_s: float | None = None
    rate_hz: float | None = None
    n_samples: int | None = None
    device: str = ""
    origin: str = ""
    source: RunOrigin = field(default_factory=RunOrigin)
    label: str = UNKNOWN
    gaps: tuple[Gap, ...] = ()
    correction: str | None = None
    geometry: str | None = None
    from_rest: bool = False
    zero_s: float = 0.0
    since: str = "the first sample"
    channels: tuple[ChannelQuality, ...] = ()
    bounces: Bounces = field(default_factory=Bounces)
    site_check: SiteCheck | None = None
    uncertainty_budget: UncertaintyBudget | None = None
    warnings: tuple[str, ...] = ()
    added: tuple[Picture, ...] = field(default=(), repr=False)
    curves: RunCurves | None = field(default=None, repr=False)
    falls: tuple[Curve, Curve] | None = field(default=None, repr=False)

    def figure(self, key: str) -> float | None:
        """Return one number of `figures`; None where it is not known."""
        return figure_in(self.figures, key)

    @property
    def drop(self) -> Drop:
        """What a series knows of it."""
        return drop_of(self.name, self.source, self.figures)

    @property
    def verdict(self) -> str:
        """How good the run is, in one or two words."""
        if self.status != "ok":
            said = self.status.replace("_", " ")
        else:
            said = str((self.figures or {}).get("verdict") or "ok")
        return f"{said}, preliminary" if self.preliminary else said

    @property
    def said(self) -> str:
        """What people read of it: that it is no measurement, where it is none, and how good it is."""
        return ", ".join(filter(None, (self.source.mark, self.verdict)))

    @property
    def preliminary(self) -> bool:
        """Whether the correction that the setup asks for was stopped, so that a simpler one stands here."""
        return bool((self.figures or {}).get("preliminary"))


def all_simulated(runs: Sequence[RunFacts]) -> bool:
    """Return whether there are runs, and none of them was measured."""
    return bool(runs) and all(run.source.kind == "simulated" for run in runs)


def study(
    path: Path, setup: Setup, result_of: ResultOf, progress: Progress | None = None, *, detailed: bool = True
) -> RunFacts:
    """Take the facts of one run from its result; whatever goes wrong with it becomes its `failure`.

    Parameters
    ----------
    path
        Run file.
    setup
        Of the session.
    result_of
        Gives the result of a run file under a setup: a report shows results and computes none.
    progress
        Called with the share done, 0 to 1.
    detailed
        Whether curves are to fill the width of a page, else half of it.
    """
    try:
        facts = take_facts(result_of(path, setup, progress), path.stem, COLUMNS if detailed else COMPACT)
        return replace(facts, origin=read_origin(path), source=read_run_card(path).origin)
    except CancelledError:
        raise
    except RadarGuiError as error:
        return RunFacts(path.stem, failure=str(error))
    except Exception as error:
        # one run must not cost the report of the others
        _logger.exception("The report of %s failed", path.name)
        return RunFacts(path.stem, failure=str(fault_of(error, "The report of this run")))


def take_facts(result: RunResult, name: str, columns: int = COLUMNS) -> RunFacts:
    """Return what the report keeps of a result, its curves decimated to so many columns; none where it is 0."""
    curves = take_curves(result, columns) if columns else None
    drawn = curves.track if curves else None
    falls = (drawn.fallen, drawn.since_vertex) if drawn and drawn.fallen and drawn.since_vertex else None
    recording, corrected, track = result.recording, result.corrected, result.track
    return RunFacts(
        name=name,
        status=result.status,
        reason=result.reason,
        figures=summarise(result),
        started_at=recording.started_at,
        duration_s=_duration_s(recording),
        rate_hz=recording.digitisation.sample_rate_hz,
        n_samples=recording.n_samples,
        device=recording.digitisation.device,
        gaps=recording.gaps_of_whole(),
        correction=corrected.method if corrected else None,
        geometry=track.geometry if track else None,
        from_rest=result.segment is not None and result.segment.has_rest,
        zero_s=result.zero[0],
        since=result.zero[1],
        channels=corrected.channels if corrected else (),
        bounces=result.bounces,
        site_check=site_check(result),
        uncertainty_budget=result.uncertainty_budget,
        warnings=result.warnings,
        added=added_pictures(result) if curves is not None else (),
        curves=curves,
        falls=falls,
    )


def glance(path: Path) -> RunFacts:
    """Return what the results stored with a run say, without its samples; whatever goes wrong becomes its `failure`."""
    try:
        found, source = read_findings(path), read_run_card(path).origin
    except RadarGuiError as error:
        return RunFacts(path.stem, failure=str(error))
    if found is None:
        return RunFacts(path.stem, failure="not processed yet", source=source)
    summary = found.summary
    return RunFacts(
        path.stem,
        status=str(summary.get("status")),
        reason=str(summary.get("reason") or ""),
        figures=summary,
        source=source,
        from_rest=summary.get("from_rest") is not False,
        bounces=found.bounces,
        uncertainty_budget=found.uncertainty_budget,
    )


def _duration_s(recording: Recording) -> float:
    lost = sum(gap.count for gap in recording.gaps)
    return (recording.n_samples + lost) / recording.digitisation.sample_rate_hz


def run_section(run: RunFacts, setup: Setup) -> Chapter:
    """Return all that is said of one run, with pages of figures; of a run that failed it says why."""
    if run.failure:
        return Chapter(_title(run), (Note(f"No result: {run.failure}", warning=True),))
    return Chapter(_title(run), _words(run), _pictures(run, setup))


_MOST_IMPACTS, _MOST_LETTERS = 6, 300
"""On the page of a run; more stands in the tables."""


def run_page(run: RunFacts) -> Chapter:
    """Return one page about a run: what it gave, in small print, and its figures."""
    if run.failure or run.curves is None:
        return Chapter(_title(run), (Note(f"No result: {run.failure or 'no samples'}", warning=True),))
    # matplotlib is loaded only where a report is made: the window shows the same words without it
    from radargui.report.run_page import run_figures, run_on_screen

    rows = {
        "Result": " – ".join(part for part in (run.said, run.reason) if part),
        "Recorded": "; ".join(
            filter(None, (run.started_at, run.origin or run.device or run.source.file, _samples(run)))
        ),
        "Correction, geometry": f"{run.correction or UNKNOWN}, {run.geometry or UNKNOWN}",
        **_fall_rows(run, "First fall" if run.from_rest else "Flight before the first impact seen"),
    }
    shown = replace(run, bounces=replace(run.bounces, impacts=run.bounces.impacts[:_MOST_IMPACTS]))
    notes = [*run.warnings, *_more_impacts(run), *(f"{gap} samples were lost." for gap in _lost(run))]
    blocks: list[Content] = [
        Facts(tuple((name, _cut(value)) for name, value in rows.items() if value)),
        *(replace(block, title="") for block in _impacts(shown) if isinstance(block, Grid)),
        *(replace(block, title="") for block in _quality(run) if isinstance(block, Grid)),
        *([Note(_cut(" ".join(f"{note.rstrip('.')}." for note in notes)), warning=True)] if notes else []),
        Drawing("", partial(run_figures, curves=run.curves)),
    ]
    screen = (*_words(run), Drawing("", partial(run_on_screen, curves=run.curves), 52.0))
    return Chapter(_title(run), tuple(blocks), run.added, small=True, screen=screen)


def _cut(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _MOST_LETTERS else f"{line[: _MOST_LETTERS - 1]}…"


def _more_impacts(run: RunFacts) -> list[str]:
    more = len(run.bounces.impacts) - _MOST_IMPACTS
    return [f"{more} more impacts are in report.csv."] if more > 0 else []


def _lost(run: RunFacts) -> list[int]:
    return [sum(gap.count for gap in run.gaps)] if run.gaps else []


def _title(run: RunFacts) -> str:
    mark = f" ({run.said})" if run.status != "ok" or run.source.mark or run.preliminary else ""
    return f"Run {run.name.removeprefix('run-')}{mark}"


def _samples(run: RunFacts) -> str:
    return f"{run.n_samples} of each channel in {plain(run.duration_s, 4, 's')} at {plain(run.rate_hz, 6, '1/s')}"


def _words(run: RunFacts) -> tuple[Content, ...]:
    rows = {
        "Recorded": run.started_at or UNKNOWN,
        "Replay of": run.source.file,
        "Samples": _samples(run),
        "Imported from": run.origin,
        "Device": run.device or ("" if run.origin else UNKNOWN),
        "Result": " – ".join(part for part in (run.said, run.reason) if part),
        "Correction, geometry": f"{run.correction or UNKNOWN}, {run.geometry or UNKNOWN}",
        **_fall_rows(run, "First fall" if run.from_rest else "Flight before the first impact seen"),
    }
    blocks: list[Content] = [Facts.of(rows)]
    blocks += [Note(text, warning=True) for text in run.warnings]
    if run.site_check and run.site_check.agrees is False:
        blocks.append(Note("g is not that of the site: see the comparison above.", warning=True))
    return *blocks, *_impacts(run), *_quality(run), *_gaps(run), *_calibration(run)


def _fall_rows(run: RunFacts, name: str) -> dict[str, str]:
    fall = run.bounces.free_fall
    if fall is None:
        return {name: "none that can be fitted"}
    span = f"{fall.first_time_s - run.zero_s:.4f} s to {fall.last_time_s - run.zero_s:.4f} s after {run.since}"
    release = f"from a height of {plain(fall.release_height_m, 5, 'mm', 1e3)}, fitted {span}"
    drop = f"{plain(fall.drop_height_m, 5, 'mm', 1e3)} " if isfinite(fall.drop_height_m) else ""
    return {
        name: f"{drop}{release}",
        "g (statistical u)": quantity(fall.g_m_s2, fall.u_g_m_s2, "m/s²"),
        "g against the site": run.site_check.compared if run.site_check else "",
        "Residual of the fit": f"{plain(fall.residual_rms_m, 3, 'mm', 1e3)} rms",
    }


def _impacts(run: RunFacts) -> list[Content]:
    if not run.bounces.impacts:
        # without a track nobody looked for one
        return [Note("No impact was found.")] if run.geometry else []
    rows = (
        {
            "impact": str(number),
            f"time after {run.since} / s": f"{impact.time_s - run.zero_s:.5f}",
            "speed before / (m/s)": plain(impact.speed_before_m_s, 5),
            "speed after / (m/s)": plain(impact.speed_after_m_s, 5),
            "e": quantity(impact.e, impact.u_stated),
            "statistical u": plain(impact.u_e, 2),
            # no digits beyond those that the fit supports
            "e of flight time": alone(impact.e_flight_time, impact.u_stated),
            "e of height": alone(impact.e_height, impact.u_stated),
            "valid": "yes" if impact.valid else "no",
            "method": impact.method,
        }
        for number, impact in enumerate(run.bounces.impacts, 1)
    )
    return [Grid.of(rows, "Impacts", left=(0, 8, 9))]


def _quality(run: RunFacts) -> list[Content]:
    if not run.channels:
        return []
    rows = (
        {
            "receiver": channel.name,
            "SNR / dB": plain(channel.snr_db, 3),
            "circularity": plain(channel.circularity, 2),
            "image rejection / dB": plain(channel.image_rejection_db, 3),
            "fringes": plain(channel.fringes, 3),
            "valid": _percent(channel.fraction_valid),
            "clipped": _percent(channel.fraction_clipped),
            "gain Q/I": quantity(channel.gain_ratio, channel.u_gain_ratio),
            "quadrature / °": quantity(channel.quadrature_error_deg, channel.u_quadrature_error_deg),
            "verdict": channel.verdict,
        }
        for channel in run.channels
    )
    said = " ".join((run.reason, *run.warnings))
    reasons = [
        Note(f"Receiver {channel.name}: {channel.reason}") for channel in run.channels if channel.reason not in said
    ]
    return [Grid.of(rows, "Quality of the receivers", left=(0, 9)), *reasons]


def _percent(share: float | None) -> str:
    return UNKNOWN if share is None else f"{100.0 * share:.3g} %"


def _gaps(run: RunFacts) -> list[Content]:
    if not run.gaps or not run.rate_hz:
        return []
    rate = run.rate_hz
    rows = (
        {
            f"from / s after {run.since}": f"{gap.first_index / rate - run.zero_s:.5f}",
            "samples of each channel": str(gap.count),
            "length / ms": plain(gap.count / rate, 3, scale=1e3),
            "reason": gap.reason or UNKNOWN,
        }
        for gap in run.gaps
    )
    return [Grid.of(rows, "Lost samples", left=(3,))]


def _calibration(run: RunFacts) -> list[Content]:
    if run.uncertainty_budget is None:
        return []
    header, *rows = budget_rows(run.uncertainty_budget)
    grid = Grid(header, tuple(rows), "Standard uncertainties", left=(0,))
    shares = [
        f"{name}: " + ", ".join(f"{share} {100.0 * part:.0f} %" for share, part in variance_shares(line).items())
        for name, line in (("e", run.uncertainty_budget.e), ("g", run.uncertainty_budget.g_m_s2))
        if variance_shares(line)
    ]
    notes = [Note(f"Shares of the squares. {'; '.join(shares)}.")] if shares else []
    if run.uncertainty_budget.assumed:
        said = ", ".join(f"{key} {plain(u, 2)}" for key, u in run.uncertainty_budget.assumed.items())
        notes.append(Note(f"Assumed, because the setup does not say: {said}."))
    return [grid, *notes]


def _pictures(run: RunFacts, setup: Setup) -> tuple[Picture, ...]:
    curves = run.curves
    if curves is None:
        return run.added
    # matplotlib is loaded only where a report is made: the window shows the same words without it
    from radargui.report.run_figures import paths_page, signals_page, steps_page, track_page

    pictures = [Picture("raw and corrected IQ" if run.correction else "raw IQ", partial(signals_page, curves))]
    if any(receiver.steps for receiver in curves.receivers):
        pictures.append(Picture("steps of the published correction", partial(steps_page, curves)))
    if any(receiver.phase.largest for receiver in curves.receivers):
        pictures.append(Picture("phase and path length", partial(paths_page, curves)))
    if curves.track is not None and curves.track.places_m.size:
        pictures.append(Picture("track", partial(track_page, curves, curves.track, setup.floor.height_m)))
    return (*pictures, *run.added)
