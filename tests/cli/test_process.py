"""`radargui process`: recordings to tables, one folder an input, everything wrong told before any work."""

from __future__ import annotations

import errno
import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.command_line import Called, Command
from support.small_setups import PLATE, E

from radargui.cli.app import Process
from radargui.cli.process import process_files
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import process

TABLES = ["bounces.csv", "motion.csv", "result.json", "track.csv"]


@pytest.fixture
def run(recorded: Path, tmp_path: Path) -> Path:
    """A run file with its own setup, alone in a folder."""
    folder = tmp_path / "here"
    folder.mkdir()
    return Path(shutil.copy(recorded / "run-0001.h5", folder))


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    """The setup of one receiver."""
    path = tmp_path / "plate.toml"
    path.write_text(PLATE, encoding="utf-8")
    return path


def table(path: Path) -> np.ndarray:
    return np.genfromtxt(path, delimiter=",", names=True)


def result(folder: Path) -> dict[str, object]:
    document = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert isinstance(document, dict)
    return document


def write_pair(path: Path, names: tuple[str, str] = ("I1", "Q1")) -> None:
    """Write a CSV in which a plate rests, moves away by 20 cm within a second, and rests, at 500 Hz."""
    time = np.arange(1000) / 500.0
    way = 0.1 * (1.0 - np.cos(np.pi * np.clip(time - 0.5, 0.0, 1.0)))
    phase = 2.0 * np.pi * 2.0 * way / (299_792_458.0 / 9.0e9)
    noise = np.random.default_rng(1).normal(0.0, 1e-3, (2, time.size))
    columns = np.stack([time, np.cos(phase) + noise[0], np.sin(phase) + noise[1]], axis=1)
    np.savetxt(path, columns, fmt="%.6f", delimiter=",", header=f"time_s,{names[0]},{names[1]}", comments="")


def test_a_run_is_processed_with_its_own_setup_into_a_folder_beside_it(command: Command, run: Path) -> None:
    ended = command("process", run)
    folder = run.with_suffix("")
    assert ended.status == 0
    assert sorted(path.name for path in folder.iterdir()) == TABLES
    assert result(folder)["status"] == "ok"
    assert table(folder / "bounces.csv")["e"][0] == pytest.approx(E, abs=0.01)
    assert all(text in ended.out for text in ("run-0001", "ok", str(folder)))


def test_results_that_are_there_need_force(command: Command, run: Path) -> None:
    folder = run.with_suffix("")
    folder.mkdir()
    ended = command("process", run)
    assert ended.status == 2
    assert ended.error == f"Results are there already: {folder}. Give --force to write over them."
    assert not list(folder.iterdir())
    assert command("process", run, "--force").status == 0
    assert sorted(path.name for path in folder.iterdir()) == TABLES


def test_a_folder_is_no_input_and_nothing_is_written_into_it(command: Command, run: Path) -> None:
    for options in ([], ["--force"]):
        ended = command("process", run.parent, *options)
        assert ended.status == 1
        assert ended.error.startswith(f"{run.parent} is a folder, not a file.")
    assert list(run.parent.iterdir()) == [run]


def test_a_file_without_suffix_needs_another_name_for_its_results(
    command: Command, setup_file: Path, tmp_path: Path
) -> None:
    plain = tmp_path / "plain"
    plain.write_bytes(bytes(120))
    layout = ["--raw", "dtype=i2le,channels=6,rate=1000,scale=1e-3", "--channels", "I1=0,Q1=1,I2=2,Q2=3,I3=4,Q3=5"]
    ended = command("process", plain, *layout, "--setup", setup_file, "--force")
    assert ended.status == 2
    assert ended.error == f"The results of {plain} would be a folder of that name. Give --name."
    assert command("process", plain, *layout, "--setup", setup_file, "--name", "other").status == 0


def test_the_correction_and_geometry_of_the_command_line_win(command: Command, run: Path, tmp_path: Path) -> None:
    options = ["--correction", "ellipse", "--geometry", "plane", "--output", tmp_path / "out"]
    assert command("process", run, *options).status == 0
    document = result(tmp_path / "out" / "run-0001")
    assert (document["correction_used"], document["geometry_used"]) == ("ellipse", "plane")


