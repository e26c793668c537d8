"""The disturbances by name, and the drop of a seed with one of them."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from benchmarks.world.disturbance import Disturbance
from benchmarks.world.disturbed.bystanders import fan, hand, person, swing
from benchmarks.world.disturbed.front_end import dip, gap, steps
from benchmarks.world.disturbed.interference import foreign, mains
from benchmarks.world.disturbed.second import second
from benchmarks.world.disturbed.shock import shock
from benchmarks.world.disturbed.strength import Case
from benchmarks.world.draw import draw
from benchmarks.world.scene import Scene
from benchmarks.world.stated import Stated

Maker = Callable[[Case, str], tuple[Disturbance, ...]]

DISTURBED: dict[str, tuple[Maker, tuple[str, ...]]] = {
    "hand": (hand, ("retreats", "comes")),
    "person": (person, ("walks",)),
    "fan": (fan, ("blades", "panel")),
    "shock": (shock, ("rings",)),
    "second": (second, ("sphere", "clamp", "block")),
    "swing": (swing, ("thread",)),
    "steps": (steps, ("jump", "drift", "gain", "supply", "contact", "lost", "bit", "slip", "clip")),
    "dip": (dip, ("echo", "offsets")),
    "mains": (mains, ("hum", "modulated")),
    "foreign": (foreign, ("beat",)),
    "gap": (gap, ("lost",)),
}
"""What makes each, and its variants, of which a seed draws one."""


def disturbed(which: str, seed: int, stated: Stated = "exact", strength: float | None = None, **held: Any) -> Scene:
    """Return the drop of a seed, the same that `draw` gives, with a disturbance.

    Parameters
    ----------
    which
        A name of `DISTURBED`, or name/variant.
    strength
        0, the weakest of its kind, to 1; None: drawn.
    held
        Values of the drop to hold instead of drawing.
    """
    name, _, wanted = which.partition("/")
    if name not in DISTURBED:
        raise ValueError(f"no such disturbance: {name}; there are {', '.join(DISTURBED)}")
    maker, variants = DISTURBED[name]
    if wanted and wanted not in variants:
        raise ValueError(f"no such variant of {name}: {wanted}; there are {', '.join(variants)}")
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    drawn, drawn_strength = str(rng.choice(variants)), float(rng.random())
    variant, strength = wanted or drawn, drawn_strength if strength is None else strength
    if not 0.0 <= strength <= 1.0:
        raise ValueError(f"strength {strength}, allowed: 0 to 1")
    scene = draw(seed, stated, name=f"{name}/{variant}", **held)
    case = Case(scene, rng, strength)
    return replace(
        scene, disturbances=maker(case, variant), facts={**scene.facts, "strength": round(strength, 2)}
    )  # fmt: skip
