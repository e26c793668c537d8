"""What ends the program from outside closes the run first; what is not writable or taken away is told in one line."""

from __future__ import annotations

import os
import shutil
import signal
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from support.command_line import Command
from support.killing import ROOT
from support.small_setups import E, small_setup_text

from radargui.files.run_file import read_run

RATE_HZ = 4000.0
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals of another system")


def record_until(
    folder: Path, seconds: float, act: Callable[[int, Path], None], processing: str = "here"
) -> tuple[int, str, Path]:
    """Record in a child, act on its process or session when it has read so much; return status, errors, session."""
    setup = folder / "small.toml"
    # the scene lasts as long as the recording
    text = small_setup_text().replace(f"restitution = {E}", f"restitution = {E}\nsettle_s = 2.0")
    setup.write_text(text, encoding="utf-8")
    reader, writer = os.pipe()
    arguments = ["record", "--seconds", "3.2", "--setup", str(setup), "--output", str(folder / "data")]
    command = [sys.executable, "-m", "support.ended_child", str(writer), processing, *arguments]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "tests"), str(ROOT)]), "HOME": str(folder)}
    with (
        subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment, pass_fds=[writer]
        ) as child,
        open(reader, "rb", buffering=0) as told,  # noqa: PTH123  a descriptor
    ):
        os.close(writer)
        while len(count := told.read(8)) == 8 and struct.unpack("<q", count)[0] < seconds * RATE_HZ:
            continue
        (session,) = (folder / "data").iterdir()
        act(child.pid, session)
        while told.read(4096):
            continue
        assert child.stderr is not None
        errors = child.stderr.read()
    return child.returncode, errors, session


@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, signal.SIGTERM, pytest.param(signal.SIGHUP, marks=pytest.mark.slow)],
    ids=lambda number: number.name,
)
def test_what_ends_the_program_closes_the_run_as_ctrl_c_does(tmp_path: Path, number: signal.Signals) -> None:
    processing = "apart" if number == signal.SIGINT else "here"
    status, errors, session = record_until(tmp_path, 1.2, lambda process, _: os.kill(process, number), processing)
    assert status == 1
    assert f"interrupted in run 1. What was recorded is kept in {session}." in errors
    assert "Traceback" not in errors
    (run,) = session.glob("*.h5")
    assert read_run(run).n_samples >= 1.0 * RATE_HZ
    assert not (session / "session.lock").exists()


def test_a_session_folder_deleted_while_recording_is_told_and_the_rest_recorded_anew(tmp_path: Path) -> None:
    status, errors, session = record_until(tmp_path, 1.2, lambda _, session: shutil.rmtree(session))
    run = session / "run-0001.h5"
    assert status == 0
    assert f"{run} was deleted or moved while it was being recorded" in errors
    assert f"The recording goes on in {run}." in errors
    assert read_run(run).n_samples >= 1.5 * RATE_HZ
    assert (session / "session.json").is_file()


def test_a_run_file_cut_while_recording_is_told_and_the_rest_recorded_into_another(tmp_path: Path) -> None:
    _, errors, session = record_until(tmp_path, 1.2, lambda _, session: os.truncate(session / "run-0001.h5", 100))
    assert f"{session / 'run-0001.h5'} was cut off while it was being recorded" in errors
    assert read_run(session / "run-0002.h5").n_samples >= 1.5 * RATE_HZ


def test_a_device_that_cannot_be_started_leaves_no_empty_session(command: Command, tmp_path: Path) -> None:
    ended = command("record", "--source", "ni", "--output", tmp_path / "data")
    assert ended.status == 1
    assert not list((tmp_path / "data").iterdir())
    assert "was taken away again" in ended.err


def test_a_home_that_cannot_be_written_is_one_line_and_the_command_goes_on(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    home = str(tmp_path / "file" / "home")
    environment = {key: value for key, value in os.environ.items() if not key.startswith("XDG_")}
    environment |= {"HOME": home, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "radargui", "process", str(tmp_path / "absent.csv")]
    ended = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    notes, error = ended.stderr.splitlines()
    assert notes.startswith("note: no log is kept: ")
    assert error.startswith(f"error: {tmp_path / 'absent.csv'}: no such file.")
