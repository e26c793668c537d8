"""A fit by samples that settles: deviations of maps and mirrors, and the noise, follow it and are followed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from radargui.calibration.fit import Fit, fit
from radargui.calibration.likelihood import Likelihood, World
from radargui.calibration.signal_likelihood import SignalLikelihood
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
        shared = np.linalg.slogdet(found.information()[0] + np.eye(found.z.size))[1]
        own = sum(np.linalg.slogdet(one.inner)[1] for one in found.locals_)
        widths = sum(one.log_widths() for one in self.likelihoods if isinstance(one, SignalLikelihood))
        return float(-found.cost - 0.5 * (shared + own) - widths)


def settle(
    world: World,
    likelihoods: Sequence[Likelihood],
    start: Fit,
    own: Sequence[FloatArray],
    round_done: Callable[[], None],
    renewals: int = RENEWALS,
) -> Settled:
    """Fit, and re-estimate deviations of maps and mirrors in between.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    *_, last = settling(world, likelihoods, start, own, round_done, renewals)
    return last


def settled_at_last(settled: Settled, round_done: Callable[[], None]) -> Settled:
    """Return the fit with deviations re-estimated until that gains nothing: they follow one another slowly.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    found, best = settled.found, settled
    rounds = settling(found.world, settled.likelihoods, found, found.own, round_done, MOST_RENEWALS)
    for number, one in enumerate(rounds):
        gained = one.log_evidence - best.log_evidence
        best = one if gained > 0.0 else best
        # the first has the deviations that it came with
        if number and gained < AT_LAST * len(one.likelihoods):
            break
    return best


def settling(
    world: World,
    likelihoods: Sequence[Likelihood],
    start: Fit,
    own: Sequence[FloatArray],
    round_done: Callable[[], None],
    renewals: int = RENEWALS,
) -> Iterator[Settled]:
    """Yield the fit after each renewal, the first before any; parameters as for `settle`."""
    found = start
    for number in range(renewals + 1):
        if number:
            likelihoods, own = _renewed(likelihoods, found)
        found = fit(world, likelihoods, held=start.held, start=found, own=own, round_done=round_done, steps=STEPS)
        yield Settled(found, tuple(likelihoods))


def approach(
    world: World,
    likelihoods: Sequence[Likelihood],
    start: Fit,
    own: Sequence[FloatArray],
    round_done: Callable[[], None],
) -> Settled:
    """Fit from paths that are tenths of a millimetre off, where samples are so many deviations that nothing is linear.

    The noise is first taken as large as the misfit is, so that priors hold what is hardly determined, and follows it
    down.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    likelihoods, own = list(likelihoods), list(own)
    locals_ = [one.at(world, start.z, state) for one, state in zip(likelihoods, own, strict=True)]
    found, least, widths = start, 1.0, np.inf
    for _ in range(MOST_RENEWALS):
        for n, (one, local) in enumerate(zip(likelihoods, locals_, strict=True)):
            if isinstance(one, SignalLikelihood):
                likelihoods[n] = one.scaled(local.misfit, least)
        before, widths = widths, sum(one.log_widths() for one in likelihoods if isinstance(one, SignalLikelihood))
        if widths > before - SETTLED:
            break
        found = fit(world, likelihoods, held=start.held, start=found, own=own, round_done=round_done, steps=STEPS)
        own, locals_, least = list(found.own), list(found.locals_), SLOWLY
    return settle(world, likelihoods, found, own, round_done)


def _renewed(likelihoods: Sequence[Likelihood], found: Fit) -> tuple[list[Likelihood], list[FloatArray]]:
    pairs = [
        one.renewed(state, local) if isinstance(one, SignalLikelihood) else (one, state)
        for one, state, local in zip(likelihoods, found.own, found.locals_, strict=True)
    ]
    return [one for one, _ in pairs], [own for _, own in pairs]
