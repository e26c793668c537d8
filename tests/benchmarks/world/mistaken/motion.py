"""Mistakes about the sphere, where it hangs and the floor that it meets."""

from __future__ import annotations

import numpy as np
from benchmarks.world.mistaken.sheet import Sheet

U_FLOOR_TILT_DEG = 0.3


def sphere(sheet: Sheet, variant: str) -> None:
    """Its `radius` stated as diameter, twice the diameter (`double`), steel as `plastic`."""
    tracer = sheet.tables["tracer"]
    if variant == "plastic":
        tracer["density_kg_m3"] = 1050.0
    else:
        tracer["diameter_m"] *= {"radius": 0.5, "double": 2.0}[variant]


def release(sheet: Sheet, variant: str) -> None:
    """Release too high or low (`height`) or `sideways` by 1 to 5 cm, its `top`; `left-out`; above the `floor`."""
    tracer = sheet.tables["tracer"]
    x, y, z = tracer["release_position_m"]
    if variant == "left-out":
        del tracer["release_position_m"]
        return
    if variant == "sideways":
        way, by = sheet.case.rng.uniform(0.0, 2.0 * np.pi), sheet.case.between(0.01, 0.05)
        x, y = x + by * np.cos(way), y + by * np.sin(way)
    elif variant == "height":
        z += sheet.off(0.01, 0.05)
    elif variant == "top":
        z += tracer["diameter_m"] / 2.0
    else:
        z -= _touch_m(sheet)
    tracer["release_position_m"] = (float(x), float(y), float(z))


def floor(sheet: Sheet, variant: str) -> None:
    """Stated `height` off by 1 to 5 cm, that of its `surface`; `tilted` by 0.5 to 5 degrees, `level`, upside `down`."""
    told = sheet.tables.setdefault("floor", {})
    if variant in ("height", "surface"):
        off = sheet.off(0.01, 0.05) if variant == "height" else -sheet.tables["tracer"]["diameter_m"] / 2.0
        told["height_m"] = _touch_m(sheet) + off
    elif variant == "tilted":
        lean, way = np.radians(sheet.case.between(0.5, 5.0)), sheet.case.rng.uniform(0.0, 2.0 * np.pi)
        told["normal"] = tuple((np.sin(lean) * np.array([np.cos(way), np.sin(way), 1.0 / np.tan(lean)])).tolist())
        told["u_tilt_deg"] = U_FLOOR_TILT_DEG
    else:
        told["normal"] = (0.0, 0.0, 1.0 if variant == "level" else -1.0)
        told["u_tilt_deg"] = U_FLOOR_TILT_DEG


def _touch_m(sheet: Sheet) -> float:
    """Return the true height of the sphere's centre as it first touches."""
    drop = sheet.case.scene.drop
    return float(drop.position(np.array([drop.impacts[0].time_s]))[2, 0])
