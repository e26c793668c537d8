"""`radargui batch`: all runs, each told; goes on where it was interrupted; here or on a cluster."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from support.command_line import Command
from support.dask_cluster import dask_cluster
from support.run_contents import read_summary
from support.stored_runs import results_digest, store_runs

from radargui.experiment.reprocess import process_run

HELD_BATCH = Path(__file__).parents[1] / "support" / "held_batch.py"


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A session folder with three runs."""
    store_runs(tmp_path / "data" / "monday", 3)
    return tmp_path / "data" / "monday"


def started(folder: Path, *arguments: object, program: tuple[str, ...] = ("-m", "radargui")) -> subprocess.Popen[str]:
    """Start the command in a process and a process group of its own."""
    own = {name: str(folder) for name in ("XDG_STATE_HOME", "XDG_CONFIG_HOME", "LOCALAPPDATA", "HOME", "USERPROFILE")}
    return subprocess.Popen(
        [sys.executable, *program, "batch", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        env={**os.environ, **own, "PYTHONIOENCODING": "utf-8"},
        start_new_session=True,
    )


def test_all_runs_are_processed_and_a_second_time_nothing_is_left_to_do(command: Command, session: Path) -> None:
    (session / "run-0002.h5").write_bytes(b"\x89HDF\r\n\x1a\nand nothing else")
    ended = command("batch", session.parent, session / "absent.h5", "--workers", "1", "--geometry", "plane")
    assert ended.status == 1
    told = [line for line in ended.out.splitlines() if line.startswith(str(session))]
    assert [line.partition(", ")[0] for line in told] == [f"{session / f'run-000{number}.h5'}: ok" for number in (1, 3)]
    errors = [line for line in ended.err.splitlines() if line.startswith("error: ")]
    assert ["absent.h5" in errors[0], "run-0002.h5" in errors[1], len(errors)] == [True, True, 2]
    assert ended.out.splitlines()[-1] == "2 processed, 0 were up to date, 2 failed of 3 runs"
    summary = read_summary(session / "run-0003.h5")
    assert summary is not None
    assert summary["geometry"] == "plane"
    (session / "run-0002.h5").unlink()
    again = command("batch", session, "--workers", "1", "--geometry", "plane")
    assert (again.status, again.out) == (0, "0 processed, 2 were up to date, 0 failed of 2 runs\n")


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "--workers and --scheduler do not go together"),
        (["--geometry", "flat"], 'processing.geometry = "flat", allowed: exact, plane'),
        (["--setup", "absent.toml"], "absent.toml"),
        (["--workers", "0"], "--workers"),
        (["--scheduler", "nonsense"], "--scheduler"),
    ],
)
def test_a_bad_option_is_one_line_and_status_2_before_any_work(
    command: Command, session: Path, options: list[str], text: str
) -> None:
    ended = command("batch", session, *options)
    assert ended.status == 2
    assert text in ended.error
    assert all(read_summary(run) is None for run in session.iterdir())


def test_tables_go_below_the_output_folder_and_two_of_one_name_are_refused(
    command: Command, session: Path, tmp_path: Path
) -> None:
    other = Path(shutil.copytree(session, tmp_path / "other" / "monday"))
    clash = command("batch", session, other, "--output", tmp_path / "out")
    assert clash.status == 2
    assert "The tables of several runs would go to" in clash.error
    assert command("batch", session, "--output", tmp_path / "out", "--workers", "1").status == 0
    made = sorted(path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*.json"))
    assert made == [f"monday/run-000{number}/result.json" for number in (1, 2, 3)]
    assert all(read_summary(run) is None for run in session.iterdir())


def test_an_output_that_cannot_be_written_is_told_before_any_work(
    command: Command, session: Path, tmp_path: Path
) -> None:
    before = [path.read_bytes() for path in sorted(session.glob("*.h5"))]
    file = tmp_path / "file"
    file.touch()
    ended = command("batch", session, "--output", file)
    assert ended.status == 1
    assert ended.error.startswith(f"{file} cannot be made: ")
    assert [path.read_bytes() for path in sorted(session.glob("*.h5"))] == before


def test_without_the_cluster_package_the_remedy_is_told(
    command: Command, session: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    ended = command("batch", session, "--scheduler", "tcp://127.0.0.1:1")
    assert ended.status == 2
    assert 'pip install "radargui[cluster]"' in ended.error


@pytest.mark.skipif(sys.platform == "win32", reason="another process cannot send Ctrl-C there")
def test_ctrl_c_ends_it_in_one_line_and_the_same_command_goes_on(tmp_path: Path) -> None:
    # four are handed out at once: none is submitted, and so nothing ignores the signal, after the first line
    runs = store_runs(tmp_path / "monday", 4)
    process = started(tmp_path, tmp_path / "monday", "--workers", "2", program=(str(HELD_BATCH),))
    assert process.stdout is not None
    assert process.stdout.readline().startswith(str(tmp_path))
    # As a terminal does it: to the command and all its workers at once.
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 1
    assert err.count("\n") == 1
    assert "error: interrupted with" in err
    done = sum(results_digest(run) != "" for run in runs)
    assert 0 < done < 4
    assert results_digest(runs[1]) == ""
    assert not list(tmp_path.rglob("*.part"))
    process = started(tmp_path, tmp_path / "monday", "--workers", "1")
    out, err = process.communicate(timeout=100)
    assert (process.returncode, err) == (0, "")
    assert out.splitlines()[-1] == f"{4 - done} processed, {done} were up to date, 0 failed of 4 runs"


@pytest.mark.slow
@pytest.mark.timeout(240)
def test_a_cluster_that_loses_a_worker_gives_the_same_results_as_this_computer(tmp_path: Path) -> None:
    here = store_runs(tmp_path / "here", 1)
    there = store_runs(tmp_path / "there", 6)
    (tmp_path / "there" / "run-0007.h5").write_bytes(b"nothing")
    process_run(here[0])
    with dask_cluster(2, tmp_path) as cluster:
        process = started(tmp_path, tmp_path / "there", "--scheduler", cluster.address)
        assert process.stdout is not None
        first = process.stdout.readline()
        assert first.startswith(str(tmp_path)), process.stderr.read() if process.stderr else ""
        cluster.workers[0].kill()
        left = sum(results_digest(run) == "" for run in there)
        out, err = process.communicate(timeout=120)
        assert cluster.workers[0].wait(timeout=10) != 0
    assert process.returncode == 1
    assert left > 1
    assert [line for line in err.splitlines() if not line.startswith("error: ")] == []
    assert err.count("run-0007.h5") == 1
    assert " 1 failed of 7 runs" in out
    assert {results_digest(run) for run in there} == {results_digest(here[0])}
