"""A data folder with sessions of small processed runs, for tests of the window."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from support.stored_runs import SETUP

from radargui.experiment.reprocess import process_run
from radargui.model.block import Block
from radargui.session.session import Session
from radargui.sources.simulated import simulate_recording


def make_session(data_folder: Path, day: int, *, n_runs: int = 1, finish: bool = True, **said: str) -> Path:
    """Write a session of May 2026 with runs of one drop (e = 0.5) and return its folder; not locked any more."""
    now = datetime.fromisoformat(f"2026-05-{day:02d}T10:00:00+02:00")
    session = Session.create(data_folder, SETUP, now=now, **said)
    recording, _ = simulate_recording(SETUP)
    for _ in range(n_runs):
        writer = session.new_run(recording.digitisation, started_at=now.isoformat(), trigger_index=None)
        writer.write(Block(recording.raw, 0))
        writer.close()
        if finish:
            process_run(writer.path)
        else:
            # as a crash leaves it
            import h5py

            with h5py.File(writer.path, "r+") as file:
                file.attrs["complete"] = False
    session.close()
    return session.path
