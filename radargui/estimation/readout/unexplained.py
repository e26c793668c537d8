"""Stretches of one receiver that the motion of the body does not explain: a loose contact, a dip of its supply.

Method 2.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, fdtrc

from radargui.correction.quality import LIMITS
from radargui.estimation.select.budget import NoSingleBodyError
from radargui.estimation.solve.minimise import Solution, receiver_misfits
from radargui.model.arrays import FloatArray, runs_of
from radargui.model.finding import Finding, refuse


@dataclass(frozen=True, slots=True)
class UnexplainedStretch:
    """Where a receiver, numbered from 0, shows what no motion of the body does."""

    receiver: int
    begin_s: float
    end_s: float


def unexplained_of(stretches: Sequence[UnexplainedStretch]) -> dict[int, Finding]:
    """Return the finding of each receiver that has stretches; the receivers are numbered from 0, in order."""
    return {
        receiver: refuse(
            "dip_unexplained",
            spans=tuple(f"{begin:.3f} to {end:.3f}" for begin, end in _joined(stretches, receiver)),
        )
        for receiver in sorted({one.receiver for one in stretches})
    }


def _joined(stretches: Sequence[UnexplainedStretch], receiver: int) -> list[tuple[float, float]]:
    """Return from when to when the stretches of a receiver go; those that overlap are one."""
    out: list[tuple[float, float]] = []
    for begin, end in sorted((one.begin_s, one.end_s) for one in stretches if one.receiver == receiver):
        if out and begin <= out[-1][1]:
            out[-1] = out[-1][0], max(end, out[-1][1])
        else:
            out.append((begin, end))
    return out


class UnexplainedError(NoSingleBodyError):
    """No model of one moving body comes near the signals, but for some short stretches.

    Parameters
    ----------
    misfit
        Chi-square of each receiver, shape (n_receivers,).
    stretches
        Without these it does.
    """

    def __init__(self, misfit: FloatArray, stretches: tuple[UnexplainedStretch, ...]) -> None:
        super().__init__(misfit)
        self.stretches = stretches


@dataclass(frozen=True, slots=True)
class StretchSettings:
    """What is a stretch of its own.

    Attributes
    ----------
    window_s
        Residuals are averaged over such windows: half of the shortest disturbance that a look at the curves shows.
    chance
        With which noise alone makes one window of a record stand out.
    least_share
        The residual is at least this share of the receiver's wave. What a model lacks of reflectors or antennas leaves
        hundredths, beyond chance in loud signals; a contact or a supply that fails leaves a half and more.
    margin_s
        Left out on both sides.
    most_share
        Of the windows: what is wrong for longer is wrong with the model.
    """

    window_s: float = 0.005
    chance: float = 1e-3
    least_share: float = 0.1
    margin_s: float = 0.001
    most_share: float = 0.15


STRETCHES = StretchSettings()


def unexplained_stretches(solution: Solution, settings: StretchSettings = STRETCHES) -> tuple[UnexplainedStretch, ...]:
    """Return the stretches without which every receiver fits, in order; none where that would not do.

    In a window a receiver is tested against its noise (chi-square; where its median is larger, against that: a model
    that is wrong throughout has no stretch) and against the other receivers there (Fisher's F), since what the motion
    lacks they all show. A window beside one that stands out belongs to it where it is beyond noise, too.

    Parameters
    ----------
    solution
        Converged, whatever its misfit.
    settings
        What stands out.
    """
    bins, use = solution.problem.bins, solution.problem.use
    misfit = receiver_misfits(solution.problem, solution.at)
    n_receivers = misfit.shape[0]
    wave = np.array([np.median(np.abs(signal.direct)) for signal in solution.at.signals])
    noise = bins.sigma.reshape(n_receivers, 2, -1).mean(axis=1) / wave[:, None]
    # means over equal times: bins are short where the tracer is fast, and one of them is noise
    window = np.floor((bins.time_s - bins.time_s[0]) / settings.window_s).astype(np.intp)
    count = np.bincount(window[use], minlength=window[-1] + 1)

    def mean(values: FloatArray) -> FloatArray:
        sums = [np.bincount(window[use], weights=row[use], minlength=count.size) for row in values]
        return np.asarray(sums) / np.maximum(count, 1)

    by_window, share = mean(misfit), np.sqrt(2.0 * mean(misfit * noise**2))
    typical = np.maximum(np.median(by_window[:, count > 0], axis=1), 1.0)
    relative = by_window / typical[:, None]
    # I and Q of each bin
    dof, level = 2.0 * count, settings.chance / (n_receivers * (count > 0).sum())
    is_beyond_noise = (count > 0) & (chdtrc(dof, dof * relative) < level)
    others = (relative.sum(axis=0) - relative) / (n_receivers - 1)
    ratio = relative / np.maximum(others, np.finfo(float).tiny)
    is_alone = (count > 0) & (fdtrc(dof, (n_receivers - 1) * dof, ratio) < level)
    out = []
    for receiver in range(n_receivers):
        stands_out = is_beyond_noise[receiver] & is_alone[receiver] & (share[receiver] > settings.least_share)
        runs = runs_of(is_beyond_noise[receiver])
        wrong = np.zeros(use.size, dtype=np.bool_)
        for first, last in runs[[bool(stands_out[slice(*run)].any()) for run in runs]]:
            inside = (window >= first) & (window < last)
            wrong |= inside
            begin, end = float(bins.first_s[inside].min()), float(bins.last_s[inside].max())
            out.append(UnexplainedStretch(receiver, begin - settings.margin_s, end + settings.margin_s))
        n_wrong = np.unique(window[wrong & use]).size
        # leaving stretches out must help, or they are not what is wrong
        if (
            n_wrong > settings.most_share * (count > 0).sum()
            or misfit[receiver, use & ~wrong].mean() > LIMITS.most_misfit
        ):
            return ()
    return tuple(out)
