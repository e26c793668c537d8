"""Calibrations for tests: of a setup's own antennas, with any correlations."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.calibration import Calibration, Origin, Residual
from radargui.model.setup import Setup

MADE_AT = "2025-11-03T10:00:00+01:00"


def antenna_names(setup: Setup) -> tuple[str, ...]:
    """Return the keys of all angles and distances."""
    keys = ("tilt_deg", "azimuth_deg", "distance_m")
    receivers = [f"receiver.{n}.{key}" for n in range(1, setup.n_receivers + 1) for key in keys]
    return (*receivers, "transmitter.distance_m")


def u_of(names: tuple[str, ...], u_deg: float = 0.3, u_m: float = 2e-3) -> FloatArray:
    """Return the usual u of each key."""
    return np.array([u_deg if name.endswith("_deg") else u_m for name in names])


def calibration_of(
    setup: Setup, *, covariance: FloatArray | None = None, shift_u: float = 0.0, made_at: str = MADE_AT
) -> Calibration:
    """Return a calibration that found the setup's own values, or all of them `shift_u` times u beside."""
    names = antenna_names(setup)
    own = {f"receiver.{n}.{k}": v for n, one in enumerate(setup.receiver, 1) for k, v in one.model_dump().items()}
    own["transmitter.distance_m"] = setup.transmitter.distance_m
    before, u = np.array([own[name] for name in names], dtype=float), u_of(names)
    if covariance is None:
        covariance = np.diag(u**2)
    residuals = tuple(Residual("run-0001.h5", n, 2e-5 * n, 4e-4, float("nan")) for n in range(setup.n_receivers + 1))
    return Calibration(
        names,
        before,
        before + shift_u * u,
        2.0 * u,
        covariance,
        ("a common scale of all distances and the height of the release",),
        residuals,
        "good",
        "all parameters are told by the data",
        Origin(made_at, "A. Operator", "0.3", {"run-0001.h5": "ab" * 32}, ("fall",)),
    )
