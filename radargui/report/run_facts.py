"""Collect what a report says of one run, from its result or from its few stored figures, without samples."""

import logging
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from radargui.files.run_card import read_origin, read_run_card, summarise
from radargui.files.stored_results import read_findings
from radargui.model.channel_quality import ChannelQuality
from radargui.model.drop import Drop, RunOrigin, drop_of, figure_in
from radargui.model.errors import CancelledError, RadarGuiError, fault_of
from radargui.model.plugins import load_plugin, plugins
from radargui.model.recording import Gap
from radargui.model.result import Bounces, RunResult
from radargui.model.rounding import UNKNOWN
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import UncertaintyBudget
from radargui.model.words import counted
from radargui.report.content import Picture
from radargui.report.curves import COLUMNS, COMPACT, Curve, RunCurves, fall_curves, take_curves
from radargui.restitution.site_gravity import SiteCheck, site_check

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_logger = logging.getLogger(__name__)
ResultOf = Callable[[Path, Setup], RunResult]
"""Gives the result of a run file under a setup: stored or computed is not for the report to know."""
FallCurves = tuple[Curve, Curve]


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
    channels, decisions
        Quality of each receiver, and what the correction chose by evidence.
    added
        Pages of plug-ins.
    height
        Of the sphere against time, in m; of its track.
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
    decisions: tuple[str, ...] = ()
    bounces: Bounces = field(default_factory=Bounces)
    site_check: SiteCheck | None = None
    uncertainty_budget: UncertaintyBudget | None = None
    warnings: tuple[str, ...] = ()
    added: tuple[Picture, ...] = field(default=(), repr=False)
    height: Curve | None = field(default=None, repr=False)
    curves: RunCurves | None = field(default=None, repr=False)
    falls: FallCurves | None = field(default=None, repr=False)

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
        said = self.status if self.status != "ok" else str((self.figures or {}).get("verdict") or "ok")
        said = said.replace("_", " ")
        return f"{said}, preliminary" if self.preliminary else said

    @property
    def said(self) -> str:
        """What people read of it: that it is no measurement, where it is none, and how good it is."""
        warnings = (self.figures or {}).get("warnings")
        warned = counted(len(warnings), "warning") if isinstance(warnings, Sequence) and warnings else ""
        return ", ".join(filter(None, (self.source.mark, self.verdict, warned)))

    @property
    def preliminary(self) -> bool:
        """Whether the correction that the setup asks for was stopped, so that a simpler one stands here."""
        return bool((self.figures or {}).get("preliminary"))


def badges(runs: Sequence[RunFacts]) -> str:
    """Return where runs come from, each said once: `SIMULATED, REPLAY`."""
    return ", ".join(dict.fromkeys(run.source.badge for run in runs if run.source.badge))


def all_simulated(runs: Sequence[RunFacts]) -> bool:
    """Return whether there are runs that can be read, and none of them was measured."""
    return {run.source.kind for run in runs} - {"unknown"} == {"simulated"}


def study(path: Path, setup: Setup, result_of: ResultOf, *, detailed: bool = True) -> RunFacts:
    """Take the facts of one run from its result; whatever goes wrong with it becomes its `failure`.

    Parameters
    ----------
    path
        Run file.
    setup
        Of the session.
    result_of
        Gives the result of a run file under a setup: a report shows results and computes none.
    detailed
        Whether curves are to fill the width of a page, else half of it.
    """
    try:
        facts = take_facts(result_of(path, setup), path.stem, COLUMNS if detailed else COMPACT)
        return replace(facts, origin=read_origin(path), source=read_run_card(path).origin)
    except CancelledError:
        raise
    except RadarGuiError as error:
        return _failed(path, error)
    except Exception as error:
        # one run must not cost the report of the others
        _logger.exception("The report of %s failed", path.name)
        return _failed(path, fault_of(error, "The report of this run"))


