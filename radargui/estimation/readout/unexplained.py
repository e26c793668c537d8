"""Stretches of one receiver that the motion of the body does not explain: a loose contact, a dip of its supply.

Method 2.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.correction.quality import LIMITS
from radargui.estimation.select.budget import NoSingleBodyError
from radargui.estimation.solve.minimise import Solution, receiver_misfits
from radargui.model.arrays import FloatArray, runs_of


@dataclass(frozen=True, slots=True)
class UnexplainedStretch:
    """Where a receiver, numbered from 0, shows what no motion of the body does."""

    receiver: int
    begin_s: float
    end_s: float


def unexplained_of(stretches: Sequence[UnexplainedStretch]) -> dict[int, str]:
    """Return what is said of each receiver that has stretches; the receivers are numbered from 0, in order."""
    said = {}
    for receiver in sorted({one.receiver for one in stretches}):
        spans = [f"{one.begin_s:.3f} to {one.end_s:.3f}" for one in stretches if one.receiver == receiver]
        said[receiver] = (
            f"shows from {', '.join(spans)} s what no motion of the sphere does (a loose contact, a dip of its "
            "supply, or something else that moves)"
        )
    return said


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
    """What is a stretch of its own. Chosen by hand on loose contacts of 3 to 15 ms, which have 100 to 90 000.

    Attributes
    ----------
    window_s
        Residuals are averaged over such windows.
    least_misfit, times_median
        A window stands out by its mean squared residual, in units of the noise and of the receiver's median.
    margin_s
        Left out on both sides.
    most_share
        Of the windows: what is wrong for longer is wrong with the model.
    """

    window_s: float = 0.005
    least_misfit: float = 30.0
    times_median: float = 30.0
    margin_s: float = 0.001
    most_share: float = 0.15


STRETCHES = StretchSettings()


def unexplained_stretches(solution: Solution, settings: StretchSettings = STRETCHES) -> tuple[UnexplainedStretch, ...]:
    """Return the stretches without which every receiver fits, in order; none where that would not do.

    Parameters
    ----------
    solution
        Converged, of too large a misfit.
    settings
        What stands out.
    """
    time_s, use = solution.problem.bins.time_s, solution.problem.use
    window = np.floor((time_s - time_s[0]) / settings.window_s).astype(np.intp)
    out = []
    for receiver, misfit in enumerate(receiver_misfits(solution.problem, solution.at)):
        # means over equal times: bins are short where the tracer is fast, and one of them is noise
        count = np.bincount(window[use], minlength=window[-1] + 1)
        mean = np.bincount(window[use], weights=misfit[use], minlength=count.size) / np.maximum(count, 1)
        typical = float(np.median(mean[count > 0]))
        # against the receiver's own median: a model that is wrong throughout has no stretch
        wrong = mean > max(settings.least_misfit, settings.times_median * typical)
        # leaving stretches out must help, or they are not what is wrong
        kept = use & ~wrong[window]
        if wrong.sum() > settings.most_share * (count > 0).sum() or misfit[kept].mean() > LIMITS.most_misfit:
            return ()
        for first, last in runs_of(wrong) * settings.window_s + time_s[0]:
            out.append(UnexplainedStretch(receiver, first - settings.margin_s, last + settings.margin_s))
    return tuple(out)
