"""Pool the front ends of a session's runs, and test whether a run agrees with the pool."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.finding import Finding
from radargui.model.front_end import FrontEnd


@dataclass(frozen=True, slots=True)
class PoolSettings:
    """When earlier runs count. Chosen by hand (method 4, Front ends known before).

    Attributes
    ----------
    change_gain, change_deg, change_harmonic
        What a front end may change between runs of a session: gain ratio as a share, quadrature error, harmonics over
        the echo.
    disagrees
        A run contradicts the pool beyond so many standard uncertainties of the difference: three of 1000 by chance
        with six numbers.
    twice
        The pool helps where its uncertainty is below this share of the run's own.
    """

    change_gain: float = 1e-3
    change_deg: float = 0.05
    change_harmonic: float = 1e-4
    disagrees: float = 3.5
    twice: float = 0.5


POOL = PoolSettings()


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
        # runs of a version that did not store them know nothing of them
        known = [c for c in own if c.harmonics]
        parts = zip(*(zip(c.harmonics, c.u_harmonics, strict=True) for c in known), strict=True)
        harmonics = [_pool(*zip(*part, strict=True)) for part in parts]
        pooled.append(
            FrontEnd(
                gain,
                float(np.hypot(u_gain, POOL.change_gain)),
                angle,
                float(np.hypot(u_angle, POOL.change_deg)),
                tuple(mean for mean, _ in harmonics),
                tuple(float(np.hypot(u, POOL.change_harmonic)) for _, u in harmonics),
            )
        )
    return tuple(pooled)


def _pool(values: Sequence[float], u: Sequence[float]) -> tuple[float, float]:
    weight = 1.0 / np.square(u)
    mean = float((weight * values).sum() / weight.sum())
    # runs that agree better than their u lets expect do so by chance: below one it does not count
    birge = float((weight * np.square(np.subtract(values, mean))).sum() / max(len(values) - 1, 1))
    return mean, float(np.sqrt(max(birge, 1.0) / weight.sum()))


def disagreement(own: Sequence[FrontEnd], prior: Sequence[FrontEnd]) -> Finding | None:
    """Return in which receiver a run contradicts a prior it was estimated without, None where it does not.

    A difference counts beyond 3.5 of its standard uncertainties.
    """
    for number, (here, before) in enumerate(zip(own, prior, strict=True), 1):
        u_gain = np.hypot(here.u_gain_ratio, before.u_gain_ratio)
        u_angle = np.hypot(here.u_quadrature_error_deg, before.u_quadrature_error_deg)
        if abs(here.gain_ratio - before.gain_ratio) > POOL.disagrees * u_gain:
            gains = {"here": here.gain_ratio, "before": before.gain_ratio}
            return Finding("gain_changed", "warn", number, gains)
        if abs(here.quadrature_error_deg - before.quadrature_error_deg) > POOL.disagrees * u_angle:
            angles = {"here_deg": here.quadrature_error_deg, "before_deg": before.quadrature_error_deg}
            return Finding("quadrature_changed", "warn", number, angles)
    return None


def knows_more(prior: Sequence[FrontEnd], own: Sequence[FrontEnd]) -> bool:
    """Return whether a prior is twice as certain of some constant as the run by itself."""
    return any(
        before.u_gain_ratio < POOL.twice * here.u_gain_ratio
        or before.u_quadrature_error_deg < POOL.twice * here.u_quadrature_error_deg
        for here, before in zip(own, prior, strict=True)
    )


@dataclass(frozen=True, slots=True)
class LogFrontEnd:
    """What earlier runs say about one receiver's ln g, eps and harmonics, standard uncertainties beside them."""

    log_gain: float
    u_log_gain: float
    quadrature_error_rad: float
    u_quadrature_error_rad: float
    harmonics: tuple[float, ...] = ()
    u_harmonics: tuple[float, ...] = ()


def as_prior(constants: Sequence[FrontEnd]) -> tuple[LogFrontEnd, ...]:
    """Return constants as the joint estimate has them: ln g, eps in rad, harmonics."""
    return tuple(
        LogFrontEnd(
            log_gain=float(np.log(own.gain_ratio)),
            u_log_gain=own.u_gain_ratio / own.gain_ratio,
            quadrature_error_rad=float(np.radians(own.quadrature_error_deg)),
            u_quadrature_error_rad=float(np.radians(own.u_quadrature_error_deg)),
            harmonics=own.harmonics,
            u_harmonics=own.u_harmonics,
        )
        for own in constants
    )
