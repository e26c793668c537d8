"""Simulated recordings that several tests look at, made once: one of the shipped setup takes half a second."""

from __future__ import annotations

import functools

from radargui.model.recording import Recording, Truth
from radargui.model.setup import Setup
from radargui.sources.simulated.model import simulate_recording


@functools.lru_cache(maxsize=4)
def simulate_once(setup: Setup, run: int = 0) -> tuple[Recording, Truth]:
    """Return one run and its truth, which nobody can change."""
    recording, truth = simulate_recording(setup, run=run)
    recording.raw.setflags(write=False)
    return recording, truth
