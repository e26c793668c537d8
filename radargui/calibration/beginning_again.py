"""The samples begun again, with antennas and walls as found: a wall not yet in the model leads motions astray."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.calibration.fit import Fit
from radargui.calibration.likelihood import Likelihood, PathLikelihood
from radargui.calibration.settling import Settled, approach
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.verdict import LOOSE, fit_paths
from radargui.calibration.wall_search import n_mirrors, planes_of
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError, SolveError

MOST_TIMES, GAINED = 2, 10.0
"""How often it begins again, and the gain in ln E with which it does so once more."""
DISAGREEING = 1.5
"""Birge ratio from which it begins again: recordings that agree have not gone astray."""


@dataclass(frozen=True)
class Beginning:
    """What the samples began with.

    Attributes
    ----------
    rough
        The fit by paths.
    by_paths
        Its likelihoods.
    likelihoods, own
        By samples, as first guessed, and the recordings' own unknowns there.
    """

    rough: Fit
    by_paths: tuple[PathLikelihood, ...]
    likelihoods: tuple[Likelihood, ...]
    own: tuple[FloatArray, ...]


def begun_again(beginning: Beginning, settled: Settled, n_bare: int, normal: FloatArray) -> Settled:
    """Return the better of a fit and those that begin with its antennas and walls, and nothing else of it.

    Paths were up to 2 mm, samples tenths of the signal off while a wall was missing: a fall that had gone 5 mm from its
    place for that stayed there when the wall was found, its floor turned round (laboratory 5331200, 300 in ln E).

    Parameters
    ----------
    beginning
        What it began with.
    settled
        The fit so far.
    n_bare
        Mirrors that it began with.
    normal
        Upward normal of the floor, shape (3,).
    """
    best = settled
    for _ in range(MOST_TIMES):
        # paths alone have no mirrors, and nothing to go astray in
        if n_mirrors(best) == 0 or best.found.birge() < DISAGREEING:
            break
        try:
            again = begun_with(beginning, best, n_bare, normal)
        except (ProcessingError, SolveError):
            break
        gained = again.log_evidence - best.log_evidence
        best = again if gained > 0.0 else best
        if gained < GAINED:
            break
    return best


def begun_with(beginning: Beginning, settled: Settled, n_bare: int, normal: FloatArray) -> Settled:
    """Return all recordings' fit, begun with the antennas and walls of another, maybe of a few; parameters as above.

    Raises
    ------
    ProcessingError, SolveError
        There is no solution.
    """
    found, rough, walls = settled.found, beginning.rough, planes_of(settled, n_bare, normal)
    antennas = np.array([bool(one.key) for one in found.world.unknowns])
    # places and motions by paths, only as sharply as what bends these lets them say
    at = np.where(antennas, found.z, 0.0)
    motions = fit_paths(found.world, beginning.by_paths, rough.held | antennas, LOOSE[:2], z=at)
    likelihoods, states = list[Likelihood](), []
    for one, own, state in zip(beginning.likelihoods, beginning.own, motions.own, strict=True):
        if isinstance(one, SignalLikelihood):
            # of a fit by paths only the motion is the same thing: what follows there is a receiver's slow errors
            state = np.concatenate([state[: one.n_motion], own[one.n_motion :]])
        if walls:
            one, state = one.with_mirrors(walls, state)
        likelihoods.append(one)
        states.append(state)
    return approach(replace(motions, held=rough.held), likelihoods, states)
