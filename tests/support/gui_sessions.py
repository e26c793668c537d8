"""A data folder with sessions of small processed runs, for tests of the window."""

from __future__ import annotations

import functools
import tempfile
from datetime import datetime
from pathlib import Path

import h5py
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.stored_runs import SETUP

from radargui.experiment.reprocess import process_run
from radargui.model.recording import Block
from radargui.session.session import Session


def make_session(data_folder: Path, day: int, *, n_runs: int = 1, finish: bool = True, **said: str) -> Path:
    """Write a session of May 2026 with runs of one drop (e = 0.5) and return its folder; not locked any more."""
    now = _ten_o_clock(day)
    session = Session.create(data_folder, SETUP, now=now, **said)
    for number in range(1, n_runs + 1):
        (session.path / f"run-{number:04d}.h5").write_bytes(_run(day, finish))
    session.close()
    return session.path


def make_height(data_folder: Path, day: int, height_m: float, *, n_runs: int = 2, **said: str) -> Path:
    """Write a session of drops from a height onto the floor, each with noise of its own; parameters as above."""
    now = _ten_o_clock(day)
    release = (0.0, 0.0, (SETUP.floor.height_m or 0.0) + height_m)
    session = Session.create(data_folder, changed(SETUP, tracer={"release_position_m": release}), now=now, **said)
    for number in range(1, n_runs + 1):
        content = _run(day, finish=True, release_m=release, seed=number)
        (session.path / f"run-{number:04d}.h5").write_bytes(content)
    session.close()
    return session.path


def _ten_o_clock(day: int) -> datetime:
    return datetime.fromisoformat(f"2026-05-{day:02d}T10:00:00+02:00")


@functools.cache
def _run(day: int, finish: bool, release_m: tuple[float, float, float] | None = None, seed: int = 1) -> bytes:
    """Return the file of a run, processed or as a crash leaves it; made once, processing takes a second."""
    own = {} if release_m is None else {"tracer": {"release_position_m": release_m}, "simulation": {"seed": seed}}
    # what is written out counts as given: a floor that is level by default is not known to be
    setup = changed(SETUP, **own) if own else SETUP
    recording, _ = simulate_recording(setup)
    now = _ten_o_clock(day)
    with tempfile.TemporaryDirectory() as folder:
        session = Session.create(Path(folder), setup, now=now)
        writer = session.new_run(recording.digitisation, started_at=now.isoformat(), trigger_index=None)
        writer.write(Block(recording.raw, 0))
        writer.close()
        if finish:
            process_run(writer.path)
        else:
            with h5py.File(writer.path, "r+") as file:
                file.attrs["complete"] = False
        session.close()
        return writer.path.read_bytes()
