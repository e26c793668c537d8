"""Hardware constants of a receiver's front end, and their pool over the runs of a session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray

_CHANGE_GAIN, _CHANGE_DEG = 1e-3, 0.05


@dataclass(frozen=True, slots=True)
class HardwareConstants:
    """Constants of one receiver's front end with standard uncertainties.

    Attributes
    ----------
    gain_ratio, u_gain_ratio
        Amplitude of Q over amplitude of I.
    quadrature_error_deg, u_quadrature_error_deg
        Departure of Q from 90 degrees after I.
    offset_v, u_offset_v
        Mean offsets of I and Q while moving.
    """

    gain_ratio: float
    u_gain_ratio: float
    quadrature_error_deg: float
    u_quadrature_error_deg: float
    offset_v: tuple[float, float]
    u_offset_v: tuple[float, float]


def pool_constants(runs: Sequence[tuple[HardwareConstants, ...]]) -> tuple[HardwareConstants, ...]:
    """Return each receiver's weighted mean over runs: the prior of the next run.

    The uncertainty is that of the mean, widened by what the runs differ beyond it (Birge ratio) and by 0.1 % and
    0.05 degrees that a front end may change between runs. Offsets move with the scene: those of the last run are kept.

    Parameters
    ----------
    runs
        At least one; the same number of receivers each.
    """
    pooled = []
    for own in zip(*runs, strict=True):
        gain, u_gain = _pool([c.gain_ratio for c in own], [c.u_gain_ratio for c in own])
        angle, u_angle = _pool([c.quadrature_error_deg for c in own], [c.u_quadrature_error_deg for c in own])
        pooled.append(
            HardwareConstants(
                gain,
                float(np.hypot(u_gain, _CHANGE_GAIN)),
                angle,
                float(np.hypot(u_angle, _CHANGE_DEG)),
                own[-1].offset_v,
                own[-1].u_offset_v,
            )
        )
    return tuple(pooled)


def _pool(values: list[float], u: list[float]) -> tuple[float, float]:
    weight = 1.0 / np.square(u)
    mean = float((weight * values).sum() / weight.sum())
    birge = float((weight * np.square(np.subtract(values, mean))).sum() / max(len(values) - 1, 1))
    return mean, float(np.sqrt(max(birge, 1.0) / weight.sum()))


def front_end_prior(constants: tuple[HardwareConstants, ...], phase_sign: int) -> FloatArray:
    """Return ln g, its u, eps in rad (sign of the wiring applied), its u; shape (n_receivers, 4)."""
    return np.array(
        [
            [
                np.log(own.gain_ratio),
                own.u_gain_ratio / own.gain_ratio,
                phase_sign * np.radians(own.quadrature_error_deg),
                np.radians(own.u_quadrature_error_deg),
            ]
            for own in constants
        ]
    )
