"""Hardware constants of the receivers' front ends: their pool over the runs of a session, and whether a run agrees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.front_end import FrontEnd

_CHANGE_GAIN, _CHANGE_DEG = 1e-3, 0.05
_DISAGREES, _TWICE = 3.5, 0.5


@dataclass(frozen=True, slots=True)
class HardwareConstants(FrontEnd):
    """Constants of one receiver's front end and the offsets of a run, with standard uncertainties.

    Attributes
    ----------
    offset_v, u_offset_v
        Mean offsets of I and Q while moving: they move with the scene.
    """

    offset_v: tuple[float, float]
    u_offset_v: tuple[float, float]


def pool_constants(runs: Sequence[tuple[FrontEnd, ...]]) -> tuple[FrontEnd, ...]:
    """Return each receiver's weighted mean over runs: the prior of the next run.

    The uncertainty is that of the mean, widened by what the runs differ beyond it (Birge ratio) and by 0.1 % and
    0.05 degrees that a front end may change between runs.

    Parameters
    ----------
    runs
        At least one, estimated without a prior: else they would say one thing twice; the same number of receivers
        each.
    """
    pooled = []
    for own in zip(*runs, strict=True):
        gain, u_gain = _pool([c.gain_ratio for c in own], [c.u_gain_ratio for c in own])
        angle, u_angle = _pool([c.quadrature_error_deg for c in own], [c.u_quadrature_error_deg for c in own])
        pooled.append(
            FrontEnd(gain, float(np.hypot(u_gain, _CHANGE_GAIN)), angle, float(np.hypot(u_angle, _CHANGE_DEG)))
        )
    return tuple(pooled)


def _pool(values: list[float], u: list[float]) -> tuple[float, float]:
    weight = 1.0 / np.square(u)
    mean = float((weight * values).sum() / weight.sum())
    birge = float((weight * np.square(np.subtract(values, mean))).sum() / max(len(values) - 1, 1))
    return mean, float(np.sqrt(max(birge, 1.0) / weight.sum()))


def disagreement(own: Sequence[FrontEnd], prior: Sequence[FrontEnd]) -> str:
    """Return in which receiver a run contradicts a prior it was estimated without, empty where it does not.

    A difference counts beyond 3.5 of its standard uncertainties.
    """
    for number, (here, before) in enumerate(zip(own, prior, strict=True), 1):
        u_gain = np.hypot(here.u_gain_ratio, before.u_gain_ratio)
        u_angle = np.hypot(here.u_quadrature_error_deg, before.u_quadrature_error_deg)
        if abs(here.gain_ratio - before.gain_ratio) > _DISAGREES * u_gain:
            return f"receiver {number}: gain Q/I {here.gain_ratio:.3f} here, {before.gain_ratio:.3f} before"
        if abs(here.quadrature_error_deg - before.quadrature_error_deg) > _DISAGREES * u_angle:
            angles = here.quadrature_error_deg, before.quadrature_error_deg
            return f"receiver {number}: quadrature error {angles[0]:.2f} degrees here, {angles[1]:.2f} before"
    return ""


def knows_more(prior: Sequence[FrontEnd], own: Sequence[FrontEnd]) -> bool:
    """Return whether a prior is twice as certain of some constant as the run by itself."""
    return any(
        before.u_gain_ratio < _TWICE * here.u_gain_ratio
        or before.u_quadrature_error_deg < _TWICE * here.u_quadrature_error_deg
        for here, before in zip(own, prior, strict=True)
    )


def front_end_prior(constants: Sequence[FrontEnd], phase_sign: int) -> FloatArray:
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
