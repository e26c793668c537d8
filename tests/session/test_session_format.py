"""A stranger reads a session with the recipe of docs/session-format.md, plain h5py and h5dump, without this program."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import zlib
from datetime import UTC, datetime
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.file_samples import result_of
from support.one_run import record_run
from support.simulated_setup import simulated_setup

from radargui.experiment.series import Experiment
from radargui.files.run_file import read_run
from radargui.files.run_results import write_results
from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block, Digitisation, Gap, iq_names
from radargui.session.info import CalibrationRecord
from radargui.session.session import Session
from radargui.sources.simulated.model import SimulatedSource

DOCUMENT = (Path(__file__).resolve().parents[2] / "docs" / "session-format.md").read_text(encoding="utf-8")
NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
SETUP = simulated_setup(daq={"rate_hz": 5000.0}, restitution=0.6, settle_s=0.3, rest_s=0.3)
WORDS = {"operator": "Änne", "sample": "10 mm steel", "target": "glass", "notes": "no wind"}


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    calibration = CalibrationRecord(made_at="2026-11-01", origin="tape measure")
    made = Session.create(tmp_path_factory.mktemp("data"), SETUP, **WORDS, calibration=calibration, now=NOW)
    experiment = Experiment(SETUP, lambda run: SimulatedSource(SETUP, run=run), made, live=False, patient=True)
    run = record_run(experiment)
    assert run.result is not None
    return made.path


def recipe(folder: Path) -> dict[str, object]:
    """Run the recipe of the document as it stands, for another folder."""
    (code,) = re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL)
    code = code.replace('Path("2026-11-20T15-04-05")', "given")
    found: dict[str, object] = {"given": folder, "print": lambda *_: None}
    exec(compile(code, "docs/session-format.md", "exec"), found)
    return found


def test_the_recipe_gives_the_samples_times_and_results(session: Path) -> None:
    found = recipe(session)
    recording = read_run(session / "run-0001.h5")
    np.testing.assert_array_equal(found["volts"], recording.volts())
    np.testing.assert_array_equal(found["time_s"], recording.time_s())
    assert found["names"] == list(iq_names(3))
    assert found["status"] == "ok"
    assert found["e"][0] == pytest.approx(0.6, abs=0.02)  # type: ignore[index]
    assert found["position_m"].shape == (3, recording.n_samples)  # type: ignore[attr-defined]


def test_the_recipe_counts_lost_samples_and_shows_notes(tmp_path: Path) -> None:
    session = Session.create(tmp_path, SETUP, now=NOW)
    samples = np.random.default_rng(1).normal(size=(6, 900))
    with session.new_run(Digitisation(iq_names(3), 1000.0), started_at=NOW.isoformat()) as writer:
        writer.write(Block(samples[:, :400], 0))
        entry = session.mark("Tür auf", now=NOW)
        writer.write(Block(samples[:, 400:], 450, Gap(400, 50, "overflow")))
    write_results(writer.path, result_of(read_run(writer.path)))
    found = recipe(session.path)
    np.testing.assert_array_equal(found["volts"], samples)
    np.testing.assert_array_equal(found["time_s"], read_run(writer.path).time_s())
    assert found["notes"] == [(0.4, "Tür auf")]
    assert (entry.run, entry.index, entry.text) == ("run-0001.h5", 400, "Tür auf")
    journal = json.loads((session.path / "session.json").read_text(encoding="utf-8"))["journal"]
    assert journal == [{"at": "2026-11-20T15:04:05.000+00:00", "text": "Tür auf", "run": "run-0001.h5", "index": 400}]


def test_all_that_was_known_is_written_before_the_first_sample(tmp_path: Path) -> None:
    calibration = CalibrationRecord(made_at="2026-11-01", origin="tape measure")
    session = Session.create(tmp_path, SETUP, **WORDS, calibration=calibration, setup_name="bench", now=NOW)
    content = json.loads((session.path / "session.json").read_text(encoding="utf-8"))
    assert {key: content[key] for key in WORDS} == WORDS
    assert content["calibration"] == {"made_at": "2026-11-01", "origin": "tape measure", "file": ""}
    assert content["setup_name"] == "bench"
    writer = session.new_run(Digitisation(iq_names(3), 1000.0), started_at=NOW.isoformat())
    with h5py.File(writer.path) as file:
        assert file["raw"].shape == (6, 0)
        assert {key: file.attrs[key].decode() for key in WORDS} == WORDS
        assert json.loads(file.attrs["calibration"]) == content["calibration"]
        assert json.loads(file.attrs["versions"])["h5py"]
        assert "[radar]" in file.attrs["setup"].decode()
    writer.close()


def test_long_notes_are_kept_whole_in_the_session_and_cut_in_the_run(tmp_path: Path) -> None:
    notes = "ü" * 100_000
    session = Session.create(tmp_path, SETUP, notes=notes, now=NOW)
    with session.new_run(Digitisation(iq_names(3), 1000.0), started_at="") as writer:
        writer.write(Block(np.zeros((6, 10)), 0))
    assert Session.open(session.path).info.notes == notes
    with h5py.File(writer.path) as file:
        assert file.attrs["notes"].decode() == "ü" * 8000


def test_every_array_carries_its_unit_and_every_table_those_of_its_columns(session: Path) -> None:
    run = session / "run-0001.h5"
    write_results(run, result_of(read_run(run)))
    seen = []

    def look(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            seen.append(name)
            if item.dtype.names:
                assert len(item.attrs["units"]) == len(item.dtype.names), name
            else:
                assert item.attrs["unit"], name

    with h5py.File(run) as file:
        file.visititems(look)
        assert file["raw"].attrs["stored_unit"] in (b"code", b"V")
        assert file["results/track/position_m"].attrs["unit"] == b"m"
        assert file["results/paths/phase_rad"].attrs["unit"] == b"rad"
    assert {"raw", "gaps", "markers", "truth/position_m", "results/track/valid", "overview/level_0/lowest"} <= set(seen)


def test_the_document_names_everything_a_run_file_holds(session: Path) -> None:
    run = session / "run-0001.h5"
    names: set[str] = set()
    with h5py.File(run) as file:
        for place in (file, file["raw"], file["results"]):
            names.update(place.attrs)
        names.update(file)
        for group in ("results", "results/corrected", "results/paths", "results/track", "truth", "overview/level_0"):
            names.update(file[group])
        for table in ("gaps", "markers", "results/bounces"):
            names.update(file[table].dtype.names)
    missing = [name for name in sorted(names) if not re.search(rf"\b{name}\b", DOCUMENT)]
    assert missing == []
    content = json.loads((session / "session.json").read_text(encoding="utf-8"))
    assert [key for key in content if f"`{key}`" not in DOCUMENT] == []


def test_the_checksums_are_those_of_the_document(session: Path) -> None:
    with h5py.File(session / "run-0001.h5") as file:
        assert [zlib.crc32(row.tobytes()) for row in file["raw"][:]] == file.attrs["crc32"].tolist()


@pytest.mark.skipif(shutil.which("h5dump") is None, reason="h5dump is not installed")
def test_h5dump_reads_a_run(tmp_path: Path) -> None:
    run = tmp_path / "run-0001.h5"
    codes = np.arange(-6, 6, dtype=np.int16).reshape(6, 2)
    digitisation = Digitisation(iq_names(3), 1000.0, ((0.0, 1e-4),) * 6)
    with RunWriter(run, digitisation, started_at=NOW.isoformat(), attributes={"operator": "Ada"}) as writer:
        writer.write(Block(codes, 0))
        writer.mark("here")
    ended = subprocess.run(["h5dump", "-y", "-d", "/raw", str(run)], capture_output=True, check=True, encoding="utf-8")
    assert "H5T_STD_I16LE" in ended.stdout
    numbers = re.search(r"DATA \{\n(.*?)\}", ended.stdout, re.DOTALL)
    assert numbers is not None
    assert [int(number) for number in re.findall(r"-?\d+", numbers[1])] == codes.ravel().tolist()
    whole = subprocess.run(["h5dump", "-A", str(run)], capture_output=True, check=True, encoding="utf-8").stdout
    assert "Ada" in whole
