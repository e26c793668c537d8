"""The command calibrate: antennas from known motions and drops, and the check of a calibration by one drop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import typer

from radargui.calibration.unknowns import chosen_groups
from radargui.cli.app import Calibrate
from radargui.cli.bar import progress_bar, show_table
from radargui.experiment.batch import find_runs
from radargui.experiment.calibrating import CalibrationOrder, calibrate_files, write_calibration
from radargui.files.access import Progress, want_room_for
from radargui.files.formats import own_setup_of
from radargui.model.calibrated_setup import calibrated
from radargui.model.calibration import Calibration
from radargui.model.errors import ProcessingError, UsageError
from radargui.model.rounding import plain, quantity
from radargui.model.setup import Setup, read_setup, write_setup
from radargui.processing.calibration_check import check_calibration
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import process


def calibrate_antennas(
    options: Calibrate, calibrate: Callable[[CalibrationOrder, Progress], Calibration] = calibrate_files
) -> int:
    """Calibrate, print what was found, write setup and calibration, and return the exit status.

    Parameters
    ----------
    options
        Of the command.
    calibrate
        Finds the antennas.

    Raises
    ------
    UsageError
        Options that do not go together, an output that is there already.
    SetupError
        The setup or a path file cannot be used.
    FileError
        The output cannot be written.
    ProcessingError
        The recordings do not fit what is known of them.
    """
    if options.check is not None:
        return _check(options.check, options.setup)
    if not options.files or not options.known or options.output is None:
        raise UsageError("calibrate needs FILE..., --known and --output (or --check RUN)")
    output, beside = options.output, options.output.with_suffix(".calibration.json")
    there = [path for path in (output, beside) if path.exists()]
    if there and not options.force:
        raise UsageError(f"{there[0]} is there already; --force writes over it")
    groups = chosen_groups(options.free)
    files = _files(options.files, options.known)
    recordings, known = zip(*files, strict=True)
    setup = read_setup(options.setup) if options.setup is not None else _setup_of(recordings)
    # before the work, which takes minutes
    want_room_for(output)
    order = CalibrationOrder(recordings, known, setup, groups, options.operator, options.clock)
    with progress_bar("Calibrating") as progress:
        calibration = calibrate(order, progress)
    show(calibration)
    if calibration.verdict == "refused":
        raise ProcessingError(f"nothing was written: {calibration.reason}")
    whole = calibrated(setup, calibration, beside)
    write_calibration(beside, calibration, force=options.force)
    write_setup(whole, output, like=options.setup)
    typer.echo(f"Setup: {output}\nCalibration: {beside}")
    return 0


def show(calibration: Calibration) -> None:
    """Print the values, the residuals and the verdict."""
    u = np.sqrt(np.diag(calibration.covariance))
    before, after = zip(calibration.before, calibration.u_before, strict=True), zip(calibration.values, u, strict=True)
    rows = [
        (name, quantity(*old), quantity(*new)) for name, old, new in zip(calibration.names, before, after, strict=True)
    ]
    show_table(("value", "setup", "found"), rows)
    residuals = [(one, (one.rms_before_m, one.rms_m, one.left_out_rms_m)) for one in calibration.residuals]
    left = [(one.file, str(one.receiver), *(plain(1e3 * rms, 3) for rms in all_m)) for one, all_m in residuals]
    show_table(("residual", "receiver", "before / mm", "now / mm", "left out / mm"), left)
    typer.echo(f"{calibration.verdict}: {calibration.reason}. {'; '.join(calibration.notes)}.")


def _files(paths: Sequence[Path], known: Sequence[str]) -> list[tuple[Path, str]]:
    """Return each recording with what is known of it; a session stands for its runs."""
    if len(known) not in (1, len(paths)):
        raise UsageError(
            f"{len(paths)} FILEs and {len(known)} times --known, allowed: --known once for all, or once for each FILE"
        )
    out = []
    for path, name in zip(paths, list(known) * (len(paths) if len(known) == 1 else 1), strict=True):
        if not path.is_dir():
            out.append((path, name))
            continue
        found = find_runs([path])
        if found.errors:
            raise found.errors[0]
        out += [(run.path, name) for run in found.runs]
    return out


def _setup_of(files: Sequence[Path]) -> Setup:
    setup = next(filter(None, map(own_setup_of, files)), None)
    if setup is None:
        raise UsageError("no setup: give --setup FILE, or runs that bring theirs")
    return setup


def _check(run: Path, setup_file: Path | None) -> int:
    """Print whether one drop agrees with the calibration of its setup; 0 where it does, 1 where not."""
    files = [one.path for one in find_runs([run]).runs] if run.is_dir() else [run]
    if len(files) != 1:
        raise UsageError(f"--check {run}: {len(files)} runs, allowed: one")
    setup = read_setup(setup_file) if setup_file is not None else _setup_of(files)
    brought = own_setup_of(files[0])
    if brought is not None:
        place = {"release_position_m": brought.tracer.release_position_m}
        setup = setup.model_copy(update={"tracer": setup.tracer.model_copy(update=place)})
    with progress_bar("Checking") as progress:
        result = process(read_for_processing(files[0]), setup, progress)
    check = check_calibration(result)
    if check is None:
        raise ProcessingError(
            "the drop gives no g to check by" + (f": {result.reason}" if result.reason else ""),
            remedy="Check with a drop that begins at rest and bounces.",
        )
    typer.echo(f"{check.words[0].upper()}{check.words[1:]}")
    return 0 if check.holds else 1
