"""Find circles, places and impacts by adaptive rounds, from which the joint estimate may begin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.adaptive.foretold import foretold_round, unwound_round
from radargui.estimation.adaptive.rough import RoughPhases, rough_phases
from radargui.estimation.adaptive.rounds import (
    Round,
    best_round,
    first_round,
    moved_round,
    next_round,
    quick_round,
    recounted_round,
    refined,
    still_round,
    stride_of,
    timed_round,
)
from radargui.estimation.forward.bins import BinnedData, bin_by_fringe
from radargui.estimation.signals import ScaledSignals, scaled_signals
from radargui.model.arrays import FloatArray, robust_sd
from radargui.model.setup import Setup
from radargui.motion.impacts import find_impacts, find_stops, find_turns
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.signals.conditioned import Conditioned


@dataclass(frozen=True, slots=True)
class StartSettings:
    """How starts are compared and impacts told apart. Chosen by hand.

    Attributes
    ----------
    first_length_m
        Correlation length of the first maps: half a fall, so that they cannot follow the wave itself before places are
        known.
    same_turn_s
        A sharp minimum of the height that is closer than this to an impact is the same event.
    other_count_rad
        Two counts of fringes are different if their phases differ by more than this anywhere: noise and maps shift
        phases by some tenths.
    min_noise_m, unknown_noise_m
        Noise of the height: the least value, so that a simulated motion without noise has a scale, and the value where
        nothing moves.
    """

    first_length_m: float = 0.15
    same_turn_s: float = 0.006
    other_count_rad: float = 2.0
    min_noise_m: float = 1e-9
    unknown_noise_m: float = 1e-4


START = StartSettings()


@dataclass(frozen=True, slots=True)
class AdaptiveRounds:
    """The result of the adaptive rounds.

    Attributes
    ----------
    signals
        The samples.
    data
        Bins and geometry.
    rough
        Phases by constant ellipses, which count the fringes.
    last
        The last round (maps).
    impact_s
        Impacts seen in the places; empty with fewer than three receivers.
    turn_s
        Further sharp minima of the height, some of them impacts, and where a fall ends without a rebound.
    """

    signals: ScaledSignals
    data: BinnedData
    rough: RoughPhases
    last: Round
    impact_s: FloatArray
    turn_s: FloatArray

    @property
    def break_s(self) -> FloatArray:
        """Where the motion may have a break: impacts and turns in order, shape (n_breaks,)."""
        return np.sort(np.concatenate([self.impact_s, self.turn_s]))

    @property
    def fringes(self) -> FloatArray:
        """How many each receiver saw, shape (n_receivers,)."""
        return np.asarray(np.ptp(self.last.phase_rad, axis=1) / (2.0 * np.pi))

    @property
    def first(self) -> Round:
        """The first round (range factor alone), made when it is asked for."""
        return first_round(self.data, _still(self.data, self.rough))

    def other_counts(self, normal: FloatArray) -> list[AdaptiveRounds]:
        """Return other rounds, of three receivers or more, that count other fringes.

        Maps may have followed a wrong count. The others are: the first round; both with the worst receiver's phase
        predicted by the other receivers; one with a receiver that hardly winds held at rest; and the count in time by
        the last circles. The last one is needed where no impact has made them count again: the top speed does not tell
        then which count is right (of two level circles one was 13 mm off without it, the other is 158 mm off with it).
        Where a receiver saw less than one turn the constant ellipses are one more: an arc does not determine its
        circle, and maps can make it several times too wide (in one level circle 0.27 instead of 0.62 fringes, 5.6 mm
        off; from the ellipse's 0.52 it is 0.024 mm off).
        """
        first, counts = self.first, [self]
        tried = [first, foretold_round(self.data, self.last, normal), foretold_round(self.data, first, normal)]
        unwound, recounted = unwound_round(self.data, self.last), recounted_round(self.data, self.last)
        if unwound is not None:
            tried.append(unwound)
        if _counts_otherwise(recounted, self.last):
            tried.append(best_round(self.data, recounted, stride_of(self.data)))
        for last in tried:
            if all(_counts_otherwise(last, one.last) for one in counts):
                counts.append(self._ending_with(last, normal))
        if self.impact_s.size == 0 and self.fringes.min() < 1.0:
            # same count, another circle
            counts.append(self._ending_with(_still(self.data, self.rough), normal))
        return counts[1:]

    def _ending_with(self, last: Round, normal: FloatArray) -> AdaptiveRounds:
        impacts = _impacts(self.data, last, normal)
        return replace(self, last=last, impact_s=impacts, turn_s=_turns(self.data, last, normal, impacts))


def adaptive_rounds(conditioned: Conditioned, setup: Setup) -> AdaptiveRounds:
    """Fit circles with maps of the position, then again with bins broken at the impacts that were found.

    Parameters
    ----------
    conditioned, setup
        One to four receivers.

    Raises
    ------
    ProcessingError
        A receiver shows no signal at all.
    """
    signals = scaled_signals(conditioned)
    rough = rough_phases(signals, signals.onset_s)
    locates = signals.n_receivers >= MIN_RECEIVERS
    impacts = np.zeros(0)
    found: tuple[Round, FloatArray] | None = None
    # bins without breaks show the impacts, bins broken there the circles; where these count other fringes, once more
    for number in range(3):
        bins = bin_by_fringe(signals, rough.time_s, rough.turns_hz, signals.rest_end_s, impacts)
        data = BinnedData.of(bins, signals, setup)
        if found is not None:
            counted = best_round(data, moved_round(data, *found), stride_of(data))
            last = _recounted(data, counted) if number == 1 else counted
            if last is counted:
                break
            # other fringes, other impacts
            impacts, found = _impacts(data, last, np.asarray(setup.floor.normal)), (last, data.bins.time_s)
            continue
        # which start is right, and where the impacts are, one length shows
        if not rough.seen and locates:
            last = _from_count(data, rough, quick=True)
            impacts = _impacts(data, last, np.asarray(setup.floor.normal))
            if impacts.size and last.made_from is not None:
                found = last.made_from, data.bins.time_s
                continue
        last = _from_count(data, rough)
        for receiver in () if impacts.size else rough.seen:
            other = rough.as_seen(receiver)
            tried = _from_count(data, other)
            if tried.log_evidence > last.log_evidence:
                rough, last = other, tried
        if impacts.size or not locates:
            break
        # once: bins that are broken at the impacts move them by less than a bin
        impacts = _impacts(data, last, np.asarray(setup.floor.normal))
        if impacts.size == 0:
            break
    last = refined(data, last)
    turns = _turns(data, last, np.asarray(setup.floor.normal), impacts) if locates else np.zeros(0)
    return AdaptiveRounds(signals, data, rough, last, impacts, turns)


def _still(data: BinnedData, rough: RoughPhases) -> Round:
    counted = np.array([np.interp(data.bins.time_s, rough.time_s, row) for row in rough.phase_rad])
    return still_round(data, rough.ellipses, counted)


def _from_count(data: BinnedData, rough: RoughPhases, *, quick: bool = False) -> Round:
    """Return the best round with maps, begun from constant ellipses that count the fringes.

    The evidence decides among starts with different counts of fringes. The rounds use few bins; a quick one tries a
    single length.
    """
    still = _still(data, rough)
    first = first_round(data, still, stride_of(data))
    # few fringes do not hold the circle of the range factor: its centre can run away and lose cycles; and
    # an echo that grows otherwise than by its range leaves the circle of the range factor no centre
    stride, chosen = stride_of(data), quick_round if quick else best_round
    timed = timed_round(data, still, stride)
    tried = [chosen(data, next_round(data, first, START.first_length_m, stride), stride)]
    for other in (timed, still):
        if all(_counts_otherwise(one, other) for one in tried):
            tried.append(chosen(data, next_round(data, other, START.first_length_m, stride), stride))
    return max(tried, key=lambda one: one.log_evidence)


def _recounted(data: BinnedData, last: Round) -> Round:
    """Return a round, or the one with the fringes counted again by its circles if the tracer then jumps less.

    The evidence does not decide this, because places that a lost fringe has separated have maps of their own.
    """
    other = recounted_round(data, last)
    if not _counts_otherwise(other, last):
        return last
    # a lost fringe is a jump of centimetres between two bins
    return min(last, best_round(data, other, stride_of(data)), key=lambda one: _fastest_m_s(data, one))


def _counts_otherwise(one: Round, other: Round) -> bool:
    return float(np.abs(one.phase_rad - other.phase_rad).max()) > START.other_count_rad


def _fastest_m_s(data: BinnedData, one: Round) -> float:
    steps_m = np.linalg.norm(np.diff(one.place, axis=1), axis=0)
    return float((steps_m / np.diff(data.bins.time_s)).max())


def _turns(data: BinnedData, last: Round, normal: FloatArray, impact_s: FloatArray) -> FloatArray:
    """Return the sharp minima of the height that are not impacts already, and its dead stops."""
    height, noise = _height(data, last, normal)
    turns = find_turns(data.bins.time_s, height, noise)
    near = (np.abs(turns[:, None] - impact_s[None]) < START.same_turn_s).any(axis=1)
    turns = turns[~near]
    stops = find_stops(data.bins.time_s, height, noise, data.gravity_m_s2, impact_s)
    near = (np.abs(turns[:, None] - stops[None]) < START.same_turn_s).any(axis=1)
    return np.sort(np.concatenate([turns[~near], stops]))


def _impacts(data: BinnedData, last: Round, normal: FloatArray) -> FloatArray:
    return find_impacts(data.bins.time_s, *_height(data, last, normal), data.gravity_m_s2)


def _height(data: BinnedData, last: Round, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the height of the places and its noise from second differences."""
    height = normal @ last.place
    # a second difference has 1 + 4 + 1 variances
    second = np.diff(height[~data.rest], 2)
    noise = robust_sd(second) / np.sqrt(6.0) if second.size else START.unknown_noise_m
    return height, np.full(height.size, max(noise, START.min_noise_m))
