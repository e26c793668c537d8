"""How strong a disturbance is, from the weakest to the strongest that its kind is drawn with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.scene import World

MODERATE, STRONG = 0.35, 0.9


@dataclass(frozen=True)
class Case:
    """What a kind of disturbance is drawn for.

    Attributes
    ----------
    scene
        The drop to disturb.
    rng
        Of this kind and seed alone; what is drawn with it does not depend on the strength.
    strength
        0 to 1.
    """

    scene: World
    rng: np.random.Generator
    strength: float

    @property
    def n_receivers(self) -> int:
        """How many receivers the scene has."""
        return len(self.scene.mixers)

    @property
    def release_m(self) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        """Where the sphere rests, shape (3,)."""
        return self.scene.drop.position(np.zeros(1))[:, 0]

    def between(self, weakest: float, strongest: float) -> float:
        """Return the value of this strength, evenly on a logarithmic scale."""
        return float(weakest * (strongest / weakest) ** self.strength)

    def moment_s(self) -> float:
        """Return a time drawn evenly from the release to 0.1 s before the end."""
        return float(self.rng.uniform(self.scene.drop.start_s, self.scene.drop.duration_s - 0.1))
