"""Sessions of small stored runs for tests of batches."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

import h5py
import numpy as np
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block
from radargui.model.setup import dump_setup

# wide beams: narrow ones look like a floor, and a joint correction takes three times as long
SETUP = simulated_setup(
    daq={"rate_hz": 2000.0},
    mismatch=0.0,
    beamwidth_deg=90.0,
    snr_db=50.0,
    restitution=0.5,
    settle_s=0.2,
    rest_s=0.3,
)


def store_runs(session: Path, count: int) -> list[Path]:
    """Write runs of the same drop into a folder and return them."""
    session.mkdir(parents=True)
    recording, _ = simulate_recording(SETUP)
    first = session / "run-0001.h5"
    with RunWriter(first, recording.digitisation, started_at="", setup_toml=dump_setup(SETUP)) as writer:
        writer.write(Block(recording.raw, 0))
    return [first, *(Path(shutil.copy(first, session / f"run-{number:04d}.h5")) for number in range(2, count + 1))]


def results_digest(run: Path) -> str:
    """Return a digest of all results in a run but their date; empty where there are none."""
    digest = hashlib.sha256()
    with h5py.File(run) as file:
        if "results" not in file:
            return ""

        def add(name: str, item: object) -> None:
            digest.update(name.encode())
            if isinstance(item, h5py.Dataset):
                digest.update(np.ascontiguousarray(item[...]).tobytes())

        file["results"].visititems(add)
        for key, value in sorted(file["results"].attrs.items()):
            if key not in ("processed_at", "attributes_crc32"):
                digest.update(f"{key}={value!r}".encode())
    return digest.hexdigest()


def raw_digest(run: Path) -> str:
    """Return a digest of the samples of a run."""
    with h5py.File(run) as file:
        return hashlib.sha256(file["raw"][...].tobytes()).hexdigest()
