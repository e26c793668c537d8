"""One simulated run at once, as its source would give it block by block."""

from __future__ import annotations

from radargui.model.recording import Recording, Truth
from radargui.model.setup import Setup
from radargui.sources.simulated.model import SimulatedRadar


def simulate_recording(setup: Setup, *, run: int = 0, name: str = "simulated") -> tuple[Recording, Truth]:
    """Return one run of a scene that ends, and what really happened."""
    radar = SimulatedRadar(setup, run=run)
    assert radar.n_samples is not None
    recording = Recording(name, radar.samples(0, radar.n_samples), radar.digitisation)
    return recording, radar.truth(0, radar.n_samples)
