"""Setups for tests of the simulated source."""

from __future__ import annotations

from typing import Any

from radargui.model.setup import Setup

PERFECT: dict[str, Any] = {"mismatch": 0.0, "noise": False, "adc_bits": 0}


def simulated_setup(
    *,
    release: tuple[float, float, float] = (0.0, 0.0, 0.12),
    floor: dict[str, Any] | None = None,
    daq: dict[str, Any] | None = None,
    radar: dict[str, Any] | None = None,
    n_receivers: int = 3,
    **simulation: Any,
) -> Setup:
    """Return a setup with receivers all round and the published, quick correction; keywords go to [simulation]."""
    return Setup.model_validate(
        {
            "schema": 1,
            "radar": radar or {},
            "transmitter": {"distance_m": 0.7},
            "receiver": [
                {"tilt_deg": 40.0, "azimuth_deg": 360.0 * number / n_receivers - 150.0, "distance_m": 0.7}
                for number in range(n_receivers)
            ],
            "tracer": {"diameter_m": 0.01, "release_position_m": release},
            "floor": {"height_m": -0.14} if floor is None else floor,
            "daq": {"rate_hz": 10000.0, **(daq or {})},
            # flights that are followed cost the most: at 0.6 there are half as many as at the default of 0.8
            "simulation": {"restitution": 0.6, **simulation},
            "processing": {"correction": "published"},
        }
    )


def perfect_setup(**settings: Any) -> Setup:
    """Return a setup without mismatch, noise and converter."""
    return simulated_setup(**{**PERFECT, **settings})
