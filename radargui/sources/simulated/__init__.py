"""The simulated source: spherical waves to a moving tracer and back, mismatch, noise, converter.

From motion to samples: `scene` (a `trajectory` between two rests) -> `waves` (antennas and their images in the
planes of `reflection`) -> `tracer_mismatch` -> mixers of `hardware` -> `noise`, `flicker` -> converter of `hardware`;
`model` joins them. A drop or a fall onto a bed is `fall`. A new motion is one more trajectory, another
disturbance one more term of time.
"""

from radargui.sources.simulated.model import simulate_recording
from radargui.sources.simulated.source import SimulatedSource

__all__ = ["SimulatedSource", "simulate_recording"]
