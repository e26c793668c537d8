"""Simulated recordings that several tests look at, made once: one of the shipped setup takes half a second."""

from __future__ import annotations

import functools

from support.simulated_recording import simulate_recording

from radargui.model.recording import Recording, Truth
from radargui.model.setup import Setup


@functools.lru_cache(maxsize=4)
def simulate_once(setup: Setup, run: int = 0) -> tuple[Recording, Truth]:
    """Return one run and its truth, which nobody can change."""
    recording, truth = simulate_recording(setup, run=run)
    recording.raw.setflags(write=False)
    return recording, truth
