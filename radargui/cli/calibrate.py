"""The command calibrate: the antennas from known motions and from drops, and the check of a calibration by one drop."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import numpy as np
import typer

from radargui.calibration.calibrate import Calibrated, KnownRecording, calibrate
from radargui.calibration.known_path import Trajectory, read_known
from radargui.calibration.unknowns import chosen_groups
from radargui.cli.app import Calibrate
from radargui.cli.bar import progress_bar, show_table
from radargui.cli.setup_choice import own_setup
from radargui.experiment.batch.task import find_runs
from radargui.files.calibration_file import read_calibration, write_calibration
from radargui.files.reading import read_recording
from radargui.model.errors import ProcessingError, RadarGuiError, UsageError
from radargui.model.result import RunResult
from radargui.model.rounding import plain, quantity
from radargui.model.setup import Setup, changed, dump_setup, plain as tables, read_setup, validate_setup, write_setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.offline import process
from radargui.restitution.site_gravity import site_check

FALL = "fall"
COVERAGE = 2.0
"""A calibration holds while g and the sideways drift are within so many standard uncertainties."""


def calibrate_antennas(options: Calibrate) -> int:
    """Calibrate, print what was found, write setup and calibration, and return the exit status.

    Raises
    ------
    UsageError
        Options that do not go together, an output that is there already.
    SetupError
        The setup or a path file cannot be used.
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
    known = {name: None if name == FALL else read_known(Path(name), options.clock) for _, name in files}
    setup = read_setup(options.setup) if options.setup is not None else _setup_of([path for path, _ in files])
    recordings = [_read(path, known[name], setup) for path, name in files]
    now = datetime.now().astimezone().isoformat(timespec="seconds")
    with progress_bar("Calibrating") as progress:
        workers = min(len(recordings), os.cpu_count() or 1)
        found = calibrate(
            recordings, setup, groups, progress=progress, workers=workers, made_at=now, operator=options.operator
        )
    show(found)
    calibration = found.calibration
    if calibration.verdict == "refused":
        raise ProcessingError(f"nothing was written: {calibration.reason}")
    whole = validate_setup(tables(found.setup), str(output))
    # the setup says where its values come from
    if "calibration" in Setup.model_fields:
        whole = changed(whole, {"calibration.file": beside.name}, str(output))
    if options.setup is not None and not output.exists():
        # comments of the setup that was there stay
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(dump_setup(whole, options.setup.read_text(encoding="utf-8-sig")), encoding="utf-8")
    else:
        write_setup(whole, output)
    write_calibration(beside, calibration)
    typer.echo(f"Setup: {output}\nCalibration: {beside}")
    return 0


def show(found: Calibrated) -> None:
    """Print the values, the residuals and the verdict."""
    calibration = found.calibration
    u = np.sqrt(np.diag(calibration.covariance))
    rows = [
        (name, quantity(before, u_before), quantity(value, own))
        for name, before, u_before, value, own in zip(
            calibration.names, calibration.before, calibration.u_before, calibration.values, u, strict=True
        )
    ]
    show_table(("value", "setup", "found"), rows)
    show_table(
        ("residual", "receiver", "before / mm", "now / mm", "left out / mm"),
        [
            (
                one.file,
                str(one.receiver),
                *(plain(1e3 * x, 3) for x in (one.rms_before_m, one.rms_m, one.left_out_rms_m)),
            )
            for one in calibration.residuals
        ],
    )
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
    for file in files:
        setup = own_setup(file)
        if setup is not None:
            return setup
    raise UsageError("no setup: give --setup FILE, or runs that bring theirs")


def _read(path: Path, trajectory: Trajectory | None, setup: Setup) -> KnownRecording:
    brought = own_setup(path)
    recording = read_recording(path) if brought is None else read_for_processing(path)
    if recording.n_receivers != setup.n_receivers:
        raise ProcessingError(
            f"{path} has {recording.n_receivers} IQ pairs, the setup {setup.n_receivers} receivers",
            remedy="Give a setup with as many receivers as the recording has IQ pairs.",
        )
    release = (brought or setup).tracer.release_position_m
    try:
        with path.open("rb") as file:
            checksum = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError as error:
        raise RadarGuiError(f"{path}: {error.strerror or error}") from None
    name = path.stem if brought is None else f"{path.parent.name}/{path.stem}"
    return KnownRecording(recording, name, checksum, trajectory, release)


def _check(run: Path, setup_file: Path | None) -> int:
    """Print whether one drop agrees with the calibration of its setup; 0 where it does, 1 where not."""
    files = [one.path for one in find_runs([run]).runs] if run.is_dir() else [run]
    if len(files) != 1:
        raise UsageError(f"--check {run}: {len(files)} runs, allowed: one")
    setup = read_setup(setup_file) if setup_file is not None else _setup_of(files)
    brought = own_setup(files[0])
    if brought is not None:
        place = {"release_position_m": brought.tracer.release_position_m}
        setup = setup.model_copy(update={"tracer": setup.tracer.model_copy(update=place)})
    with progress_bar("Checking") as progress:
        result = process(
            read_recording(files[0]) if brought is None else read_for_processing(files[0]), setup, progress
        )
    sentence, holds = checked(result, _day(setup, setup_file))
    typer.echo(sentence)
    return 0 if holds else 1


def _day(setup: Setup, setup_file: Path | None) -> str:
    """Return " of DAY" where the setup names its calibration and that is there, else nothing."""
    name = getattr(getattr(setup, "calibration", None), "file", None)
    path = None if name is None or setup_file is None else setup_file.parent / name
    return f" of {read_calibration(path).origin.made_at[:10]}" if path is not None and path.exists() else ""


def checked(result: RunResult, day: str = "") -> tuple[str, bool]:
    """Return "the calibration ... still holds: g ..., drift ..." of one drop, and whether it does.

    The drift is how far the first fall goes sideways, which it should not.

    Raises
    ------
    ProcessingError
        The drop gives no g.
    """
    fall, budget, track = result.bounces.free_fall, result.uncertainty_budget, result.track
    impacts = result.bounces.impacts
    if fall is None or budget is None or track is None or not impacts:
        raise ProcessingError(
            "the drop gives no g to check by" + (f": {result.reason}" if result.reason else ""),
            remedy="Check with a drop that begins at rest and bounces.",
        )
    site = site_check(result)
    # without a site g may be anywhere between equator and poles
    expected, u_expected = (9.81, 0.015) if site is None else (site.expected_m_s2, site.u_expected_m_s2)
    u_g = budget.g_m_s2.combined or fall.u_g_m_s2
    last = int(np.searchsorted(track.time_s, impacts[0].time_s)) - 1
    away = track.position_m[:2, last] - np.array(result.setup.tracer.release_position_m[:2])
    u_drift = float(np.hypot(*track.u_position_m[:2, last]))
    drift = float(np.hypot(*away))
    falls = abs(fall.g_m_s2 - expected) <= COVERAGE * math.hypot(u_g, u_expected)
    straight = drift <= COVERAGE * max(u_drift, 1e-4)
    holds = falls and straight
    return (
        f"the calibration{day} {'still holds' if holds else 'does NOT hold'}: g {quantity(fall.g_m_s2, u_g, 'm/s²')}, "
        f"expected {quantity(expected, u_expected, 'm/s²')}, drift {quantity(drift, u_drift, 'mm', 1e3)}"
    ), holds
