"""Drops that ask more than a drawn one: what each holds of the draw."""

from __future__ import annotations

from typing import Any

from benchmarks.world.draw import N_RECEIVERS, draw
from benchmarks.world.scene import Scene
from benchmarks.world.stated import Stated

_COMMON = {"snr_db": 36.0, "rate_hz": 20000.0, "skew_s": 5e-6, "crosstalk": 0.0, "lively": False, "walls": 0}


def _spread(rate_hz: float) -> dict[str, float]:
    """The multiplexer's conversions spread evenly over the whole sample."""
    return {"rate_hz": rate_hz, "skew_s": 1.0 / (2 * N_RECEIVERS * rate_hz)}


HOSTILE: dict[str, dict[str, Any]] = {
    "caught in a bed": {"depth_m": 0.004},
    "dead stop": {"depth_m": 2e-4},
    "dead stop, no floor": {"depth_m": 2e-4, "floor": 0.0},
    "sphere of 16 mm": {"radius_m": 0.008},
    "sphere of 16 mm, no floor": {"radius_m": 0.008, "floor": 0.0},
    "sphere of 5 mm": {"radius_m": 0.0025},
    "two walls": {"walls": 2, "wall": 0.04},
    "wave over wall and floor": {"walls": 1, "wall": 0.04, "corners": True},
    "wall at 35 cm": {"walls": 1, "wall": 0.04, "wall_distance_m": 0.35},
    "dielectric floor": {"surface": "dielectric", "floor": 0.3},
    "wave between sphere and floor": {"coupled": True, "floor": 0.3},
    "2 kS/s, spread": _spread(2000.0),
    "5 kS/s, spread": _spread(5000.0),
    "crosstalk of 1 %": {"crosstalk": 0.01, "rate_hz": 33333.0},
    "kicks, floor 0.6 deg": {"lively": True, "tilt_deg": 0.6},
    "1/f noise and drift": {"flicker": 0.004, "drift": 0.004},
}


def hostile_scenes(seed: int, stated: Stated) -> list[Scene]:
    """Return each of them, with all that it does not hold drawn from the seed."""
    return [draw(seed, stated, name=name, **{**_COMMON, **held}) for name, held in HOSTILE.items()]
