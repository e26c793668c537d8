"""Find intervals of one receiver that an estimate does not explain although the other receivers agree with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, fdtrc

from radargui.estimation.flights.drop_model import wave_gain
from radargui.estimation.flights.estimate import DropEstimate
from radargui.estimation.forward.bins import Bins
from radargui.estimation.forward.signal_model import shown
from radargui.estimation.select.budget import NoSingleBodyError
from radargui.estimation.solve.minimise import Solution, receiver_misfits
from radargui.model.arrays import BoolArray, FloatArray, runs_of
from radargui.model.channel_quality import UnexplainedStretch


class UnexplainedError(NoSingleBodyError):
    """No model of one moving body describes the signals, but one does without some short intervals.

    Parameters
    ----------
    misfit
        Chi-square of each receiver, shape (n_receivers,).
    stretches
        The intervals without which one does.
    """

    def __init__(self, misfit: FloatArray, stretches: tuple[UnexplainedStretch, ...]) -> None:
        super().__init__(misfit)
        self.stretches = stretches


@dataclass(frozen=True, slots=True)
class StretchSettings:
    """What counts as an unexplained interval.

    Attributes
    ----------
    window_s
        Length of the windows over which residuals are averaged: half of the shortest disturbance that the curves show.
    chance
        Probability that noise alone makes a window of a record stand out.
    min_share
        Least residual as a share of the receiver's wave. What a model lacks of reflectors or antennas leaves
        hundredths, beyond chance in loud signals; a contact or a supply that fails leaves a half and more.
    margin_s
        Time left out on both sides.
    max_share
        Largest share of the windows: what is wrong for longer is an error of the model.
    min_part
        Least share of the receiver's squared residuals beyond noise that lies in its intervals. Dips had 0.86 and more,
        a wall beside an impact 0.1.
    """

    window_s: float = 0.005
    chance: float = 1e-3
    min_share: float = 0.1
    margin_s: float = 0.001
    max_share: float = 0.15
    min_part: float = 0.5


STRETCHES = StretchSettings()


@dataclass(frozen=True, slots=True)
class Residuals:
    """The residuals of an estimate.

    Attributes
    ----------
    bins, use
        Means of the samples, and which count, shape (n_bins,).
    misfit
        Squared residual of both channels in units of the white noise, shape (n_receivers, n_bins).
    noise
        The noise divided by the receiver's wave, same shape.
    """

    bins: Bins
    use: BoolArray
    misfit: FloatArray
    noise: FloatArray

    @classmethod
    def of_solution(cls, solution: Solution) -> Residuals:
        """Return what a joint estimate leaves."""
        problem, at = solution.problem, solution.at
        wave = np.array([np.median(np.abs(signal.direct)) for signal in at.signals])
        return cls(problem.bins, problem.use, receiver_misfits(problem, at), _noise(problem.bins, wave))

    @classmethod
    def of_drop(cls, drop: DropEstimate) -> Residuals:
        """Return what a drop by its flights leaves."""
        model, at = drop.model, drop.at
        wave = np.abs(shown(at.waves) * wave_gain(model, at)[:, 0, 0, :, 0])
        return cls(model.bins, model.used, at.misfit, _noise(model.bins, np.median(wave, axis=(1, 2))))


def _noise(bins: Bins, wave: FloatArray) -> FloatArray:
    return np.asarray(bins.sigma.reshape(wave.size, 2, -1).mean(axis=1) / wave[:, None])


def unexplained_stretches(
    residuals: Residuals, settings: StretchSettings = STRETCHES
) -> tuple[UnexplainedStretch, ...]:
    """Return the stretches that hold most of what is wrong with their receiver, in order; none where it lasts.

    In each window a receiver is compared with its noise by chi-square, or with its median chi-square if that is larger,
    because a model that is wrong throughout has no such intervals; and with the other receivers by Fisher's F, because
    an error of the motion shows in all of them. The windows before and after belong to the interval if they are beyond
    noise. What lies farther off was spread by the fit.

    Parameters
    ----------
    residuals
        Residuals of an estimate that has converged, whatever its misfit.
    settings
        What stands out.
    """
    bins, use, misfit = residuals.bins, residuals.use, residuals.misfit
    n_receivers = misfit.shape[0]
    # means over equal times: bins are short where the tracer is fast, and one of them is noise
    window = np.floor((bins.time_s - bins.time_s[0]) / settings.window_s).astype(np.intp)
    count = np.bincount(window[use], minlength=window[-1] + 1)

    def mean(values: FloatArray) -> FloatArray:
        sums = [np.bincount(window[use], weights=row[use], minlength=count.size) for row in values]
        return np.asarray(sums) / np.maximum(count, 1)

    by_window, share = mean(misfit), np.sqrt(2.0 * mean(misfit * residuals.noise**2))
    typical = np.maximum(np.median(by_window[:, count > 0], axis=1), 1.0)
    relative = by_window / typical[:, None]
    # I and Q of each bin
    dof, level = 2.0 * count, settings.chance / (n_receivers * (count > 0).sum())
    is_beyond_noise = (count > 0) & (chdtrc(dof, dof * relative) < level)
    others = (relative.sum(axis=0) - relative) / (n_receivers - 1)
    ratio = relative / np.maximum(others, np.finfo(float).tiny)
    is_alone = (count > 0) & (fdtrc(dof, (n_receivers - 1) * dof, ratio) < level)
    stands_out = is_beyond_noise & is_alone & (share > settings.min_share)
    near = stands_out.copy()
    near[:, 1:] |= stands_out[:, :-1]
    near[:, :-1] |= stands_out[:, 1:]
    wrong = near & is_beyond_noise
    above = count * np.maximum(by_window - 1.0, 0.0)
    out = []
    for receiver in np.flatnonzero(stands_out.any(axis=1)).tolist():
        is_short = wrong[receiver].sum() <= settings.max_share * (count > 0).sum()
        if not (is_short and above[receiver, wrong[receiver]].sum() > settings.min_part * above[receiver].sum()):
            continue
        for first, last in runs_of(wrong[receiver]):
            inside = (window >= first) & (window < last)
            begin, end = float(bins.first_s[inside].min()), float(bins.last_s[inside].max())
            out.append(UnexplainedStretch(receiver, begin - settings.margin_s, end + settings.margin_s))
    return tuple(out)
