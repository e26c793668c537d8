"""`radargui record`: runs recorded, processed and saved as a session."""

from __future__ import annotations

import json
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from support.command_line import Command
from support.inhibitor import inhibitor
from support.run_contents import read_run_truth, read_summary
from support.small_setups import E

from radargui.files.run_file import read_run, read_run_setup
from radargui.session.session import Session


def only_session(folder: Path) -> Session:
    (path,) = folder.iterdir()
    return Session.open(path)


def test_drops_are_recorded_processed_and_saved_with_their_truth(recorded: Path) -> None:
    session = Session.open(recorded)
    assert [path.name for path in session.run_paths()] == ["run-0001.h5", "run-0002.h5"]
    for path in session.run_paths():
        summary = read_summary(path)
        assert summary is not None
        assert summary["status"] == "ok"
        assert summary["e"] == pytest.approx(E, abs=0.01)
        assert summary["drop_height_m"] == pytest.approx(0.26, abs=0.001)
        assert read_run_setup(path) == session.setup
        assert read_run_truth(path) is not None


def test_runs_of_one_session_differ_in_their_noise(recorded: Path) -> None:
    first, second = (read_run(path) for path in Session.open(recorded).run_paths())
    count = min(first.n_samples, second.n_samples)
    assert not np.array_equal(first.raw[:, :count], second.raw[:, :count])


def test_the_session_is_told_first_and_a_table_of_the_runs_last(command: Command, setup_file: Path) -> None:
    ended = command("record", "--fast", "--setup", setup_file, "--output", setup_file.parent / "out")
    session = only_session(setup_file.parent / "out")
    first, health, *table = ended.out.splitlines()
    assert first == f"Session: {session.path}"
    assert health.startswith("run 1: ")
    assert "none lost" in health
    assert table[0].split("  ")[0] == "run"
    assert all(title in table[0] for title in ("drop height", "impact speed", "e ± u_e", "g", "status"))
    assert table[2].startswith("run-0001")
    assert "m/s²" in table[2]
    assert table[2].rstrip().endswith("ok")
    assert ended.status == 0
    assert not ended.err


def test_without_output_the_session_goes_to_the_users_data_folder(
    command: Command, setup_file: Path, tmp_path: Path
) -> None:
    assert command("record", "--fast", "--seconds", 0.2, "--setup", setup_file).status == 0
    assert only_session(tmp_path / "documents" / "RadarGUI").run_paths()


def test_seconds_records_so_long_without_waiting_for_motion(command: Command, setup_file: Path, tmp_path: Path) -> None:
    ended = command("record", "--fast", "--seconds", 0.25, "--setup", setup_file, "--output", tmp_path / "out")
    (run,) = only_session(tmp_path / "out").run_paths()
    assert ended.status == 0
    assert read_run(run).n_samples == 1000


@pytest.mark.skipif(sys.platform != "linux", reason="the stand-in is Linux's")
def test_the_computer_is_kept_awake_meanwhile(
    command: Command, setup_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = inhibitor(tmp_path / "bin")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=os.pathsep)
    command("record", "--fast", "--seconds", 0.25, "--setup", setup_file, "--output", tmp_path / "out")
    asked, end = log.read_text(encoding="utf-8").splitlines()
    assert asked.startswith("--what=sleep:idle --mode=block --who=RadarGUI")
    assert end == "released"


def test_a_source_that_ends_before_the_seconds_asked_for_is_told(
    command: Command, setup_file: Path, tmp_path: Path
) -> None:
    ended = command("record", "--fast", "--seconds", 30, "--setup", setup_file, "--output", tmp_path / "out")
    (run,) = only_session(tmp_path / "out").run_paths()
    recording = read_run(run)
    long_s = recording.n_samples / recording.digitisation.sample_rate_hz
    assert long_s < 30.0
    told = f"run 1: warning: {long_s:.2f} s were recorded of the 30 s asked for: the source gave no more samples"
    assert told in ended.err
    assert ended.status == 0


