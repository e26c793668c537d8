"""Processing of a stored run: its results are computed and kept beside its samples."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from radargui.files.run_file import read_run_setup
from radargui.files.run_results import write_results
from radargui.model.errors import UsageError
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.offline import process
from radargui.session.front_ends import known_front_ends


def process_run(
    path: Path,
    setup: Setup | None = None,
    *,
    progress: Callable[[float], None] | None = None,
    standing: Callable[[RunResult], None] | None = None,
) -> RunResult:
    """Process a run file and store the results in it, in place of older ones; its samples are not touched.

    What earlier runs of its session say about the front ends is its prior.

    Parameters
    ----------
    path
        Run file.
    setup
        None: the one it was recorded with.
    progress
        Called with the share done, 0 to 1; what it raises ends the work, and the stored results stay.
    standing
        See `process`.

    Raises
    ------
    FileError
        The run cannot be read or written.
    SetupError
        The setup in the run is not valid for this version.
    UsageError
        No setup was given and the run holds none.
    ProcessingError
        The samples do not fit the setup.
    """
    recording = read_for_processing(path)
    chosen = setup or own_setup(path)
    result = process(recording, chosen, progress, standing, known_front_ends(path, chosen))
    write_results(path, result)
    return result


def own_setup(path: Path) -> Setup:
    """Return the setup a run was recorded with.

    Raises
    ------
    UsageError
        It holds none.
    """
    setup = read_run_setup(path)
    if setup is None:
        raise UsageError(f"{path} holds no setup", remedy="Name a setup file with --setup.")
    return setup