def test_ctrl_c_is_one_line_and_writes_nothing(called: Called, run: Path, tmp_path: Path) -> None:
    def interrupted(recording: Recording, setup: Setup, progress: Callable[[float], None]) -> RunResult:
        progress(0.2)
        raise KeyboardInterrupt

    options = Process(files=[run], correction="joint", output=tmp_path / "out")
    ended = called(lambda: process_files(options, interrupted))
    assert ended.status == 1
    assert ended.error == "interrupted"
    assert not list((tmp_path / "out").glob("**/*.csv"))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--correction", "best"], 'processing.correction = "best", allowed: joint, flights, adaptive, published, '),
        (["--geometry", "flat"], 'processing.geometry = "flat", allowed: exact, plane'),
        (["--rate-hz", "0"], "--rate-hz = 0, allowed: a number above 0"),
        (["--rate-hz", "inf"], "--rate-hz = inf, allowed: a number above 0"),
        (["--name", "a/b"], "'a/b' cannot be the name of a folder"),
        (["--name", ".."], "'..' cannot be the name of a folder"),
        (["--name", ""], "'' cannot be the name of a folder"),
        (["--channels", "I1"], "is not a channel map"),
        (["--setup", "absent.toml"], "absent.toml"),
        (["--name", "x", "other.h5"], "--name = 'x', allowed: with one input only; there are 2"),
    ],
)
def test_a_bad_option_is_one_line_and_status_2_before_any_work(
    command: Command, run: Path, options: list[str], text: str
) -> None:
    ended = command("process", run, *options)
    assert ended.status == 2
    assert text in ended.error
    assert list(run.parent.iterdir()) == [run]


def test_nothing_to_process_is_wrong_usage(command: Command) -> None:
    assert command("process").status == 2


def test_equal_names_are_refused_before_work_whatever_their_case(command: Command, run: Path, tmp_path: Path) -> None:
    other = tmp_path / "RUN-0001.csv"
    shutil.copy(run, other)
    ended = command("process", run, other, "--output", tmp_path / "out")
    assert ended.status == 2
    assert ended.error.startswith(f"Inputs of equal name: {run}, {other}.")
    assert not (tmp_path / "out").exists()


def test_an_input_without_setup_is_refused_before_work(command: Command, run: Path, tmp_path: Path) -> None:
    write_pair(tmp_path / "pair.csv")
    ended = command("process", run, tmp_path / "pair.csv", "--output", tmp_path / "out")
    assert ended.status == 2
    assert ended.error == f"{tmp_path / 'pair.csv'} brings no setup. Give --setup FILE."
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_made_is_told_before_any_work(called: Called, run: Path) -> None:
    options = Process(files=[run], output=run / "results")
    ended = called(lambda: process_files(options, lambda *_: pytest.fail("it was computed")))
    assert ended.status == 1
    assert ended.error == f"{run / 'results' / 'run-0001'} cannot be made: Not a directory. Choose another folder."
    assert list(run.parent.iterdir()) == [run]


@pytest.mark.skipif(os.name == "nt", reason="another length, and another error")
def test_too_long_a_path_is_no_fault_of_the_program(command: Command, run: Path) -> None:
    long = "n" * 300
    for options in ([run, "--name", long], [run, "--output", "/".join(["y" * 200] * 25)], [f"{long}.csv"]):
        ended = command("process", *options)
        assert ended.status == 1
        assert ended.error.endswith("is a longer path than this system allows. Shorten it.")


