"""Show the results of a run side by side: what was set differently, what came of it, methods overlaid."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from radargui.experiment.reprocess import computed, own_setup, process_run
from radargui.files.access import Progress
from radargui.files.run_card import summarise
from radargui.files.stored_results import StoredResult, read_stored_results
from radargui.model.arrays import FloatArray
from radargui.model.drop import figure_in
from radargui.model.errors import ProcessingError
from radargui.model.result import RunResult
from radargui.model.setup import Setup, changed
from radargui.model.setup_error import ChangedSetting, changed_settings
from radargui.report.curves import EMPTY, Curve, envelope

FIGURES = (
    ("e", "u_e", "u_e_combined"),
    ("drop_height_m", "", ""),
    ("impact_speed_m_s", "", ""),
    ("g_m_s2", "u_g_m_s2", "u_g_combined_m_s2"),
)
"""Keys of the summary: a figure, its statistical and its combined standard uncertainty; empty where it has none."""


@dataclass(frozen=True, slots=True)
class Side:
    """One of the two results.

    Attributes
    ----------
    summary
        See `files.run_card.summarise`.
    setup
        What it was made with; None where this version cannot read it.
    """

    summary: Mapping[str, object]
    setup: Setup | None


@dataclass(frozen=True, slots=True)
class ComparedFigure:
    """A figure of both results.

    Attributes
    ----------
    name
        As in the summary.
    before, after
        None where it is not known.
    u_before, u_after
        Standard uncertainties, combined where that is known, else statistical; None where there are none.
    u_difference
        Larger statistical one of the two, which says how many digits the difference has. Samples and antennas are the
        same: what they leave open is common to both, and to add it would be wrong.
    """

    name: str
    before: float | None
    after: float | None
    u_before: float | None = None
    u_after: float | None = None
    u_difference: float | None = None

    @property
    def difference(self) -> float | None:
        """After less before; None where one is not known."""
        return None if self.before is None or self.after is None else self.after - self.before


@dataclass(frozen=True, slots=True)
class RunComparison:
    """Two results of one run.

    Attributes
    ----------
    run
        Run file.
    before, after
        The results.
    """

    run: Path
    before: Side
    after: Side

    @property
    def figures(self) -> tuple[ComparedFigure, ...]:
        """The figures of both."""
        return tuple(self._figure(*keys) for keys in FIGURES)

    def _figure(self, name: str, u: str, u_combined: str) -> ComparedFigure:
        def both(key: str) -> tuple[float | None, float | None]:
            return figure_in(self.before.summary, key), figure_in(self.after.summary, key)

        own = both(u)
        before, after = (alone if whole is None else whole for alone, whole in zip(own, both(u_combined), strict=True))
        largest = max((one for one in own if one is not None), default=None)
        return ComparedFigure(name, *both(name), before, after, largest)

    @property
    def settings(self) -> tuple[ChangedSetting, ...]:
        """What was set differently; empty where one of the setups cannot be read."""
        if self.before.setup is None or self.after.setup is None:
            return ()
        return changed_settings(self.before.setup, self.after.setup)


def compare_stored(run: Path) -> RunComparison | None:
    """Return the result that is stored with a run beside the one before; None where there was none before.

    Raises
    ------
    FileError
        The run cannot be read.
    """
    stored = read_stored_results(run)
    return RunComparison(run, _side(stored[-2]), _side(stored[-1])) if len(stored) > 1 else None


def compare_with(
    run: Path,
    progress: Progress | None = None,
    *,
    setup: Setup | None = None,
    changes: Mapping[str, Any] | None = None,
    keep: bool = False,
) -> RunComparison:
    """Process a run with other settings and return the result beside the one that is stored; the samples stay.

    Parameters
    ----------
    run
        Run file.
    progress
        Called with the share done.
    setup
        Antennas, calibration, processing; None: what the run was recorded with.
    changes
        Keys of it with another value, such as `processing.correction`.
    keep
        Whether the new result takes the place of the stored one, whose figures are kept beside it.

    Raises
    ------
    FileError
        The run cannot be read, or the results not be kept.
    SetupError
        A value is not allowed.
    UsageError
        No setup is given and the run holds none.
    ProcessingError
        The samples do not fit the setup.
    """
    other = changed(setup or own_setup(run), changes or {}, "the other settings")
    stored = read_stored_results(run)
    before = _side(stored[-1] if stored and stored[-1].is_present else computed(run, own_setup(run)))
    after = process_run(run, other, progress=progress) if keep else computed(run, other, progress)
    return RunComparison(run, before, _side(after))


def _side(of: StoredResult | RunResult) -> Side:
    return Side(of.summary if isinstance(of, StoredResult) else summarise(of), of.setup)


@dataclass(frozen=True, slots=True)
class OverlaidMethod:
    """One method on a run, in metres against seconds after `RunResult.zero`.

    Attributes
    ----------
    method
        joint, flights, adaptive, published, ellipse, none, or a plug-in.
    summary
        See `files.run_card.summarise`; empty where it failed.
    curves
        By name: z of the centre, L1, L2, ... as changes of path; those that are not known are left out.
    differences
        Each less that of the reference; empty for the reference itself.
    largest_m
        Largest size of the difference of z; None where z of one is not known.
    problem
        Why there is nothing; empty where there is.
    """

    method: str
    summary: Mapping[str, object]
    curves: Mapping[str, Curve]
    differences: Mapping[str, Curve]
    largest_m: float | None = None
    problem: str = ""


def overlaid(result: RunResult, reference: RunResult, method: str, columns: int) -> OverlaidMethod:
    """Return a result of the samples of a reference beside it, decimated to so many columns."""
    time_s = result.recording.time_s() - reference.zero[0]
    restarts = () if result.paths is None else tuple(result.paths.restarts().tolist())
    jumps = (*restarts, *[samples.start for samples, _ in result.recording.stretches()][1:])
    own, others = _quantities(result), _quantities(reference)
    # a run without the same excerpt has no sample in common
    same = result is not reference and result.recording.n_samples == reference.recording.n_samples
    rest = {name: own[name] - others[name] for name in own if same and name in others}

    def curves(of: Mapping[str, FloatArray]) -> dict[str, Curve]:
        drawn = {name: envelope(time_s, values, jumps, columns) for name, values in of.items()}
        return {name: curve for name, curve in drawn.items() if np.isfinite(curve.y).any()}

    differences = curves(rest)
    z = differences.get("z", EMPTY)
    # of a status that is not ok it says why
    said = result.reason if result.status != "ok" else ""
    largest = z.largest if np.isfinite(z.y).any() else None
    return OverlaidMethod(method, summarise(result), curves(own), differences, largest, said)


def compute_methods(
    run: Path,
    reference: RunResult,
    methods: Sequence[str],
    columns: int,
    progress: Progress,
    compute: Callable[[Path, Setup, Progress], RunResult] = computed,
) -> Iterator[OverlaidMethod]:
    """Yield a run by each of several methods beside a result that is there already; nothing is stored.

    Parameters
    ----------
    run
        Run file.
    reference
        The result that the others are compared with: its setup, but for the correction, is theirs.
    methods
        Names of corrections.
    columns
        See `overlaid`.
    progress
        Called with the share of all that is done; what it raises ends the work.
    compute
        Makes the result of a run with a setup.
    """
    for number, method in enumerate(methods):
        setup = changed(reference.setup, {"processing.correction": method}, "the method")

        def report(done: float, before: int = number) -> None:
            progress((before + done) / len(methods))

        report(0.0)
        try:
            yield overlaid(compute(run, setup, report), reference, method, columns)
        except ProcessingError as error:
            yield OverlaidMethod(method, {}, {}, {}, problem=str(error))


def _quantities(result: RunResult) -> dict[str, FloatArray]:
    """Return z and the changes of path in metres, shape (n_samples,) each; NaN where not valid."""
    found = {}
    if result.track is not None:
        found["z"] = np.where(result.track.valid, result.track.position_m[2], np.nan)
    if result.paths is not None:
        found |= {f"L{number}": one for number, one in enumerate(result.paths.change_m, 1)}
    return found
