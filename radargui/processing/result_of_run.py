"""The result of a run file: the one that is stored with it where that is current, else computed."""

import logging
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from radargui.files.run_file import read_run
from radargui.files.stored_results import read_prior, read_setup_prior, read_stored_results, read_whole_result
from radargui.model.errors import FileError, ProcessingError
from radargui.model.finding import Finding, warn
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.long_recording import read_excerpt, read_for_processing
from radargui.processing.process import process, steps_of

DAMAGED = warn("results_damaged")

_log = logging.getLogger(__name__)


def result_of_run(
    path: Path,
    setup: Setup,
    progress: Callable[[float], None] | None = None,
    on_preliminary: Callable[[RunResult], None] | None = None,
) -> RunResult:
    """Return what `process` gives for a run file, without computing it where the file holds it; nothing is written.

    Stored results count where this version made them of these samples with this setup; also preliminary ones, as they
    are. Damaged ones are computed again, and a warning says so.

    Parameters
    ----------
    path
        Run file.
    setup
        Geometry, correction, release position.
    progress, on_preliminary
        See `process`; not called where nothing is computed.

    Raises
    ------
    FileError
        The run cannot be read.
    ProcessingError
        The samples do not fit the setup.
    """
    damaged: tuple[Finding, ...] = ()
    try:
        if (stored := _stored(path, setup)) is not None:
            return stored
    except FileError as error:
        # where more is damaged than the results, reading the samples says so below
        _log.warning("%s", error)
        damaged = (DAMAGED,)
    # the prior that the stored result had, where there was one: opening a run must not change what it says
    known = read_prior(path, setup), read_setup_prior(path, setup)
    result = process(read_for_processing(path), setup, progress, on_preliminary, *known)
    return replace(result, findings=(*damaged, *result.findings))


def _stored(path: Path, setup: Setup) -> RunResult | None:
    stored = read_whole_result(path, setup, lambda part: read_excerpt(path, part) if part else read_run(path))
    # the steps take a moment to find and much room to store
    return stored and replace(stored, corrected=stored.corrected and replace(stored.corrected, steps=steps_of(stored)))


def stored_or_computed(path: Path, setup: Setup) -> RunResult:
    """Return the result stored with a run file, whatever setup made it; computed with `setup` where there is none.

    A run that was processed again with another setup keeps what came out: it is not undone by whoever reads it.

    Parameters and errors as for `result_of_run`.
    """
    return result_of_run(path, setup_of_result(path) or setup)


def stored_result(path: Path, setup: Setup) -> RunResult:
    """Return the result stored with a run file, whatever setup made it; nothing is ever computed.

    Raises
    ------
    FileError
        The run or its results cannot be read.
    ProcessingError
        This version has made no result of these samples.
    """
    found = _stored(path, setup_of_result(path) or setup)
    if found is None:
        raise ProcessingError(f"{path.name} holds no results of this version", remedy="Process the run again.")
    return found


def setup_of_result(path: Path) -> Setup | None:
    """Return what the present result of a run file was made with; None where it holds none that can be read."""
    # damaged ones are computed again
    with suppress(FileError):
        stored = read_stored_results(path)
        return stored[-1].setup if stored and stored[-1].is_present else None
    return None