def test_release_and_seed_stand_in_the_sessions_setup(command: Command, setup_file: Path, tmp_path: Path) -> None:
    options = ["--seconds", 0.2, "--release", "0.01,-0.02,0.1", "--seed", 7]
    assert command("record", "--fast", "--setup", setup_file, "--output", tmp_path / "out", *options).status == 0
    setup = only_session(tmp_path / "out").setup
    assert setup.tracer.release_position_m == (0.01, -0.02, 0.1)
    assert setup.simulation.seed == 7


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--release", "0,0"], "--release = '0,0', allowed: X,Y,Z, three numbers in m"),
        (["--release", "a,b,c"], "--release = 'a,b,c', allowed: X,Y,Z, three numbers in m"),
        (["--release", "0,0,99"], "tracer.release_position_m[3] = 99.0, allowed: a number from -10 to 10"),
        (["--release", "0,nan,0"], "tracer.release_position_m[2] = nan, allowed: a number from -10 to 10"),
        (["--seed", "-1"], "simulation.seed = -1, allowed: a whole number from 0 up"),
        (["--seconds", "0"], "--seconds = 0, allowed: a number above 0"),
        (["--seconds", "nan"], "--seconds = nan, allowed: a number above 0"),
        (["--source", "replay"], "--source replay and --file FILE go together"),
        (["--file", "x.h5"], "--source replay and --file FILE go together"),
        (["--source", "ni", "--seed", "1"], "--seed = 1, allowed: only with --source simulated"),
        (["--source", "ni", "--fast"], "--fast, allowed: only with"),
        (["--setup", "absent.toml"], "absent.toml"),
    ],
)
def test_a_bad_option_is_one_line_and_status_2_before_anything_is_made(
    command: Command, tmp_path: Path, options: list[str], text: str
) -> None:
    ended = command("record", "--output", tmp_path / "out", *options)
    assert ended.status == 2
    assert text in ended.error
    assert not (tmp_path / "out").exists()


def test_an_output_that_cannot_be_written_is_told_before_recording(
    command: Command, setup_file: Path, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    ended = command("record", "--fast", "--setup", setup_file, "--output", tmp_path / "file")
    assert ended.status == 1
    assert "No session can be made" in ended.error


def test_a_missing_file_to_replay_is_status_1_and_leaves_no_session(command: Command, tmp_path: Path) -> None:
    options = ["--source", "replay", "--file", tmp_path / "absent.csv", "--output", tmp_path / "out"]
    ended = command("record", *options)
    assert ended.status == 1
    assert "absent.csv" in ended.error
    assert not (tmp_path / "out").exists()


def test_a_replayed_run_brings_its_own_setup_and_gives_its_samples_again(
    command: Command, recorded: Path, tmp_path: Path
) -> None:
    run = shutil.copy(recorded / "run-0001.h5", tmp_path)
    options = ["--source", "replay", "--file", run, "--fast", "--seconds", 0.5, "--output", tmp_path / "out"]
    assert command("record", *options).status == 0
    session = only_session(tmp_path / "out")
    (copy,) = session.run_paths()
    assert session.setup == Session.open(recorded).setup
    assert np.array_equal(read_run(copy).raw, read_run(Path(run)).raw[:, :2000])


def test_a_source_in_which_nothing_moves_records_no_run_and_is_status_1(
    command: Command, setup_file: Path, tmp_path: Path
) -> None:
    setup_file.write_text(setup_file.read_text(encoding="utf-8").replace('"drop"', '"rest"'), encoding="utf-8")
    ended = command("record", "--fast", "--setup", setup_file, "--output", tmp_path / "out")
    assert ended.status == 1
    assert "No run was recorded" in ended.error
    assert json.loads((only_session(tmp_path / "out").path / "session.json").read_text(encoding="utf-8"))


def test_hands_free_records_drops_from_one_stream_and_sets_the_hand_aside(command: Command, setup_file: Path) -> None:
    ended = command(
        "record", "--fast", "--hands-free", "--runs", 2, "--setup", setup_file, "--output", setup_file.parent / "out"
    )
    assert ended.status == 0, ended.err
    session = only_session(setup_file.parent / "out")
    assert [path.name for path in session.run_paths()] == ["run-0001.h5", "run-0003.h5"]
    assert list(session.rejected) == ["run-0002.h5"]
    assert "run 2: run-0002.h5: set aside, nothing in it falls freely" in ended.out
    assert [line.split()[0] for line in ended.out.splitlines()[-3:]] == ["run-0001", "run-0002", "run-0003"]