def test_a_file_without_the_right_to_read_it_does_not_keep_the_others_from_being_processed(
    command: Command, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    locked = tmp_path / "locked.csv"
    locked.write_text("time_s,I1,Q1\n", encoding="utf-8")
    opened = Path.open

    def refused(path: Path, *arguments: Any, **options: Any) -> Any:
        if path == locked:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return opened(path, *arguments, **options)

    # as for somebody who is not the administrator
    monkeypatch.setattr("os.access", lambda path, *_, **__: Path(path) != locked)
    monkeypatch.setattr(Path, "open", refused)
    ended = command("process", locked, run, "--output", tmp_path / "out")
    assert ended.status == 1
    assert f"{locked} cannot be opened: Permission denied." in ended.error
    assert (tmp_path / "out" / "run-0001" / "result.json").exists()


def test_another_rate_than_the_files_own_is_told(command: Command, run: Path, tmp_path: Path) -> None:
    assert command("export", run, "--format", "sigmf", "--output", tmp_path).status == 0
    file = tmp_path / "run-0001.sigmf-meta"
    ended = command("process", file, "--rate-hz", 2000, "--output", tmp_path / "out")
    assert ended.status == 0
    assert f"warning: {file} says 4000 Hz; 2000 Hz is used, as asked with --rate-hz.\n" in ended.err


def test_a_failed_input_is_status_1_and_the_others_are_written(command: Command, run: Path, tmp_path: Path) -> None:
    broken, absent = tmp_path / "broken.h5", tmp_path / "absent.h5"
    broken.write_bytes(b"\x89HDF\r\n\x1a\nand nothing else")
    ended = command("process", broken, run, absent, "--output", tmp_path / "out")
    errors = ended.err.splitlines()
    assert ended.status == 1
    assert [line.partition(str(tmp_path))[0] for line in errors] == ["error: ", "error: "]
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["run-0001"]


def test_an_unforeseen_error_in_one_input_leaves_the_others(called: Called, run: Path, tmp_path: Path) -> None:
    second = Path(shutil.copy(run, run.with_name("second.h5")))

    def fail_first(recording: Recording, setup: Setup, progress: Callable[[float], None]) -> RunResult:
        if recording.name == run.stem:
            raise MemoryError("too much")
        return process(recording, setup, progress)

    options = Process(files=[run, second], output=tmp_path / "out")
    ended = called(lambda: process_files(options, fail_first))
    assert ended.status == 1
    assert ended.error.startswith("run-0001 failed: no memory is left (radargui/cli/process.py, line ")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["second"]


def test_a_recording_that_does_not_fit_the_setup_is_told(command: Command, run: Path, plate: Path) -> None:
    ended = command("process", run, "--setup", plate)
    assert ended.status == 1
    assert "run-0001" in ended.error
    assert "receiver" in ended.error


def test_columns_of_other_names_are_mapped_and_the_name_is_chosen(
    command: Command, plate: Path, tmp_path: Path
) -> None:
    write_pair(tmp_path / "scope.csv", ("CH A", "CH B"))
    options = ["--channels", "I1=CH A,Q1=CH B", "--name", "moved", "--setup", plate]
    assert command("process", tmp_path / "scope.csv", *options).status == 0
    track = table(tmp_path / "moved" / "track.csv")
    assert track.dtype.names == ("time_s", "L1_m", "valid", "piece", "u_L1_m")
    assert track["L1_m"][-1] == pytest.approx(0.4, abs=0.002)


def test_channels_of_several_files_form_one_input_that_needs_a_name(
    command: Command, plate: Path, tmp_path: Path
) -> None:
    write_pair(tmp_path / "a.csv")
    write_pair(tmp_path / "b.csv")
    options = ["--channels", f"I1={tmp_path / 'a.csv'}:I1,Q1={tmp_path / 'b.csv'}:Q1", "--setup", plate]
    assert command("process", *options).status == 2
    assert command("process", *options, "--name", "both").status == 0
    assert table(tmp_path / "both" / "track.csv")["L1_m"][-1] == pytest.approx(0.4, abs=0.002)


def write_binary_pair(path: Path) -> None:
    """Write the pair of `write_pair` as a 12 bit converter would: a header of 8 bytes, I and Q as columns 0 and 3."""
    write_pair(path.with_suffix(".csv"))
    pair = np.loadtxt(path.with_suffix(".csv"), delimiter=",", skiprows=1)[:, 1:]
    table = np.full((len(pair), 4), 2048, dtype="<u2")
    table[:, [0, 3]] = np.rint(2048 + 1500 * pair)
    path.write_bytes(b"\x00\x01\x02\x03\x04\x05\x06\x07" + table.tobytes())


def test_plain_binary_is_processed_as_its_layout_is_told(command: Command, plate: Path, tmp_path: Path) -> None:
    path = tmp_path / "plate.bin"
    write_binary_pair(path)
    raw = ["--raw", "dtype=u2le,channels=4,header=8,rate=500,scale=6.7e-4,offset=-1.37", "--setup", plate]
    assert command("process", path, *raw, "--channels", "I1=0,Q1=3").status == 0
    assert table(tmp_path / "plate" / "track.csv")["L1_m"][-1] == pytest.approx(0.4, abs=0.002)
    ended = command("process", path, *raw, "--force")
    assert (ended.status, "it holds 0, 1, 2, 3" in ended.error) == (1, True)


def test_a_layout_that_cannot_be_is_status_2_and_names_the_key(command: Command, plate: Path, tmp_path: Path) -> None:
    ended = command("process", tmp_path / "a.bin", "--raw", "dtype=u9,channels=2", "--setup", plate)
    assert (ended.status, '--raw: dtype = "u9", allowed: i1, u1' in ended.error) == (2, True)


def test_a_file_of_unknown_kind_is_told_by_its_suffix_and_raw_is_named(command: Command, tmp_path: Path) -> None:
    (tmp_path / "a.dat").write_bytes(bytes(100))
    ended = command("process", tmp_path / "a.dat")
    assert ended.status == 1
    assert "files that end in .dat are not read" in ended.error
    assert "--raw dtype=u2le,channels=5" in ended.error


@pytest.mark.parametrize(("in_setup", "delay_s", "told_by"), [("20e-6", 20e-6, "setup"), (None, 0.0, "assumed 0")])
def test_the_skew_of_the_setup_holds_for_a_file_that_tells_none_and_the_result_says_so(
    command: Command, plate: Path, tmp_path: Path, in_setup: str | None, delay_s: float, told_by: str
) -> None:
    if in_setup is not None:
        plate.write_text(PLATE + f"[daq]\nchannel_skew_s = {in_setup}\n", encoding="utf-8")
    write_pair(tmp_path / "pair.csv")
    assert command("process", tmp_path / "pair.csv", "--setup", plate).status == 0
    document = result(tmp_path / "pair")
    assert (document["channel_skew_s"], document["channel_skew_from"]) == (delay_s, told_by)


def test_a_run_that_knows_its_skew_keeps_it_whatever_the_setup_says(
    command: Command, run: Path, tmp_path: Path
) -> None:
    assert command("process", run).status == 0
    assert result(run.with_suffix(""))["channel_skew_from"] == "file"


def radar_9ghz(folder: Path, kind: str, name: str) -> list[object]:
    """Return the arguments that make two files of the 9 GHz radar one input."""
    pair = ",".join(f"{part}1={folder / 'radar-9ghz' / f'TB2_{kind}_{part}_C.mat'}:src1.Data" for part in "IQ")
    return ["process", "--channels", pair, "--name", name]


def test_the_9_ghz_plate_moves_at_twice_its_speed_and_its_turns_are_no_bounces(
    command: Command, test_data: Path, plate: Path, tmp_path: Path
) -> None:
    arguments = radar_9ghz(test_data, "PRG_9", "plate")
    assert command(*arguments, "--setup", plate, "--output", tmp_path).status == 0
    track = table(tmp_path / "plate" / "track.csv")
    assert result(tmp_path / "plate")["status"] == "ok"
    assert len((tmp_path / "plate" / "bounces.csv").read_text(encoding="utf-8").splitlines()) == 1
    speeds = mid_stroke_speeds(track["time_s"], track["L1_m"])
    assert speeds == pytest.approx([-0.6, 0.6, -0.6, 0.6], rel=0.01)


def mid_stroke_speeds(time: np.ndarray, path: np.ndarray) -> list[float]:
    """Return the speed over the middle 60 % of strokes 2 to 5; they turn round at 3.4 s and every 3.5 s from there."""
    speeds = []
    for start in (3.4, 6.9, 10.4, 13.9):
        stroke = (time >= start) & (time < start + 3.5)
        share = (path - path[stroke][0]) / (path[stroke][-1] - path[stroke][0])
        middle = stroke & (share > 0.2) & (share < 0.8)
        speeds.append(float(np.polyfit(time[middle], path[middle], 1)[0]))
    return speeds


def test_the_9_ghz_noise_is_no_motion_and_that_is_an_answer(
    command: Command, test_data: Path, plate: Path, tmp_path: Path
) -> None:
    ended = command(*radar_9ghz(test_data, "ruido", "noise"), "--setup", plate, "--output", tmp_path)
    assert ended.status == 0
    document = result(tmp_path / "noise")
    assert document["status"] == "no_motion"
    assert document["reason"]
    assert (tmp_path / "noise" / "track.csv").read_text(encoding="utf-8") == "time_s,L1_m,valid,piece,u_L1_m\n"
    assert len((tmp_path / "noise" / "bounces.csv").read_text(encoding="utf-8").splitlines()) == 1
