"""Find circles, places and impacts by adaptive rounds, from which the joint estimate may begin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.adaptive.circle_data import averaging_loss, unit_phasor
from radargui.estimation.adaptive.circle_layout import CircleLayout
from radargui.estimation.adaptive.rough import RoughPhases, rough_phases
from radargui.estimation.adaptive.rounds import (
    Round,
    best_round,
    first_round,
    located,
    moved_round,
    next_round,
    quick_round,
    recounted_round,
    still_round,
    timed_round,
)
from radargui.estimation.forward.bins import BinnedData, bin_by_fringe
from radargui.estimation.signals import ScaledSignals, scaled_signals
from radargui.model.arrays import FloatArray, robust_sd
from radargui.model.setup import Setup
from radargui.motion.impacts import find_impacts, find_stops, find_turns
from radargui.physics.path_length import MIN_RECEIVERS, locate_falling, path_lengths, range_factor
from radargui.signals.conditioned import Conditioned


def foretold_round(binned: BinnedData, one: Round, normal: FloatArray) -> Round:
    """Return a round whose worst receiver has the phases that the others predict, and a circle without maps.

    The places are as near to the line of fall as the other receivers' paths allow. The worst receiver is the one
    without which they are nearest to it, because a wrong count of fringes moves them sideways by centimetres.

    Parameters
    ----------
    binned
        Data of three receivers or more.
    one
        The round, with maps.
    normal
        Upward normal of the floor, shape (3,).
    """
    antennas, release, per_m = binned.antennas, binned.release_m, 2.0 * np.pi / binned.wavelength_m
    change = one.phase_rad / per_m

    def without(receiver: int) -> FloatArray:
        kept = np.arange(antennas.n_receivers) != receiver
        others = replace(antennas, receivers_m=antennas.receivers_m[kept])
        return locate_falling(change[kept], others, release, normal)

    def sideways(place: FloatArray) -> float:
        away = place - release[:, None]
        return float(((away - np.outer(normal, normal @ away)) ** 2).sum())

    places = [without(receiver) for receiver in range(antennas.n_receivers)]
    # without the wrong count the others agree on a fall that is straight
    worst = min(range(antennas.n_receivers), key=lambda receiver: sideways(places[receiver]))
    place = places[worst]
    phase = one.phase_rad.copy()
    phase[worst] = per_m * (path_lengths(place, antennas) - path_lengths(release[:, None], antennas))[worst]
    shape = range_factor(place, antennas, release)[worst] * averaging_loss(phase, binned.bins)[worst]
    moving, own = ~binned.rest, slice(2 * worst, 2 * worst + 2)
    seen = np.array([1.0, 1.0j]) @ one.value[own]
    # what is left to find of a circle whose phase is known: a complex factor and the centre, linear in the signal
    wave = np.stack([shape * unit_phasor(phase[worst]), np.ones(shape.size)], axis=1)
    turned, centre = np.linalg.lstsq(wave[moving], seen[moving], rcond=None)[0]
    return _on_circle(replace(one, phase_rad=phase, place=place, made_from=None), worst, turned, centre, shape)


HARDLY_TURNS = 2.0
"""A receiver that counts fewer turns may see none: over a floor that reflects, what comes by it winds by itself."""


def unwound_round(binned: BinnedData, one: Round) -> Round | None:
    """Return a round in which the path of the receiver with the fewest fringes keeps its length; None where it winds.

    A receiver may hardly see the motion on a level circle, where the changes of both parts of its path cancel. It then
    shows the wave over the floor, which turns several times: in one level circle 0.17 fringes were counted as 1.1, and
    the place was 18 mm off instead of 0.14.

    Parameters
    ----------
    binned
        Data of three receivers or more.
    one
        The round.
    """
    turns = np.ptp(one.phase_rad, axis=1) / (2.0 * np.pi)
    if turns.min() > HARDLY_TURNS:
        return None
    still, phase = int(turns.argmin()), one.phase_rad.copy()
    phase[still] = 0.0
    mean = (np.array([1.0, 1.0j]) @ binned.bins.value[2 * still : 2 * still + 2]).mean()
    # its circle was that of what winds; offsets are small against an echo that is tuned for it
    return located(
        binned, _on_circle(replace(one, phase_rad=phase, made_from=None), still, mean, 0.0j, np.ones(phase.shape[1]))
    )


def _on_circle(one: Round, receiver: int, turned: complex, centre: complex, shape: FloatArray) -> Round:
    """Return a round with one receiver on a circle without maps: centre, wave at rest, course of the amplitude."""
    amplitude, at_rest, fits = one.amplitude.copy(), one.rest_phase_rad.copy(), [*one.fits]
    # ln g and eps at zero, as their priors have them: a circle that hardly turns tells neither
    theta = np.zeros_like(fits[receiver].theta)
    theta[CircleLayout.constants] = centre.real, centre.imag, 0.0, 0.0, np.log(np.abs(turned))
    fits[receiver] = replace(fits[receiver], theta=theta)
    amplitude[receiver], at_rest[receiver] = np.abs(turned) * shape, np.angle(turned)
    return replace(one, rest_phase_rad=at_rest, amplitude=amplitude, fits=tuple(fits))


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
            tried.append(best_round(self.data, recounted))
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
            counted = best_round(data, moved_round(data, *found))
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
    turns = _turns(data, last, np.asarray(setup.floor.normal), impacts) if locates else np.zeros(0)
    return AdaptiveRounds(signals, data, rough, last, impacts, turns)


def _still(data: BinnedData, rough: RoughPhases) -> Round:
    counted = np.array([np.interp(data.bins.time_s, rough.time_s, row) for row in rough.phase_rad])
    return still_round(data, rough.ellipses, counted)


def _from_count(data: BinnedData, rough: RoughPhases, *, quick: bool = False) -> Round:
    """Return the best round with maps, begun from constant ellipses that count the fringes.

    The evidence decides among starts with different counts of fringes. A quick round tries a single length.
    """
    still = _still(data, rough)
    first = first_round(data, still)
    # few fringes do not hold the circle of the range factor: its centre can run away and lose cycles; and
    # an echo that grows otherwise than by its range leaves the circle of the range factor no centre
    timed, chosen = timed_round(data, still), quick_round if quick else best_round
    tried = [chosen(data, next_round(data, first, START.first_length_m))]
    for other in (timed, still):
        if all(_counts_otherwise(one, other) for one in tried):
            tried.append(chosen(data, next_round(data, other, START.first_length_m)))
    return max(tried, key=lambda one: one.log_evidence)


def _recounted(data: BinnedData, last: Round) -> Round:
    """Return a round, or the one with the fringes counted again by its circles if the tracer then jumps less.

    The evidence does not decide this, because places that a lost fringe has separated have maps of their own.
    """
    other = recounted_round(data, last)
    if not _counts_otherwise(other, last):
        return last
    # a lost fringe is a jump of centimetres between two bins
    return min(last, best_round(data, other), key=lambda one: _fastest_m_s(data, one))


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
