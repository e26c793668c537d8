"""The mistakes by name, and the drop of a seed with a setup that has one of them."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from benchmarks.world.disturbed.strength import Case
from benchmarks.world.draw import draw
from benchmarks.world.mistaken.antennas import azimuth, count, distance, polarization, receivers, tilt
from benchmarks.world.mistaken.motion import floor, release, sphere
from benchmarks.world.mistaken.sheet import Sheet
from benchmarks.world.mistaken.wiring import air, clock, frequency, sign, skew, wires
from benchmarks.world.scene import Scene, World
from benchmarks.world.stated import Stated

from radargui.model.setup import Setup

Writer = Callable[[Sheet, str], None]

MISTAKEN: dict[str, tuple[Writer, tuple[str, ...]]] = {
    "receivers": (receivers, ("exchanged", "rotated", "transmitter")),
    "wires": (wires, ("antennas", "pair", "next", "shifted", "inverted", "half")),
    "sign": (sign, ("wiring",)),
    "azimuth": (azimuth, ("mirrored", "clockwise", "one", "turned")),
    "tilt": (tilt, ("one", "horizon", "radians", "below")),
    "distance": (distance, ("receiver", "transmitter", "all", "centimetres", "inches", "feet")),
    "polarization": (polarization, ("all", "receiver", "transmitter", "left-out")),
    "count": (count, ("forgotten", "absent", "imagined", "copy")),
    "frequency": (frequency, ("off",)),
    "air": (air, ("vacuum",)),
    "clock": (clock, ("off", "half", "double")),
    "skew": (skew, ("none", "double", "sample")),
    "sphere": (sphere, ("radius", "double", "plastic")),
    "release": (release, ("height", "sideways", "top", "left-out", "floor")),
    "floor": (floor, ("height", "surface", "tilted", "level", "down")),
}
"""What states each wrongly, and its variants, of which a seed draws one."""


def mistaken(which: str, seed: int, stated: Stated = "exact", strength: float | None = None, **held: Any) -> Scene:
    """Return the drop of a seed, the same that `draw` gives, with a setup that states something wrongly.

    Parameters
    ----------
    which
        A name of `MISTAKEN`, or name/variant.
    strength
        0, the smallest mistake of its kind, to 1; None: drawn. Kinds without a size do not read it.
    held
        Values of the drop to hold instead of drawing.

    Raises
    ------
    pydantic.ValidationError
        No setup may say that.
    """
    name, _, wanted = which.partition("/")
    if name not in MISTAKEN:
        raise ValueError(f"no such mistake: {name}; there are {', '.join(MISTAKEN)}")
    variants = MISTAKEN[name][1]
    if wanted and wanted not in variants:
        raise ValueError(f"no such variant of {name}: {wanted}; there are {', '.join(variants)}")
    rng = np.random.default_rng([seed, zlib.crc32(f"mistaken {name}".encode())])
    drawn, drawn_strength = str(rng.choice(variants)), float(rng.random())
    variant, strength = wanted or drawn, drawn_strength if strength is None else strength
    if not 0.0 <= strength <= 1.0:
        raise ValueError(f"strength {strength}, allowed: 0 to 1")
    scene = draw(seed, stated, name=f"{name}/{variant}", **held)
    sheet = filled_in(scene, scene.setup.model_dump(by_alias=True, exclude_unset=True), name, variant, rng, strength)
    return replace(
        scene,
        setup=Setup.model_validate(sheet.tables),
        skew_in_file=sheet.skew_in_file,
        disturbances=() if sheet.wiring is None else (sheet.wiring,),
        facts={**scene.facts, "strength": round(strength, 2)},
        is_mistaken=True,
    )


def filled_in(
    world: World, tables: dict[str, Any], name: str, variant: str, rng: np.random.Generator, strength: float
) -> Sheet:
    """Return what somebody fills in who makes this mistake; the tables are written into."""
    sheet = Sheet(Case(world, rng, strength), tables, skew_in_file=world.skew_in_file)
    MISTAKEN[name][0](sheet, variant)
    sheet.tables["receiver"] = list(sheet.tables["receiver"])
    return sheet
