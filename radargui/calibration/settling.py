"""Settle a fit by samples: deviations of maps and mirrors, and the noise, are re-estimated in turn with it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from radargui.calibration.fit import Fit, fit
from radargui.calibration.likelihood import Likelihood, Local
from radargui.model.arrays import FloatArray

RENEWALS, STEPS = 3, 4
"""How often the deviations of maps and the noise are re-estimated, and steps between."""
MOST_RENEWALS, SLOWLY = 12, 0.4
"""How often, and to which share each time at the least, the noise comes down from a start that is far."""
SETTLED = 10.0
"""The noise has come down where one renewal gains less than this in ln E."""
AT_LAST = 0.5
"""The same where nothing follows, a recording: a room beside a wall gained 28 in seven renewals, and moved by
0.2 mm."""


@dataclass(frozen=True)
class Settled:
    """A fit with its likelihoods, deviations of maps and mirrors re-estimated."""

    found: Fit
    likelihoods: tuple[Likelihood, ...]

    @property
    def log_evidence(self) -> float:
        """Laplace's approximation: -cost - ln det H / 2, all in prior deviations, less the noise scales' logarithms."""
        found = self.found
        # det H is that of the Schur complement times those of each recording's own
        shared = np.linalg.slogdet(found.information()[0] + np.eye(found.z.size))[1]
        own = sum(np.linalg.slogdet(one.inner)[1] for one in found.locals_)
        return float(-found.cost - 0.5 * (shared + own) - sum(one.log_widths() for one in self.likelihoods))


def settled_at_last(settled: Settled) -> Settled:
    """Return the fit with deviations re-estimated until the evidence grows no more.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    best = settled
    for number, one in enumerate(settling(settled.found, settled.likelihoods, settled.found.own, MOST_RENEWALS)):
        gained = one.log_evidence - best.log_evidence
        best = one if gained > 0.0 else best
        # the first has the deviations that it came with
        if number and gained < AT_LAST * len(one.likelihoods):
            break
    return best


def settling(
    start: Fit, likelihoods: Sequence[Likelihood], own: Sequence[FloatArray], renewals: int = RENEWALS
) -> Iterator[Settled]:
    """Yield the fit after each renewal of the deviations of maps and mirrors, the first before any.

    Parameters
    ----------
    start
        Shared unknowns to begin with, and which of them are held.
    likelihoods, own
        One a recording, and its own unknowns to begin with.
    renewals
        How many.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    found = start
    for number in range(renewals + 1):
        if number:
            pairs = zip(likelihoods, found.own, found.locals_, strict=True)
            likelihoods, own = zip(*(one.renewed(state, local) for one, state, local in pairs), strict=True)
        found = fit(found, likelihoods, own, STEPS)
        yield Settled(found, tuple(likelihoods))


def approach(start: Fit, likelihoods: Sequence[Likelihood], own: Sequence[FloatArray]) -> Settled:
    """Fit samples from a start that is tenths of a millimetre off, where the problem is far from linear.

    The noise is first set as large as the misfit, so that priors hold what is hardly determined, and is reduced with
    it. Parameters and errors as for `settling`.
    """
    locals_: Sequence[Local] = [one.at(start.world, start.z, z) for one, z in zip(likelihoods, own, strict=True)]
    found, least, widths = start, 1.0, np.inf
    for _ in range(MOST_RENEWALS):
        likelihoods = [one.scaled(local.misfit, least) for one, local in zip(likelihoods, locals_, strict=True)]
        before, widths = widths, sum(one.log_widths() for one in likelihoods)
        # the noise is down to what the motion leaves of the samples: from here on deviations are re-estimated, too
        if widths > before - SETTLED:
            break
        found = fit(found, likelihoods, own, STEPS)
        own, locals_, least = found.own, found.locals_, SLOWLY
    *_, last = settling(found, likelihoods, own)
    return last
