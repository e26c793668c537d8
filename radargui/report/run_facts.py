"""What the report keeps of each run: figures, quality, curves; or why there is nothing."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from radargui.files.summary import summarise
from radargui.model.block import Gap
from radargui.model.bounce import Bounces, FreeFall
from radargui.model.errors import RadarGuiError
from radargui.model.quality import ChannelQuality
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.result_of_run import result_of_run
from radargui.report.curve_taker import take_curves
from radargui.report.curves import RunCurves

_log = logging.getLogger(__name__)
Progress = Callable[[float], None]


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
    from_rest
        Whether the rest before the motion was recorded: only then is the first impact the first, and its fall whole.
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
    gaps: tuple[Gap, ...] = ()
    correction: str | None = None
    geometry: str | None = None
    from_rest: bool = False
    channels: tuple[ChannelQuality, ...] = ()
    bounces: Bounces = field(default_factory=Bounces)
    calibration_uncertainty: dict[str, float] | None = None
    warnings: tuple[str, ...] = ()
    curves: RunCurves | None = field(default=None, repr=False)

    def figure(self, key: str) -> float | None:
        """Return one number of `figures`; None where it is not known."""
        value = (self.figures or {}).get(key)
        return value if isinstance(value, float) else None

    @property
    def first_e(self) -> float | None:
        """The coefficient of the first impact after the release; None where it is not valid."""
        impacts = self.bounces.impacts
        return impacts[0].e if self.from_rest and impacts and impacts[0].valid else None

    @property
    def fall(self) -> FreeFall | None:
        """The fall from the release to the first impact; None where there is none or its start was not seen."""
        return self.bounces.free_fall if self.from_rest else None

    @property
    def verdict(self) -> str:
        """How good the run is, in one or two words."""
        if self.status != "ok":
            said = self.status.replace("_", " ")
        else:
            said = str((self.figures or {}).get("verdict") or "ok")
        return f"{said}, preliminary" if self.preliminary else said

    @property
    def preliminary(self) -> bool:
        """Whether the correction that the setup asks for was stopped, so that a simpler one stands here."""
        return bool((self.figures or {}).get("preliminary"))


def study(path: Path, setup: Setup, progress: Progress | None = None) -> RunFacts:
    """Read one run, process it where its file holds no result; whatever goes wrong with it becomes its `failure`."""
    try:
        return take_facts(result_of_run(path, setup, progress), path.stem)
    except RadarGuiError as error:
        return RunFacts(path.stem, failure=str(error))
    except (ArithmeticError, LookupError, MemoryError, TypeError, ValueError) as error:
        _log.exception("the report could not process %s", path.name)
        return RunFacts(path.stem, failure=f"the program failed on this run: {type(error).__name__}: {error}")


def take_facts(result: RunResult, name: str) -> RunFacts:
    """Return what the report keeps of a result."""
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
        gaps=recording.gaps,
        correction=corrected.method if corrected else None,
        geometry=track.geometry if track else None,
        from_rest=result.segment is not None and result.segment.has_rest,
        channels=corrected.channels if corrected else (),
        bounces=result.bounces,
        calibration_uncertainty=result.calibration_uncertainty,
        warnings=result.warnings,
        curves=take_curves(result),
    )


def _duration_s(recording: Recording) -> float:
    lost = sum(gap.count for gap in recording.gaps)
    return (recording.n_samples + lost) / recording.digitisation.sample_rate_hz
