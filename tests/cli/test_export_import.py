"""`radargui export` and `radargui import`: out in any format, back as a session."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.command_line import Command
from support.file_samples import codes, int16_digitisation, volts, write_csv, write_run, write_tdms
from support.results import default_setup
from support.small_setups import PLATE

from radargui.experiment.importing import FILE_NAME
from radargui.files.run_file import read_run, read_run_setup
from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block
from radargui.model.setup import dump_setup
from radargui.session.session import Session


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """A folder with two runs."""
    (tmp_path / "monday").mkdir()
    for number in (1, 2):
        write_run(tmp_path / "monday" / f"run-000{number}.h5", 200 * number)
    return tmp_path / "monday"


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    """The setup of one receiver."""
    path = tmp_path / "plate.toml"
    path.write_text(PLATE, encoding="utf-8")
    return path


@pytest.fixture(autouse=True)
def memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The memory of channel maps, in a folder of the test."""
    monkeypatch.setattr("platformdirs.user_config_path", lambda *_, **__: tmp_path / "config")
    return tmp_path / "config" / FILE_NAME


def imported(ended_out: str) -> tuple[Path, ...]:
    folder = next(line for line in ended_out.splitlines() if line.startswith("Session: "))
    return Session.open(Path(folder.removeprefix("Session: "))).run_paths()


@pytest.mark.parametrize(
    ("name", "suffix"), [("csv", "csv"), ("mat", "mat"), ("tdms", "tdms"), ("sigmf", "sigmf-meta")]
)
def test_a_session_goes_out_and_comes_back_with_its_own_setup(
    command: Command, session: Path, tmp_path: Path, name: str, suffix: str
) -> None:
    ended = command("export", session, "--format", name)
    assert ended.status == 0
    files = [session / "export" / f"run-000{number}.{suffix}" for number in (1, 2)]
    assert [line for line in ended.out.splitlines() if line.endswith(suffix)] == [str(file) for file in files]
    back = command("import", *files, "--output", tmp_path / "sessions", "--operator", "Eve")
    assert (back.status, back.err) == (0, "")
    runs = imported(back.out)
    assert [run.name for run in runs] == ["run-0001.h5", "run-0002.h5"]
    for run in runs:
        np.testing.assert_allclose(read_run(run).volts(), read_run(session / run.name).volts(), rtol=0, atol=1e-7)
        assert read_run_setup(run) == read_run_setup(session / run.name)


@pytest.mark.parametrize(
    ("name", "suffix"), [("csv", "csv"), ("mat", "mat"), ("tdms", "tdms"), ("sigmf", "sigmf-meta")]
)
def test_what_was_exported_is_processed_and_replayed_with_the_setup_that_it_carries(
    command: Command, session: Path, tmp_path: Path, name: str, suffix: str
) -> None:
    assert command("export", session / "run-0001.h5", "--format", name, "--output", tmp_path).status == 0
    file = tmp_path / f"run-0001.{suffix}"
    own = read_run_setup(session / "run-0001.h5")
    processed = command("process", file, "--correction", "none", "--output", tmp_path / "tables")
    assert processed.status == 0, processed.err
    said = json.loads((tmp_path / "tables" / "run-0001" / "result.json").read_text(encoding="utf-8"))["setup"]
    assert [one["tilt_deg"] for one in said["receiver"]] == [one.tilt_deg for one in own.receiver]
    replayed = command(
        "record", "--source", "replay", "--file", file, "--fast", "--seconds", "0.02", "--output", tmp_path / "replayed"
    )
    assert replayed.status == 0, replayed.err
    (run,) = (tmp_path / "replayed").glob("*/*.h5")
    assert read_run_setup(run) == own


def test_what_was_measured_comes_back_with_the_samples(command: Command, tmp_path: Path) -> None:
    words = {"operator": "Ada", "sample": "Stahl, 10 mm", "target": "glass", "notes": "dry"}
    session = Session.create(tmp_path / "data", default_setup(), now=datetime.now().astimezone(), **words)
    session.close()
    write_run(session.path / "run-0001.h5", 200)
    assert command("export", session.path, "--format", "csv", "--output", tmp_path).status == 0
    for file in (tmp_path / "run-0001.csv", session.path / "run-0001.h5"):
        back = command("import", file, "--output", tmp_path / "back", "--operator", "Eve")
        (run,) = imported(back.out)
        info = Session.open(run.parent, write=False).info
        assert (info.operator, info.sample, info.target, info.notes) == ("Eve", "Stahl, 10 mm", "glass", "dry")


