"""Process a run that was just recorded, compare it with the live track, and store the result in its file."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from radargui.files.access import silent
from radargui.files.run_results import write_results
from radargui.live.track import LiveSpan
from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.errors import CancelledError
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import OnPreliminary, cut_short, process
from radargui.session.known_setup import known_front_ends, known_setup_of_run


@dataclass(frozen=True, slots=True)
class LiveAgreement:
    """Live against offline, from the first fringe to the end of the motion.

    Attributes
    ----------
    rms_m, max_m
        Of the distance between the two positions; of the path lengths' differences where there is no track.
    n_compared
        Live estimates that had a counterpart.
    share_known
        Share of the live estimates within the motion that knew where the tracer was.
    """

    rms_m: float
    max_m: float
    n_compared: int
    share_known: float

    def record(self) -> dict[str, object]:
        """Return what is kept in the health record of the run."""
        return {f"live_{name}": value for name, value in asdict(self).items()}


def live_agreement(span: LiveSpan, first_index: int, result: RunResult) -> LiveAgreement | None:
    """Compare the live track of a run with its result.

    Parameters
    ----------
    span
        Live estimates, absolute sample indices.
    first_index
        Absolute index of the run's first sample.
    result
        Of the same run.

    Returns
    -------
    LiveAgreement or None
        None where either knows nothing.
    """
    if result.paths is None or result.segment is None or span.index.size == 0:
        return None
    index = result.recording.index()
    place = np.asarray(np.searchsorted(index, span.index - first_index), dtype=np.intp)
    there: BoolArray = np.asarray(place < index.size)
    there[there] = index[place[there]] == (span.index - first_index)[there]
    # a live track starts when a fringe has passed
    passed = (np.nan_to_num(np.abs(result.paths.change_m)) > result.setup.radar.wavelength_m).any(axis=0)
    there &= (place >= np.argmax(passed)) & (place < result.segment.last)
    if not passed.any() or not there.any():
        return None
    place = place[there]
    valid: BoolArray
    if result.track is not None:
        offline, valid = result.track.position_m[:, place], result.track.valid[place]
        away = np.linalg.norm(span.position_m[:, there] - offline, axis=0)
    else:
        offline, valid = result.paths.change_m[:, place], np.asarray(result.paths.valid[:, place].all(axis=0))
        away = np.abs(_without_zeros(span.change_m[:, there] - offline, result.paths.piece, place, valid)).max(axis=0)
    live_known = np.isfinite(away) | ~np.isfinite(offline).all(axis=0)
    compared: FloatArray = away[np.isfinite(away) & valid]
    if compared.size == 0:
        return None
    return LiveAgreement(
        rms_m=float(np.sqrt(np.mean(compared**2))),
        max_m=float(compared.max()),
        n_compared=int(compared.size),
        share_known=float(np.mean(live_known)),
    )


def _without_zeros(apart_m: FloatArray, piece: IntArray | None, place: IntArray, valid: BoolArray) -> FloatArray:
    """Return differences of paths, shape (n_receivers, n), less their mean in each piece after the first.

    The first counts from the rest in both; where a later one counts from, each knows for itself.
    """
    if piece is None:
        return apart_m
    number, out = piece[place], apart_m.copy()
    for one in range(1, int(number.max()) + 1):
        for row in out:
            known = (number == one) & valid & np.isfinite(row)
            if known.any():
                row[number == one] -= row[known].mean()
    return out


@dataclass(frozen=True, slots=True)
class FinishedJob:
    """A run to process; can be sent to another process.

    Attributes
    ----------
    path
        Run file.
    setup
        Under which it was recorded.
    first_index
        Absolute index of its first sample.
    live
        Live estimates of its time; None where there are none.
    """

    path: Path
    setup: Setup
    first_index: int
    live: LiveSpan | None

    @property
    def has_preliminary(self) -> bool:
        """Whether there will be a preliminary result."""
        return self.setup.processing.correction == "joint"


@dataclass(frozen=True, slots=True)
class BegunJob:
    """A run that is still being recorded, as far as it is; can be sent to another process.

    Attributes
    ----------
    recording
        From the run's first sample on, with nothing lost.
    setup
        Under which it is recorded.
    """

    recording: Recording
    setup: Setup


def early_result(job: BegunJob, progress: Callable[[float], None]) -> RunResult | None:
    """Return what the flights say of a run that is still being recorded; None where they do not tell.

    Parameters
    ----------
    job
        The run.
    progress
        Called now and then; what it raises ends the work.

    Raises
    ------
    ProcessingError
        The samples do not fit the setup.
    """
    # the way of the joint correction: its preliminary result is that of the flights
    joint = job.setup.processing.model_copy(update={"correction": "joint"})
    result = _first_result(job.recording, job.setup.model_copy(update={"processing": joint}), progress)
    return result if result is not None and result.quality is not None and result.quality.method == "flights" else None


def _first_result(recording: Recording, setup: Setup, progress: Callable[[float], None]) -> RunResult | None:
    """Return the preliminary result of a recording, and end the work there; None where there is none."""
    found: list[RunResult] = []

    def enough(share: float) -> None:
        progress(share)
        if found:
            raise CancelledError

    try:
        process(recording, setup, enough, found.append)
    except CancelledError:
        if not found:
            raise
    return found[0] if found else None


def preliminary_result(job: FinishedJob) -> RunResult | None:
    """Return the preliminary result of a run, without computing the final one; None where there is none.

    Raises
    ------
    FileError
        The run cannot be read.
    ProcessingError
        The samples do not fit the setup.
    """
    return _first_result(read_for_processing(job.path), job.setup, silent) if job.has_preliminary else None


def process_finished(
    job: FinishedJob, progress: Callable[[float], None], on_preliminary: OnPreliminary
) -> tuple[RunResult, LiveAgreement | None]:
    """Process a run, keep results and agreement in its file, and return both.

    What earlier runs of its session say about front ends and antennas is its prior.

    Parameters
    ----------
    job
        The run.
    progress
        Called with the share done, 0 to 1. Where it raises `CancelledError`, the preliminary result is kept, within
        a second; where the setup asks for a correction that has none, the work ends at once.
    on_preliminary
        Given the preliminary result, see `process`.

    Raises
    ------
    FileError
        The run cannot be read or written.
    ProcessingError
        The samples do not fit the setup.
    CancelledError
        `progress` did, and there is no preliminary result.
    """
    found: list[RunResult] = []
    cancelled = False

    def checked(fraction: float) -> None:
        nonlocal cancelled
        try:
            progress(fraction)
        except CancelledError:
            cancelled = True
        if cancelled and (found or not job.has_preliminary):
            raise CancelledError

    def keep(result: RunResult) -> None:
        found.append(result)
        on_preliminary(result)

    checked(0.0)
    recording = read_for_processing(job.path)
    try:
        known = known_front_ends(job.path, job.setup), known_setup_of_run(job.path, job.setup)
        result = process(recording, job.setup, checked, keep, *known)
    except CancelledError:
        if not found:
            raise
        result = cut_short(found[0])
    agreement = None if job.live is None else live_agreement(job.live, job.first_index, result)
    write_results(job.path, result, health=None if agreement is None else agreement.record())
    return result, agreement
