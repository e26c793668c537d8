"""The simulated source: spherical waves to a moving tracer and back, mismatch, noise, converter.

From motion to samples: `scene` (a `trajectory` between two rests) -> `waves` (antennas and their images in the
planes of `reflection`) -> `tracer_mismatch` -> `hardware` -> `disturbance` -> `noise`, `flicker` -> `converter`;
`model` joins them. A fall in vacuum is `drop` or `bed`, in air `air_fall`. A new motion is one more trajectory, another
disturbance one more term of time.
"""

from radargui.sources.simulated.recording import simulate_recording
from radargui.sources.simulated.source import SimulatedSource

__all__ = ["SimulatedSource", "simulate_recording"]
