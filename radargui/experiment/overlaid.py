"""Methods of correction laid over each other on one run: path lengths, height, and what they differ by."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from radargui.experiment.reprocess import computed
from radargui.files.access import Progress
from radargui.files.run_card import summarise
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.result import RunResult
from radargui.model.setup import changed
from radargui.report.decimation import EMPTY, Curve, envelope


@dataclass(frozen=True, slots=True)
class OverlaidMethod:
    """One method on a run, in metres against seconds after `RunResult.zero`.

    Attributes
    ----------
    method
        joint, adaptive, published, ellipse or none.
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
    jumps = (*restarts, *(np.flatnonzero(np.diff(result.recording.index()) > 1) + 1).tolist())
    own, others = _quantities(result), _quantities(reference)
    # a run without the same excerpt has no sample in common
    same = result is not reference and result.recording.n_samples == reference.recording.n_samples
    shared = [name for name in own if same and name in others]
    rest = {name: own[name] - others[name] for name in shared}

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
    run: Path, reference: RunResult, methods: Sequence[str], columns: int, progress: Progress
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
    """
    for number, method in enumerate(methods):
        setup = changed(reference.setup, {"processing.correction": method}, "the method")

        def report(done: float, before: int = number) -> None:
            progress((before + done) / len(methods))

        report(0.0)
        try:
            yield overlaid(computed(run, setup, report), reference, method, columns)
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