def test_exports_of_other_setups_are_not_imported_as_one_session(
    command: Command, session: Path, tmp_path: Path
) -> None:
    for number, diameter_m in ((1, 0.01), (2, 0.02)):
        setup = changed(default_setup(), tracer={"diameter_m": diameter_m})
        path = session / f"run-000{number + 2}.h5"
        with RunWriter(path, int16_digitisation(), started_at="", setup_toml=dump_setup(setup)) as writer:
            writer.write(Block(codes(6, 300), 0))
    assert command("export", session, "--format", "csv", "--output", tmp_path).status == 0
    first, second = (tmp_path / f"run-000{number}.csv" for number in (3, 4))
    ended = command("import", first, second, "--output", tmp_path / "sessions")
    assert ended.status == 2
    assert f"{second} brings another setup than {first}. Import them apart" in ended.error
    assert not (tmp_path / "sessions").exists()


def test_a_replayed_file_that_brings_no_setup_is_not_computed_with_the_shipped_one(
    command: Command, tmp_path: Path
) -> None:
    file = tmp_path / "lab.csv"
    write_csv(file, volts(6, 400))
    ended = command("record", "--source", "replay", "--file", file, "--fast", "--output", tmp_path / "out")
    assert (ended.status, ended.error) == (2, f"{file} brings no setup. Give --setup FILE.")
    assert not (tmp_path / "out").exists()


def test_one_run_goes_to_the_folder_that_is_named_and_is_not_written_over(
    command: Command, session: Path, tmp_path: Path
) -> None:
    arguments = ["export", session / "run-0002.h5", "--format", "csv", "--output", tmp_path / "out"]
    assert command(*arguments).status == 0
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["run-0002.csv"]
    again = command(*arguments)
    assert again.status == 1
    assert "is there already. Choose another folder, or write over with --force." in again.error
    assert command(*arguments, "--force").status == 0


def test_a_damaged_run_is_told_and_the_other_exported(command: Command, session: Path) -> None:
    (session / "run-0001.h5").write_bytes(b"\x89HDF\r\n\x1a\nand nothing else")
    ended = command("export", session, "--format", "tdms")
    assert ended.status == 1
    assert "run-0001.h5" in ended.error
    assert [path.name for path in (session / "export").iterdir()] == ["run-0002.tdms"]


@pytest.mark.parametrize(
    ("arguments", "status", "text"),
    [
        (["export", "absent", "--format", "csv"], 1, "absent"),
        (["export", ".", "--format", "csv"], 1, "holds no runs"),
        (["export", "."], 2, "--format"),
        (["export", ".", "--format", "wav"], 2, "wav"),
        (["import"], 2, "nothing to import"),
        (["import", "a.csv", "--rate-hz", "0"], 2, "--rate-hz"),
        (["import", "absent.csv"], 1, "no such file"),
        (["import", "a.csv", "--channels", "I1=b.csv:x,Q1=c.csv:x"], 2, "names files of its own"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    command: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    status: int,
    text: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    ended = command(*arguments)
    assert ended.status == status
    assert text in ended.error


def test_a_file_without_setup_needs_one(command: Command, tmp_path: Path) -> None:
    ended = command("import", write_csv(tmp_path / "a.csv", volts(2, 30)), "--output", tmp_path / "sessions")
    assert ended.status == 2
    assert ended.error.endswith("brings no setup. Give --setup FILE.")
    assert not (tmp_path / "sessions").exists()


def test_a_chosen_mapping_is_used_for_the_next_file_with_these_names(
    command: Command, tmp_path: Path, plate: Path
) -> None:
    first = write_tdms(tmp_path / "a.tdms", codes(2, 30), ["ai0", "ai1"], {"wf_increment": 0.01})
    second = write_tdms(tmp_path / "b.tdms", codes(2, 40, seed=1), ["ai0", "ai1"], {"wf_increment": 0.01})
    options = ["--setup", plate, "--output", tmp_path / "sessions"]
    guessed = command("import", first, *options)
    assert "I1=ai0,Q1=ai1 (guessed from the order, correct it with --channels)" in guessed.err
    assert command("import", first, "--channels", "I1=ai1,Q1=ai0", *options).status == 0
    ended = command("import", second, *options)
    assert ended.status == 0
    assert "I1=ai1,Q1=ai0 (as chosen before)" in ended.err
    (run,) = imported(ended.out)
    np.testing.assert_array_equal(read_run(run).raw, codes(2, 40, seed=1)[::-1])


def test_one_bad_file_is_told_and_the_others_come_in(command: Command, tmp_path: Path, plate: Path) -> None:
    good, bad = write_csv(tmp_path / "good.csv", volts(2, 30)), tmp_path / "bad.csv"
    bad.write_text("I1,Q1\n1,x\n", encoding="utf-8")
    ended = command("import", bad, good, tmp_path / "absent.csv", "--setup", plate, "--output", tmp_path / "sessions")
    assert ended.status == 1
    assert len(imported(ended.out)) == 1
    assert [name for name in ("bad.csv", "absent.csv", "good.csv") if name in ended.err] == ["bad.csv", "absent.csv"]
