"""A session made with a calibration: it keeps a copy, says how old it is, what the first drop says, and reports it."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from support.calibrations import antenna_names, calibration_of, u_of
from support.command_line import Command

from radargui.experiment.calibrating import write_calibration
from radargui.files.run_file import read_run
from radargui.model.calibrated_setup import calibrated
from radargui.model.calibration import read_calibration
from radargui.model.setup import read_setup, write_setup
from radargui.processing.calibration_check import check_calibration
from radargui.processing.process import process
from radargui.report.findings_section import setup_blocks
from radargui.session.info import SCHEMA, read_info
from radargui.session.session import Session

FIRST_TILT = np.eye(10)[0]


@pytest.fixture
def calibrated_file(setup_file: Path) -> Path:
    """The small setup with a calibration in which two distances are known only together."""
    setup = read_setup(setup_file)
    names = antenna_names(setup)
    covariance = np.diag(u_of(names, 0.05, 3e-4) ** 2)
    covariance[2, 5] = covariance[5, 2] = 0.9 * covariance[2, 2]
    made, file = calibration_of(setup, covariance=covariance), setup_file.with_name("november.json")
    write_calibration(file, made)
    write_setup(calibrated(setup, made, file), setup_file)
    return setup_file


def test_a_session_keeps_its_calibration_and_reports_it(command: Command, calibrated_file: Path) -> None:
    folder = calibrated_file.parent
    ended = command("record", "--fast", "--seed", 3, "--setup", calibrated_file, "--output", folder / "sessions")
    assert ended.status == 0, ended
    age = (datetime.now().astimezone() - datetime.fromisoformat("2025-11-03T10:00:00+01:00")).days
    flagged = "days old, more than calibration.max_age_days = 365"
    assert (flagged in ended.err) == (age >= 365)
    assert "Calibration: the calibration of 3 November 2025 still holds: g 9.8" in ended.out
    (session,) = (folder / "sessions").iterdir()
    setup = read_setup(calibrated_file)
    # last year's session does not change with the file
    (folder / "november.json").unlink()
    info = read_info(session)
    assert info.setup.calibration == setup.calibration
    assert info.calibration.file == "calibration.json"
    assert read_calibration(session / "calibration.json").names == antenna_names(setup)
    # an antenna that was pushed since: the same drop says so
    pushed = replace(made := read_calibration(session / "calibration.json"), values=made.values + 2.0 * FIRST_TILT)
    check = check_calibration(
        process(read_run(session / "run-0001.h5"), calibrated(setup, pushed, folder / "november.json"))
    )
    assert check is not None
    assert not check.holds
    assert check.words.startswith("the calibration of 3 November 2025 does not hold: g ")
    text = repr(setup_blocks(info.setup))
    assert "Calibration of 3 November 2025 by A. Operator, good" in text
    assert info.calibration.origin == "november.json: calibration of 3 November 2025 by A. Operator, good"
    assert "receiver[1].distance_m with receiver[2].distance_m: +0.90" in text
    assert "(calibrated" not in text


def test_info_names_the_calibration_of_a_setup(command: Command, calibrated_file: Path) -> None:
    assert "calibration of 3 November 2025 by A. Operator, good" in command("info", "--setup", calibrated_file).out
    text = calibrated_file.read_text(encoding="utf-8").replace("tilt_deg = 40.0", "tilt_deg = 42.0", 1)
    calibrated_file.write_text(text, encoding="utf-8")
    told = command("info", "--setup", calibrated_file).out
    assert "not as calibrated 3 November 2025: receiver[1].tilt_deg = 42.0000 (calibrated 40.0000)" in told


def test_a_session_of_before_opens_as_it_was(tmp_path: Path, setup_file: Path) -> None:
    session = Session.create(tmp_path, read_setup(setup_file), now=datetime.fromisoformat("2026-01-01T00:00:00+00:00"))
    session.close()
    path = session.path / "session.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    del content["calibration"]["file"], content["setup"]["calibration"]
    assert content["schema_version"] == SCHEMA
    path.write_text(json.dumps(content), encoding="utf-8")
    info = read_info(session.path)
    assert info.calibration.file == ""
    assert info.setup == session.setup