def in_session(path: Path, error: RadarGuiError) -> str:
    """Return what is wrong with a run; where its session lies on this computer is nothing for a report."""
    return str(error).replace(f"{path.parent}{os.sep}", "")


def _failed(path: Path, error: RadarGuiError) -> RunFacts:
    """Return a run that went wrong, with where it comes from: a simulated one is not measured for that."""
    try:
        source = read_run_card(path).origin
    except RadarGuiError:
        source = RunOrigin("unknown")
    return RunFacts(path.stem, failure=in_session(path, error), source=source)


def take_facts(result: RunResult, name: str, columns: int = COLUMNS) -> RunFacts:
    """Return what the report keeps of a result, its curves decimated to so many columns; none where it is 0."""
    curves = take_curves(result, columns) if columns else None
    drawn = curves.track if curves else None
    falls = (drawn.fallen, drawn.since_vertex) if drawn and drawn.fallen and drawn.since_vertex else None
    recording, corrected, track = result.recording, result.corrected, result.track
    n_lost, rate_hz = sum(gap.count for gap in recording.gaps), recording.digitisation.sample_rate_hz
    return RunFacts(
        name=name,
        status=result.status,
        reason=result.reason,
        figures=summarise(result),
        started_at=recording.started_at,
        duration_s=(recording.n_samples + n_lost) / rate_hz,
        rate_hz=rate_hz,
        n_samples=recording.n_samples,
        device=recording.digitisation.device,
        gaps=recording.gaps_of_whole(),
        correction=corrected.method if corrected else None,
        geometry=track.geometry if track else None,
        from_rest=result.segment is not None and result.segment.has_rest,
        zero_s=result.zero[0],
        since=result.zero[1],
        channels=corrected.channels if corrected else (),
        decisions=corrected.decisions if corrected else (),
        bounces=result.bounces,
        site_check=site_check(result),
        uncertainty_budget=result.uncertainty_budget,
        warnings=result.warnings,
        added=added_pictures(result) if curves is not None else (),
        height=drawn.height if drawn and columns == COMPACT else None,
        curves=curves,
        falls=falls,
    )


def glance(path: Path, normal: tuple[float, float, float]) -> RunFacts:
    """Return what the results stored with a run say, without its samples; whatever goes wrong becomes its `failure`.

    Parameters
    ----------
    path
        Run file.
    normal
        Of the floor by the setup, along which the sphere falls where the result knows none.
    """
    try:
        source, found = read_run_card(path).origin, read_findings(path)
    except RadarGuiError as error:
        return _failed(path, error)
    if found is None:
        return RunFacts(path.stem, failure="not processed yet", source=source)
    summary = found.summary
    falls: FallCurves | None = None
    if found.fall is not None:
        time_s, place_m, fitted = found.fall
        falls = fall_curves(time_s, np.asarray(found.bounces.normal or normal) @ place_m, fitted, COMPACT)[1:]
    return RunFacts(
        path.stem,
        status=str(summary.get("status")),
        reason=str(summary.get("reason") or ""),
        figures=summary,
        source=source,
        from_rest=summary.get("from_rest") is not False,
        bounces=found.bounces,
        uncertainty_budget=found.uncertainty_budget,
        falls=falls,
    )


AddedFigure = Callable[[RunResult], "Callable[[], Figure] | None"]
"""A plug-in of the group `radargui.figures`.

Given a result it returns what draws its figure (`report.plots.new_figure`), or None where there is nothing to draw.
What draws keeps only what the figure needs: a night has many runs.
"""


def added_pictures(result: RunResult) -> tuple[Picture, ...]:
    """Return the figures that plug-ins draw of a result; one that fails is left out and logged."""
    pictures = []
    for name in plugins("figures"):
        try:
            added: AddedFigure = load_plugin("figures", name)
            draw = added(result)
        except Exception:
            # a plug-in must not cost the report
            _logger.exception("The figure %s was left out", name)
            continue
        if draw is not None:
            pictures.append(Picture(name.replace("-", " "), draw))
    return tuple(pictures)
