"""A whole simulated run at once, for tests and benchmarks."""

from __future__ import annotations

from radargui.model.errors import SetupError
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.model.truth import Truth
from radargui.sources.simulated.model import SimulatedRadar


def simulate_recording(setup: Setup, *, run: int = 0, name: str = "simulated") -> tuple[Recording, Truth]:
    """Return one run and what really happened: the very samples that `SimulatedSource` gives block by block.

    Raises
    ------
    SetupError
        The simulated scene is impossible.
    """
    radar = SimulatedRadar(setup, run=run)
    if radar.n_samples is None:
        raise SetupError("A scene that repeats for ever has no recording")
    recording = Recording(name, radar.samples(0, radar.n_samples), radar.digitisation)
    return recording, radar.truth(0, radar.n_samples)
