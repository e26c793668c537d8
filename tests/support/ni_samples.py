"""Recordings and setups for the tests of the NI device."""

from __future__ import annotations

import numpy as np

from radargui.model.recording import Digitisation, Recording, iq_names
from radargui.model.setup import Setup


def code_recording(n_samples: int = 20_000, n_channels: int = 6, seed: int = 1) -> Recording:
    """Return random codes over the whole range of int16, each channel with its own scaling."""
    raw = np.random.default_rng(seed).integers(-32768, 32768, (n_channels, n_samples)).astype(np.int16)
    raw[:, :2] = -32768, 32767
    scaling = tuple((1e-3 * channel, 1.5e-4 + 1e-7 * channel, 1e-12, 0.0) for channel in range(n_channels))
    return Recording("served", raw, Digitisation(iq_names(n_channels // 2), 10_000.0, scaling))


def volt_recording(n_samples: int = 20_000, n_channels: int = 6, seed: int = 1) -> Recording:
    """Return volts within +-4 V."""
    volts = np.random.default_rng(seed).uniform(-4.0, 4.0, (n_channels, n_samples))
    return Recording("served", volts, Digitisation(iq_names(n_channels // 2), 10_000.0))


def ni_setup(remote: str | None, receivers: int = 3, **daq: object) -> Setup:
    """Return a setup with `receivers` receivers whose device is behind a device server."""
    settings: dict[str, object] = {"device": "Dev1", "rate_hz": 10_000.0, **daq}
    if remote is not None:
        settings["remote"] = remote
    return Setup.model_validate(
        {
            "schema": 1,
            "radar": {},
            "transmitter": {"distance_m": 0.7},
            "receiver": [
                {"tilt_deg": 40.0, "azimuth_deg": 90.0 + 90.0 * number, "distance_m": 0.7}
                for number in range(receivers)
            ],
            "daq": settings,
        }
    )
