"""Values by name, each drawn from a generator of its own, so that holding one changes no other."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

Generator = np.random.Generator


class Draws:
    """What is drawn for one scene.

    Parameters
    ----------
    key
        Numbers that the generators start from: seed, number of the scene and the like.
    held
        Values by name that are not drawn.
    options
        The names that may be held.

    Raises
    ------
    ValueError
        A value is held that nothing draws.
    """

    def __init__(self, key: tuple[int, ...], held: Mapping[str, Any], options: tuple[str, ...]) -> None:
        unknown = sorted(set(held) - set(options))
        if unknown:
            raise ValueError(f"no such values: {', '.join(unknown)}; there are {', '.join(options)}")
        self.key, self.held, self.options = key, dict(held), options

    def rng(self, name: str) -> Generator:
        """Return the generator of a name."""
        return np.random.default_rng([*self.key, zlib.crc32(name.encode())])

    def __call__(self, name: str, draw: Callable[[Generator], Any]) -> Any:
        """Return what is held, else what is drawn."""
        return self.held[name] if name in self.held else draw(self.rng(name))

    def happens(self, name: str, probability: float) -> bool:
        """Return whether something is there that is there with this probability."""
        return bool(self(name, lambda rng: rng.random() < probability))

    def between(self, name: str, lowest: float, highest: float) -> float:
        """Return a value drawn evenly."""
        return float(self(name, lambda rng: rng.uniform(lowest, highest)))

    def log_between(self, name: str, lowest: float, highest: float) -> float:
        """Return a value drawn evenly on a logarithmic scale."""
        return float(self(name, lambda rng: np.exp(rng.uniform(np.log(lowest), np.log(highest)))))

    def drop(self, number: int) -> Draws:
        """Return the draws of one drop of a session; those of the first are these."""
        return Draws((*self.key, number), self.held, self.options) if number else self
