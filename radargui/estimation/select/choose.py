"""Choose the model by evidence: with or without a floor, which length of the maps, which walls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.adaptive.found import AdaptiveRounds
from radargui.estimation.forward.position_map import make_basis
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.select.budget import (
    BIN_ROUNDS,
    ROUNDS,
    BudgetSpentError,
    LooseMapsError,
    NoSingleBodyError,
    SearchBudget,
)
from radargui.estimation.select.chosen_model import Alternative, ChosenModel
from radargui.estimation.select.converge import COARSE, LAST, RoundSettings, converge, settle_breaks
from radargui.estimation.select.fall import FoundFall
from radargui.estimation.select.fewer_bins import fewer_bins, in_full, misfit_on, with_bins_of
from radargui.estimation.select.loose_maps import bias_deviations, is_lost
from radargui.estimation.select.race import best_started, race
from radargui.estimation.select.unseen_mirrors import unseen_mirrors
from radargui.estimation.select.wall_grid import WALLS
from radargui.estimation.select.wall_walk import walked
from radargui.estimation.select.walls import WallSearch, WallTrial, search_wall
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_flights, problem_with_mirrors
from radargui.estimation.solve.held_setup import moved_with_setup_held, setup_posterior, with_setup_held
from radargui.estimation.solve.initial_problem import first_motion, initial_problem
from radargui.estimation.solve.minimise import Solution, chi_square, log_evidence, solved_at
from radargui.estimation.solve.problem import Start
from radargui.model.arrays import FloatArray
from radargui.physics.mirrors import FLOOR, MirrorPlane, has_floor, walls_of


@dataclass(frozen=True, slots=True)
class ChoiceSettings:
    """Limits of the decisions by evidence. All chosen by hand; the accuracy benchmark is their test.

    Attributes
    ----------
    floors_below_m
        Depths below the lowest place at which the floor is sought: the first, about a sphere's radius; and all of them
        below a motion without an impact, which need not have touched the floor.
    deep_floors
        Number of the deeper floors that are converged: the best after some steps.
    beyond_doubt
        Gain in ln E of a floor above which it is not compared again when the breaks are settled.
    good_misfit
        Median local chi-square above which something is missing in the model.
    max_behind
        A model so far behind in ln E for each number in the data, after the first minimum and each round, is given up.
    bad_misfit
        The same above which models cannot be compared: they are compared again when it has gone.
    hopeless_misfit, max_left
        The same above which no wall can explain it, and the search ends, where it is more than this share of the wave:
        in 45 dB, antennas off by their u beside a wall of 0.04 leave 0.01, a misfit of 120.
    grown_bias
        Deviation of the bias maps, in amplitudes, above which they explain something beside a floor.
    max_walls
        Largest number of walls, which are searched one after the other.
    shortest_length_m
        Least correlation length of the bias maps: shorter ones describe what mirrors do.
    other_lengths_m, few_fringes
        Lengths tried where a receiver saw fewer fringes: then the adaptive rounds hardly tell them apart.
    temper
        ln E counts divided by this when alternatives are weighed: evidence is approximate. Six drops had 62 to 100 % of
        the track inside 2u with 2.5, and 95 to 100 % with 5.
    min_weight
        Alternatives below this weight against the best are forgotten.
    first_rounds, last_rounds
        Rounds of convergence while models are compared, and for the chosen model.
    bin_rounds, rounds
        What the search may spend, as of `SearchBudget`.
    """

    floors_below_m: tuple[float, ...] = (0.010, 0.04, 0.08, 0.13, 0.19, 0.26)
    deep_floors: int = 2
    beyond_doubt: float = 100.0
    good_misfit: float = 1.15
    max_behind: tuple[float, float] = (0.5, 0.05)
    bad_misfit: float = 2.0
    hopeless_misfit: float = 100.0
    max_left: float = 0.03
    grown_bias: float = 0.002
    max_walls: int = 2
    shortest_length_m: float = 0.09
    other_lengths_m: tuple[float, ...] = (0.14, 0.22)
    few_fringes: float = 6.0
    temper: float = 5.0
    min_weight: float = 0.01
    first_rounds: int = 4
    last_rounds: int = 10
    bin_rounds: float = BIN_ROUNDS
    rounds: tuple[int, int] = ROUNDS


CHOICES = ChoiceSettings()


def choose_model(
    found: AdaptiveRounds | FoundFall,
    drift: Drift,
    normal: FloatArray,
    round_done: Callable[[], None],
    known_front_ends: Sequence[LogFrontEnd] | None = None,
    settings: ChoiceSettings = CHOICES,
    entered: Callable[[str], None] = lambda stage: None,
) -> ChosenModel:
    """Converge without and with a floor, keep what the evidence prefers, settle the impacts, look for walls.

    Parameters
    ----------
    found
        What it begins with: a drop by its flights, or the adaptive rounds.
    drift
        Slow noise.
    normal
        Upward normal of the floor, shape (3,).
    round_done
        Called once a round; may raise to cancel.
    known_front_ends, settings
        What earlier runs say about ln g and eps, one a receiver; by what the evidence decides.
    entered
        Called with "flights", "walls" and "last" as these begin.

    Raises
    ------
    SolveError
        No model can be solved, or none within the budget of the search.
    NoSingleBodyError
        No model describes the signals; `LooseMapsError` where maps stand for them.
    """
    budget = SearchBudget(found.data.bins.n_bins, round_done, settings.bin_rounds, settings.rounds)
    selection = _Selection(found, drift, normal, budget.spend, known_front_ends, settings)
    solution, gain, alternatives = selection.floor()
    entered("flights")
    solution, alternatives = selection.with_flights(solution, alternatives)
    typical = selection.misfit(solution)
    hopeless = typical > settings.hopeless_misfit
    if hopeless.any() and selection.share_left(solution)[hopeless].max() > settings.max_left:
        # walls would only be fitted to what no echo of one body is
        raise NoSingleBodyError(typical)
    choices = [_decided("A floor that reflects", gain)]
    if drift.count and not drift.level.any():
        choices.append("The offsets drift on the rest: slow functions of time are fitted.")
    elif drift.count:
        choices.append("1/f noise found on the rest: its slow part is fitted, its fast part widens the noise.")
    undecided: list[Alternative] = []
    lengths: tuple[Alternative, ...] = ()
    ended_early = False
    entered("walls")
    try:
        if found.fringes.min() < settings.few_fringes:
            solution, lengths = selection.other_lengths(solution)
        choices.append(f"Bias maps with a correlation length of {solution.problem.bias_basis.length_m:.2f} m.")
        solution, undecided, sentences = selection.walls(solution)
        choices += sentences
    except BudgetSpentError:
        ended_early, budget.left = True, 2 * settings.first_rounds
        alternatives = selection.as_likely(solution, alternatives)
        choices.append(f"The search for walls was ended after {budget.rounds} rounds.")
    alternatives += lengths
    # not before: a wall has put right what looked as lost: an offset of nine waves, then 0.009 mm off
    if is_lost(solution, found.data.onset_s):
        raise LooseMapsError(selection.misfit(solution))
    # whether there is a wall, and where, is a question of its own beside floor and lengths
    among = 1.0 + sum(other.weight for other in alternatives)
    undecided = [replace(other, weight=among * other.weight) for other in undecided]
    budget.left = 2 * settings.last_rounds
    entered("last")
    solution = selection.converged(in_full(solution, selection.whole), settings.last_rounds, LAST)
    if not solution.settled:
        choices.append("The last rounds did not come to a minimum.")
    choices.append(f"Misfit (chi-square) {', '.join(f'{value:.2f}' for value in chi_square(solution))}.")
    whole, every = selection.whole, (*alternatives, *undecided)
    others = [replace(one, solution=solved_at(with_bins_of(one.solution, whole))) for one in every]
    if not ended_early:
        moved, weight = unseen_mirrors(solution, normal, settings.temper, selection.foretold)
        # mirrors that nothing excludes: a question of its own beside others
        among = 1.0 + sum(other.weight for other in others)
        others += [Alternative(replace(solution, state=one), among * weight) for one in moved]
    held = with_setup_held(solution)
    others = [
        replace(
            one,
            solution=with_setup_held(one.solution)
            if one.solution.normal is not solution.normal
            else moved_with_setup_held(held, solution.problem, one.solution.state),
        )
        for one in others
    ]
    return ChosenModel(held, tuple(others), tuple(choices), ended_early, setup_posterior(solution))


class _Selection:
    """The decisions on one recording, each of which converges a few models and compares their evidence."""

    def __init__(
        self,
        found: AdaptiveRounds | FoundFall,
        drift: Drift,
        normal: FloatArray,
        round_done: Callable[[], None],
        known_front_ends: Sequence[LogFrontEnd] | None,
        settings: ChoiceSettings,
    ) -> None:
        self.found, self.normal, self.round_done = found, normal, round_done
        self.known_front_ends, self.settings = known_front_ends, settings
        self.compared: list[Solution] = []
        self.foretold: FloatArray | None = None
        self._misfit: tuple[Solution, FloatArray] | None = None
        bins = drift.widen(found.data.bins)
        self.whole = replace(found.data, bins=bins, slow_noise=drift.uncorrelated(bins))
        # models are told apart alike by few bins as by all; the chosen one converges on all
        self.data = fewer_bins(self.whole, found.break_s)

    def converged(self, start: Start, rounds: int, settings: RoundSettings = COARSE) -> Solution:
        """Return the solution after some rounds."""
        return converge(start, rounds, self.round_done, settings)

    def gain_of(self, bare: Solution | None, floored: Solution | None) -> float:
        """Return what a floor gains in ln E, the least it does where one of the two was given up."""
        least = self.settings.max_behind[-1] * self.whole.bins.value.size
        if bare is None or floored is None:
            return least if bare is None else -least
        return log_evidence(floored) - log_evidence(bare)

    def preferred(self, bare: Solution | None, floored: Solution | None) -> Solution:
        """Return the one with the floor where that gains."""
        in_order = (floored, bare) if self.gain_of(bare, floored) > 0.0 else (bare, floored)
        return next(one for one in in_order if one is not None)

    def raced(self, starts: Sequence[Start]) -> list[Solution | None]:
        """Return the solutions of models with and without a floor, None for one that cannot be right."""
        first, later = (share * self.whole.bins.value.size for share in self.settings.max_behind)
        return race(starts, self.settings.first_rounds, self.round_done, (first, later))

    def from_rounds(self, found: AdaptiveRounds, length_m: float, planes: tuple[MirrorPlane, ...]) -> Start:
        """Return the model of the last adaptive round with bias maps of a length, and with a floor or without."""
        start = found.last
        motion = first_motion(self.whole, start.place, found.signals.rest_end_s, found.break_s)
        return initial_problem(self.data, motion, start.receiver_constants(), planes, length_m, self.known_front_ends)

    def misfit(self, solution: Solution) -> FloatArray:
        """Return `misfit_on` all bins, asked several times of one solution."""
        if self._misfit is None or self._misfit[0] is not solution:
            self._misfit = solution, misfit_on(self.whole, solution)
        return self._misfit[1]

    def share_left(self, solution: Solution) -> FloatArray:
        """Return the residual that a receiver's misfit is, as a share of its wave, shape (n_receivers,)."""
        sigma = np.median(self.whole.bins.sigma, axis=1).reshape(-1, 2).mean(axis=1)
        wave = [np.median(np.abs(signal.direct)) for signal in solution.at.signals]
        return np.asarray(np.sqrt(self.misfit(solution)) * sigma / wave)

    def starts(self) -> list[Start]:
        """Return where to begin: without a floor first, then with floors."""
        found, settings = self.found, self.settings
        if isinstance(found, FoundFall):
            return found.starts(self.data, settings.shortest_length_m, self.known_front_ends)
        # shorter maps than that take what mirrors do, and hold these down
        length = found.last.bias.length_m if found.last.bias is not None else settings.shortest_length_m
        length = max(settings.shortest_length_m, length)
        # both converged: a floor and bias maps explain the same at first sight, and only the evidence tells them apart
        # later adaptive rounds may have followed a wrong count of fringes
        starts = [self.from_rounds(found, length, ())]
        for one in (found, *found.other_counts(self.normal)):
            floored = [
                self.from_rounds(one, length, (self.floor_below(one.last.place, depth),))
                for depth in settings.floors_below_m[: 1 if one.impact_s.size else None]
            ]
            # nobody knows how far below a motion without an impact it is
            starts += [floored[0], *best_started(floored[1:], settings.deep_floors, self.round_done)]
        return starts

    def floor(self) -> tuple[Solution, float, tuple[Alternative, ...]]:
        """Return the solution with or without a floor, its breaks settled, what the floor gains, and what is left."""
        settings = self.settings
        # side by side: who is hopelessly behind costs no further round
        bare, *floors = self.raced(self.starts())
        tried = (bare, max(filter(None, floors), key=log_evidence, default=None))
        gain = self.gain_of(*tried)
        self.compared = [one for one in tried if one is not None]
        best = self.preferred(*tried)
        alternatives = self._alternatives(best, self.compared)
        # at a misfit of hundreds a missing break looks like a floor: a dead stop invented one, and 0.8 mm
        blind = self.misfit(best).max() > settings.bad_misfit
        solution = settle_breaks(self.whole, best, self.normal, self.round_done)
        if blind or 0.0 < gain < settings.beyond_doubt:
            solution, gain, alternatives = self.floor_compared_again(solution)
        return solution, gain, alternatives

    def with_flights(
        self, solution: Solution, alternatives: tuple[Alternative, ...]
    ) -> tuple[Solution, tuple[Alternative, ...]]:
        """Return them with the equation of free flight where they fly, weighed anew; as they are where nothing does.

        From here on mirrors are told apart by what they make of the flights, too.
        """
        if solution.problem.layout.sizes.flight:
            # begun so
            return solution, alternatives
        flying = problem_with_flights(solution)
        if flying is None:
            return solution, alternatives
        others = [(problem_with_flights(one.solution), one.solution) for one in alternatives]
        best, *tried = self.raced([flying, *(start or Start(one.problem, one.state) for start, one in others)])
        best = best or self.converged(flying, self.settings.first_rounds)
        return best, self._alternatives(best, [one for one in tried if one is not None])

    def floor_below(self, place: FloatArray, depth_m: float) -> MirrorPlane:
        """Return where the floor is sought for places (3, n)."""
        # the sphere cannot fall through it
        lowest = place[:, int(np.argmin(self.normal @ place))]
        foot, data = lowest - depth_m * self.normal, self.data
        return MirrorPlane(foot, self.normal, FLOOR, surface=data.surface, edges=data.edges)

    def floor_compared_again(self, solution: Solution) -> tuple[Solution, float, tuple[Alternative, ...]]:
        """Return the solution with a floor or without, what the floor gains now, and the other where it is possible.

        The breaks are settled now, or a wall has taken over what maps explained.
        """
        settings, here = self.settings, solution.problem.inputs.planes
        walls, floored = self.without_and_with_floor(solution)
        bare, floor = self.raced([problem_with_mirrors(solution, planes) for planes in (walls, floored)])
        tried = [one for one in (bare, floor) if one is not None]
        if floor is not None and floored is not here and self.preferred(bare, floor) is floor:
            # without its reflection it leans to where the walls have bent the motion; a plane of its own begins anew
            again = problem_with_mirrors(floor, (replace(floored[0]), *walls))
            tried.append(self.converged(again, settings.first_rounds))
            floor = max(tried[-2:], key=log_evidence)
        best = self.preferred(bare, floor)
        return best, self.gain_of(bare, floor), self._alternatives(best, tried)

    def without_and_with_floor(self, solution: Solution) -> tuple[tuple[MirrorPlane, ...], tuple[MirrorPlane, ...]]:
        """Return the mirrors of a solution without a floor and with one."""
        here = solution.problem.inputs.planes
        walls = walls_of(here)
        if has_floor(here):
            return walls, here
        return walls, (self.floor_below(positions_at_bins(solution), self.settings.floors_below_m[0]), *walls)

    def as_likely(self, solution: Solution, alternatives: Sequence[Alternative]) -> tuple[Alternative, ...]:
        """Return the models that a search without an end began with, each as likely as what it chose.

        The rest of the search might have decided otherwise, also about the floor. If no alternative has the other
        answer to that, the motion that was found is converged with it.
        """
        others = [one.solution for one in alternatives]
        floored = has_floor(solution.problem.inputs.planes)

        def is_otherwise(one: Solution) -> bool:
            return has_floor(one.problem.inputs.planes) != floored

        if any(map(is_otherwise, self.compared)) and not any(map(is_otherwise, others)):
            bare, with_floor = self.without_and_with_floor(solution)
            start = problem_with_mirrors(solution, bare if floored else with_floor)
            others.append(self.converged(start, self.settings.first_rounds))
        return tuple(Alternative(one, 1.0) for one in others if one.settled)

    def other_lengths(self, solution: Solution) -> tuple[Solution, tuple[Alternative, ...]]:
        """Return the solution with the bias maps' correlation length that the evidence prefers, and the others.

        The evidence distinguishes lengths only after the breaks are settled.
        """
        planes, bins = solution.problem.inputs.planes, solution.problem.bins
        visited = positions_at_bins(solution)[:, bins.last_s >= self.found.signals.rest_end_s]
        bases = [None, *(make_basis(visited, length) for length in self.settings.other_lengths_m)]
        # the present length goes through the same rounds: evidence still moves
        starts = [problem_with_mirrors(solution, planes, bias) for bias in bases]
        tried = [self.converged(start, self.settings.first_rounds) for start in starts]
        best = max(tried, key=log_evidence)
        return best, self._alternatives(best, tried)

    def walls(self, solution: Solution) -> tuple[Solution, list[Alternative], list[str]]:
        """Return the solution with the walls that the evidence keeps, what stays possible, and sentences about both.

        Where something reflects, walls that are too weak to convince remain alternatives, and so do other places of a
        wall that convinces.
        """
        undecided: list[Alternative] = []
        sentences: list[str] = []
        for number in range(self.settings.max_walls):
            # what the first has not put right no second one has
            if number and is_lost(solution, self.found.data.onset_s):
                break
            misfit_asks = bool(self.misfit(solution).max() > self.settings.good_misfit)
            # a second wall costs as much as the first and is hardly ever there: only residuals ask for it
            asked = self._asks_for_walls(solution) if number == 0 else misfit_asks
            if not asked and not (number == 0 and solution.problem.inputs.planes):
                break
            search = search_wall(solution, self.normal, self.round_done, thorough=asked)
            sentences.append(_decided("A wall that reflects", search.gain, WALLS.convincing))
            self.foretold = None if search.tried else search.foretold
            if search.gain <= WALLS.convincing:
                undecided += self._weighed(search.tried)
                break
            solution, undecided = self.moved_on(search)
            if not has_floor(solution.problem.inputs.planes):
                # maps that stood for the wall stood for the floor, too
                solution, gain, others = self.floor_compared_again(solution)
                sentences.append(_decided("Beside it a floor that reflects", gain))
                # the wall's other places lack the floor
                lower = self._weight(-gain)
                undecided = [*others, *(replace(one, weight=lower * one.weight) for one in undecided)]
        return solution, undecided, sentences

    def moved_on(self, search: WallSearch) -> tuple[Solution, list[Alternative]]:
        """Return the best of a search with its breaks settled and its wall moved, and what stays possible."""
        settled = settle_breaks(self.whole, search.tried[0].solution, self.normal, self.round_done)
        if isinstance(self.found, FoundFall) and search.gain > WALLS.beyond_doubt:
            # flights were never bent by a wall that was missing: it was found where it stands
            return settled, self._weighed(search.tried[1:])
        best, *moved = walked(settled, self.normal, self.round_done)
        # other places of the wall say how well the motion is known: evidence alone does not tell them apart
        ahead, behind = log_evidence(best), log_evidence(settled) - search.gain
        left = [replace(trial, gain=trial.gain + behind - ahead) for trial in search.tried[1:]]
        undecided = self._weighed([*left, *(WallTrial(one, log_evidence(one) - ahead) for one in moved)])
        if best is not settled:
            # bounces that a wall out of place hid
            best = settle_breaks(self.whole, best, self.normal, self.round_done)
        return best, undecided

    def _weighed(self, trials: Sequence[WallTrial]) -> list[Alternative]:
        """Return the trials that have weight, their gains counted from the best; what is no minimum has none."""
        weighed = [Alternative(one.solution, self._weight(one.gain)) for one in trials if one.solution.settled]
        return [one for one in weighed if one.weight > self.settings.min_weight]

    def _asks_for_walls(self, solution: Solution) -> bool:
        """Return whether residuals, or bias maps that grow although a floor is there, ask for another reflector."""
        # beside a floor in the model, bias maps have nothing to do but to stand for a mirror that is missing
        grown = solution.problem.inputs.planes and bias_deviations(solution).max() > self.settings.grown_bias
        return bool(grown or self.misfit(solution).max() > self.settings.good_misfit)

    def _weight(self, gain: float) -> float:
        """Return the tempered weight of an alternative against the best, exp(gain in ln E / 5), at most one."""
        # never above the best: a trial may be better converged than what was kept
        return float(np.exp(min(0.0, gain) / self.settings.temper))

    def _alternatives(self, best: Solution, tried: list[Solution]) -> tuple[Alternative, ...]:
        """Return the other solutions with their weights, those above 1 % of the best."""
        ahead = log_evidence(best)
        return tuple(self._weighed([WallTrial(one, log_evidence(one) - ahead) for one in tried if one is not best]))


def _decided(what: str, gain: float, least: float = 0.0) -> str:
    """Return a sentence on what is kept above a gain; a gain beyond doubt is not computed completely."""
    most = WALLS.max_behind[-1]
    value = f"{gain:+.0f}" if abs(gain) < most else f"beyond {np.copysign(most, gain):+.0f}"
    return f"{what} is {'kept' if gain > least else 'left out'}: log evidence {value}."
