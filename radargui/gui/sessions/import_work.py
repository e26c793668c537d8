"""The import itself, in the background: a session is made of the files, and its runs are processed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from radargui.experiment.reprocess import process_run
from radargui.gui.sessions.work_strip import Task
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup
from radargui.session.importing import Import, ImportInput
from radargui.session.info import calibration_of_file


@dataclass(frozen=True, slots=True)
class ImportOrder:
    """What the operator wants; `inputs` looks into the files and so belongs to the background.

    Attributes
    ----------
    inputs
        Returns what to import.
    setup, setup_file
        Antennas and processing, and the file they come from; None where from none.
    process
        Whether the runs are processed.
    """

    inputs: Callable[[], Sequence[ImportInput]]
    setup: Setup
    setup_file: Path | None
    process: bool = True


@dataclass(frozen=True, slots=True)
class Imported:
    """What came of it: the session, None where no file could be read, and what went wrong."""

    session: Path | None
    n_runs: int
    errors: tuple[RadarGuiError, ...]


def carry_out(order: ImportOrder, data_folder: Path, operator: str, task: Task) -> Imported:
    """Import what was ordered.

    Raises
    ------
    RadarGuiError
        The session cannot be made, or the choice is not possible.
    """
    inputs = order.inputs()
    file = order.setup_file
    work = Import(
        data_folder,
        order.setup,
        now=datetime.now().astimezone(),
        operator=operator,
        calibration=calibration_of_file(file) if file else None,
        setup_name=file.stem if file else "",
    )
    half = 0.5 if order.process else 1.0
    outcome = list(work.carry_out(inputs, lambda share: task.tell(half * share)))
    paths = [run.path for run in outcome if run.path is not None]
    errors = [run.error for run in outcome if run.error is not None]
    for done, path in enumerate(paths if order.process else ()):

        def tell(share: float, done: int = done) -> None:
            task.tell(0.5 + 0.5 * (done + share) / len(paths))

        try:
            process_run(path, progress=tell)
        except RadarGuiError as error:
            errors.append(error)
    return Imported(work.session.path if work.session else None, len(paths), tuple(errors))
