"""Converge a model in rounds: minimise, renew the maps, re-estimate the priors; and settle its breaks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.forward.bins import BinnedData
from radargui.estimation.forward.motion_spline import SplineMotion
from radargui.estimation.select.breaks import BREAKS, kicks_beside, misfit_times, respline, sharp_turns, side_kicks
from radargui.estimation.select.fewer_bins import fewer_bins, with_bins_of
from radargui.estimation.solve.break_velocities import break_speeds
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_breaks
from radargui.estimation.solve.initial_problem import release_times
from radargui.estimation.solve.minimise import (
    MINIMISE,
    MinimiseSettings,
    Solution,
    local_chi_square,
    log_evidence,
    minimise,
)
from radargui.estimation.solve.prior_deviations import update_priors, updated_noise_scale
from radargui.estimation.solve.problem import Start
from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class RoundSettings:
    """How long rounds go on. All chosen by hand.

    Attributes
    ----------
    steps, minimise
        Gauss-Newton steps in a round, and when a round ends earlier.
    noise_from_round
        The noise scale follows the misfit from this round on: before it the maps have not grown.
    settled_ln_evidence, min_rounds
        A round that changes ln E by less than `settled_ln_evidence` is the last, but not before `min_rounds`: the
        first may stand still while deviations shrink by their largest step.
    after_breaks
        Rounds of convergence whenever breaks have changed.
    break_rounds
        How often breaks are added and dropped at most.
    same_s
        A break closer than this to one that was dropped counts as the same (s).
    cascades
        How often the body is let bounce on at most.
    no_worse
        Misfits within this factor count as equal: one knot more or less changes as much.
    """

    steps: int = 6
    minimise: MinimiseSettings = MINIMISE
    noise_from_round: int = 2
    settled_ln_evidence: float = 0.2
    min_rounds: int = 4
    after_breaks: int = 4
    break_rounds: int = 6
    same_s: float = 0.0015
    cascades: int = 3
    no_worse: float = 1.02


LAST = RoundSettings(
    minimise=MinimiseSettings(close=0.02, nothing=0.002),
    noise_from_round=0,
    settled_ln_evidence=0.04,
    min_rounds=2,
)
"""For the chosen model, which has been converged on fewer bins: its maps have grown. Ended at 0.5, the flights of
one drop were one fewer than two rounds later; ended at 0.1, g of another hung by 1.6 of its u on the way there, 0.007
now. Costs one per cent of the time."""
COARSE = RoundSettings(minimise=MinimiseSettings(close=1.0, nothing=0.25))
"""While models are compared: evidences are told apart by units, and what one round leaves the next one takes."""


def converge(start: Start, rounds: int, round_done: Callable[[], None], settings: RoundSettings = COARSE) -> Solution:
    """Alternate Gauss-Newton with updates of maps and priors until the evidence settles.

    Parameters
    ----------
    start
        Problem and first state.
    rounds
        At most this many, and as many again where Gauss-Newton has not come to a minimum: before it has, the evidence
        says nothing. Where it does not then either, the solution says so (`settled`).
    round_done
        Called once a round; may raise to cancel.
    settings
        When the rounds end.

    Raises
    ------
    SolveError
        The normal matrix cannot be factored.
    """
    now = begun(start, settings)
    while not now.has_ended(rounds):
        now = next_round(now)
        round_done()
    return now.solution


@dataclass(frozen=True)
class Converging:
    """A model on its way.

    Attributes
    ----------
    solution, ln_evidence
        After the last round.
    settings
        When the rounds end.
    rounds
        How many there were after the first minimum.
    stands
        Whether ln E has settled.
    """

    solution: Solution
    ln_evidence: float
    settings: RoundSettings
    rounds: int = 0
    stands: bool = False

    def has_ended(self, rounds: int) -> bool:
        """Whether it needs no further round, where about so many are meant (see `converge`)."""
        enough = self.rounds >= rounds and self.solution.settled
        return self.stands or enough or self.rounds == 2 * rounds


def begun(start: Start, settings: RoundSettings = COARSE) -> Converging:
    """Return a model at its first minimum."""
    solution = minimise(start, settings.steps, settings.minimise)
    return Converging(solution, log_evidence(solution), settings)


def next_round(before: Converging) -> Converging:
    """Return a model after one more round: maps and priors renewed, and the minimum that they have."""
    # priors and minimum by turns: neither is right without the other (MacKay 1992, section 4)
    solution, settings = before.solution, before.settings
    problem, scale = update_priors(solution), solution.problem.noise_scale
    # too early it would take for noise what the maps are about to explain
    if before.rounds >= settings.noise_from_round:
        scale = updated_noise_scale(solution)
    # maps, range and scattering follow the motion without derivatives of theirs
    problem = replace(problem, noise_scale=scale).at_places(positions_at_bins(solution), solution.state.theta)
    # the same valley: what was too far there is too far here
    start = Start(problem, solution.state)
    solution = minimise(start, settings.steps, settings.minimise, solution.damping)
    now = log_evidence(solution)
    settled = solution.settled and abs(now - before.ln_evidence) < settings.settled_ln_evidence
    stands = settled and before.rounds >= settings.min_rounds
    return Converging(solution, now, settings, before.rounds + 1, stands)


def settle_breaks(
    data: BinnedData,
    solution: Solution,
    normal: FloatArray,
    round_done: Callable[[], None],
) -> Solution:
    """Add breaks where the motion turns sharply, drop those without a jump, until neither changes.

    First the body is let bounce on from its last impact, because a missing break between short flights shifts its
    neighbour. The bins are put together anew around each set of breaks. A break that was dropped is not tried again at
    the same place. Walls beside an impact are sought when all else is settled. Of the rounds whose misfit is within 2 %
    of the smallest the one with most impacts, best known, is returned (evidences are not comparable between different
    knots).

    Parameters
    ----------
    data
        All bins.
    solution
        Converged.
    normal
        Upward normal of the floor, shape (3,).
    round_done
        As of `converge`.

    Raises
    ------
    SolveError
        The normal matrix cannot be factored.
    """
    sharp, refused, beside = np.zeros(0), np.zeros(0), np.zeros(0)
    solution = _bounced_on(data, solution, normal, round_done)
    seen = [solution]
    for number in range(COARSE.break_rounds):
        speeds = break_speeds(solution, normal)
        inserted = solution.problem.prior.mean[solution.problem.layout.breaks]
        # so near to an impact a break bends anything: it is a wall, or none
        is_beside = np.isin(inserted, beside)
        good = np.where(is_beside, speeds.are_kicks(), speeds.are_kinks())
        if is_beside.any():
            # what lacks a wall that is there is no rival, nor what has one that is none
            seen = [solution] if good[is_beside].all() else seen[:-1]
        # or the same ripple would be tried for ever
        refused = np.concatenate([refused, inserted[~good]])
        last = number == COARSE.break_rounds - 1
        turns = sharp_turns(solution, normal)
        # a kick beside a turn is that impact's own
        sought = np.concatenate([turns, _away(side_kicks(solution, normal), turns, BREAKS.apart_s)])
        new = np.zeros(0) if last else _away(sought, refused, COARSE.same_s)
        beside = np.zeros(0)
        if new.size == 0 and good.all() and not last:
            # once all that is far from impacts is known: no line goes through a wall
            best = _best(seen, normal)
            motion = SplineMotion(best.at.spline, best.state.coefficients)
            kicks = kicks_beside(motion, normal, data.gravity_m_s2)[0]
            new = beside = _away(kicks, refused, BREAKS.min_beside_s)
            if new.size:
                solution, speeds, good = best, break_speeds(best, normal), np.ones(best.at.spline.break_s.size, bool)
        stiff = misfit_times(solution) if new.size == 0 else np.zeros(0)
        if new.size == 0 and good.all() and (stiff.size == 0 or sharp.size > 0):
            break
        sharp = np.concatenate([sharp, stiff])
        breaks = np.sort(np.concatenate([speeds.time_s[good], new]))
        # the old motion on new knots, not a new start: the mismatch found so far fits it
        fine = np.concatenate([release_times(data.onset_s), sharp])
        motion = respline(solution.at.spline, solution.state.coefficients, breaks, fine)
        solution = converge(_with_breaks(data, solution, motion), COARSE.after_breaks, round_done)
        seen.append(solution)
    return _best(seen, normal)


def _best(seen: Sequence[Solution], normal: FloatArray) -> Solution:
    """Return the one with most impacts, best known, of those whose misfit is about the smallest.

    Solutions that did not reach their minimum are left out, unless none did.
    """
    seen = [one for one in seen if one.settled] or seen
    # more impacts at the same misfit: one too few is a missed bounce, one too many is judged by its jump later
    enough = COARSE.no_worse * min(_misfit(one) for one in seen)
    return max((one for one in seen if _misfit(one) <= enough), key=lambda one: _impacts(one, normal))


def _impacts(solution: Solution, normal: FloatArray) -> tuple[int, float]:
    """Return how many impacts there are, and less the uncertainty of the least known jump."""
    speeds = break_speeds(solution, normal)
    impacts = speeds.are_impacts()
    return int(impacts.sum()), -float(speeds.u_jump_m_s[impacts].max(initial=0.0))


def _bounced_on(
    data: BinnedData,
    solution: Solution,
    normal: FloatArray,
    round_done: Callable[[], None],
) -> Solution:
    """Return the solution with breaks where the body should land next, as long as that finds more impacts."""
    for _ in range(COARSE.cascades):
        speeds = break_speeds(solution, normal)
        impacts = speeds.are_impacts()
        expected = speeds.expected_impacts(float(solution.at.spline.edge_s[-1]))
        if expected.size == 0:
            break
        # what came after the last impact was found without its bounces: begun again
        before = speeds.time_s[speeds.time_s <= speeds.time_s[impacts][-1]]
        breaks = np.concatenate([before, expected])
        motion = respline(solution.at.spline, solution.state.coefficients, breaks, release_times(data.onset_s))
        trial = converge(_with_breaks(data, solution, motion), COARSE.after_breaks, round_done)
        more = _impacts(trial, normal)[0] > int(impacts.sum())
        if not more or _misfit(trial) > COARSE.no_worse * _misfit(solution):
            break
        solution = trial
    return solution


def _with_breaks(data: BinnedData, solution: Solution, motion: SplineMotion) -> Start:
    return with_bins_of(problem_with_breaks(solution, motion), fewer_bins(data, motion.spline.break_s))


def _misfit(solution: Solution) -> float:
    return float(local_chi_square(solution.problem, solution.at).mean())


def _away(moments: FloatArray, others: FloatArray, same_s: float) -> FloatArray:
    near = np.abs(moments[:, None] - others[None]) < same_s
    return moments[~near.any(axis=1)]
