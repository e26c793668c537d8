"""Hardware constants of the receivers' front ends: their pool over the runs of a session, and whether a run agrees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.front_end import FrontEnd

_CHANGE_GAIN, _CHANGE_DEG = 1e-3, 0.05
_WIDENED = 1.5
_LEAST_NEW = 0.01
_DISAGREES = 3.5


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
        At least one; the same number of receivers each. What a run knew from a prior must be taken off before
        (`without_prior`).
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


def without_prior(found: FrontEnd, prior: FrontEnd) -> FrontEnd:
    """Return what a run by itself says about a front end that was found with a prior.

    Precisions of independent Gaussians add: 1 / u^2 = 1 / u_own^2 + 1 / u_prior^2. The uncertainties found are quoted
    1.5 times the posterior's, and so is the result. Where the run adds less than 1 % to the prior's precision, the
    uncertainty is that of 1 %.
    """
    gain = _without(found.gain_ratio, found.u_gain_ratio, prior.gain_ratio, prior.u_gain_ratio)
    angle = _without(
        found.quadrature_error_deg,
        found.u_quadrature_error_deg,
        prior.quadrature_error_deg,
        prior.u_quadrature_error_deg,
    )
    return FrontEnd(*gain, *angle)


def _without(value: float, u: float, prior: float, u_prior: float) -> tuple[float, float]:
    whole, known = (_WIDENED / u) ** 2, 1.0 / u_prior**2
    own = max(whole - known, _LEAST_NEW * known)
    return prior + (value - prior) * whole / own, _WIDENED / float(np.sqrt(own))


def disagreement(found: Sequence[FrontEnd], prior: Sequence[FrontEnd]) -> str:
    """Return in which receiver a run contradicts the prior it was estimated with, empty where it does not.

    The run's own estimate must lie within 3.5 standard uncertainties of its difference from the prior.
    """
    for number, (one, before) in enumerate(zip(found, prior, strict=True), 1):
        own = without_prior(one, before)
        gain = abs(own.gain_ratio - before.gain_ratio) / np.hypot(own.u_gain_ratio, before.u_gain_ratio)
        angle = abs(own.quadrature_error_deg - before.quadrature_error_deg) / np.hypot(
            own.u_quadrature_error_deg, before.u_quadrature_error_deg
        )
        if gain > _DISAGREES:
            return f"receiver {number}: gain Q/I {own.gain_ratio:.3f} here, {before.gain_ratio:.3f} before"
        if angle > _DISAGREES:
            here, there = own.quadrature_error_deg, before.quadrature_error_deg
            return f"receiver {number}: quadrature error {here:.2f} degrees here, {there:.2f} before"
    return ""


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
