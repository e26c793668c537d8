"""From signals to circles, places and impacts: the adaptive rounds, shared with the joint estimate as its start."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.correction.adaptive.rough import rough_phases
from radargui.correction.adaptive.rounds import (
    Ground,
    Round,
    best_round,
    first_round,
    next_round,
    still_round,
    timed_round,
)
from radargui.correction.bins import bin_by_fringe
from radargui.correction.signals import Signals, read_signals
from radargui.geometry.antennas import place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.motion.kinks import find_kinks, find_turns
from radargui.motion.onset import find_onset
from radargui.motion.segment import find_segment

_BEFORE_ONSET_S = 0.03
_FIRST_LENGTH_M = 0.15
_SAME_TURN_S = 0.006
_OTHER_COUNT_RAD = 2.0


@dataclass(frozen=True, slots=True)
class Found:
    """What the adaptive rounds found.

    Attributes
    ----------
    signals
        The samples.
    ground
        Bins and geometry.
    first, last
        The first round (range law alone) and the last (maps).
    onset_s
        End of the rest as seen in the samples.
    start_s
        A little before: until then the tracer rests for sure.
    impact_s
        Impacts seen in the places; empty with fewer than three receivers.
    turn_s
        Further sharp minima of the height, some of them impacts.
    """

    signals: Signals
    ground: Ground
    first: Round
    last: Round
    onset_s: float
    start_s: float
    impact_s: FloatArray
    turn_s: FloatArray

    @property
    def has_rest(self) -> bool:
        """Whether the record begins at rest; else its first bin takes the place of the rest."""
        return self.onset_s > float(self.signals.time_s[0])


def adaptive_rounds(recording: Recording, setup: Setup) -> Found:
    """Fit circles with maps of position; once more with the bins broken at the impacts.

    Parameters
    ----------
    recording, setup
        One to four receivers.

    Raises
    ------
    ProcessingError
        Nothing moves.
    """
    signals = read_signals(recording, setup.radar.phase_sign)
    segment = find_segment(signals.value, signals.rate_hz)
    if segment is None:
        raise ProcessingError("Nothing moves in this recording.", reasons=("the tracer was not released",))
    onset = find_onset(signals.time_s, signals.value)
    if onset is None:
        raise ProcessingError("Nothing moves in this recording.", reasons=("the tracer was not released",))
    begin = float(signals.time_s[0])
    onset = max(onset, begin)
    rough = rough_phases(signals, onset)
    # a slow beginning is seen late: by about as much as the shaking of the voltages is seen after the onset
    late = max(0.0, float(signals.time_s[segment.first]) - onset)
    start = max(onset - late - _BEFORE_ONSET_S, begin + 0.02) if onset > begin else begin
    antennas, release = place_antennas(setup), np.asarray(setup.tracer.release_position_m)
    impacts = np.zeros(0)
    for _ in range(2):
        bins = bin_by_fringe(signals, rough.time_s, rough.turns_hz, start, impacts)
        ground = Ground(bins, antennas, release, setup.radar.wavelength_m, bins.last_s < start, signals.delay_s, onset)
        counted = np.array([np.interp(bins.time_s, rough.time_s, row) for row in rough.phase_rad])
        still = still_round(ground, rough.ellipses, counted)
        first = first_round(ground, still)
        last = _with_maps(ground, still, first)
        if impacts.size or antennas.n_receivers < 3:
            break
        impacts = _impacts(ground, last, np.asarray(setup.floor.normal))
        if impacts.size == 0:
            break
    turns = np.zeros(0) if antennas.n_receivers < 3 else _turns(ground, last, np.asarray(setup.floor.normal), impacts)
    return Found(signals, ground, first, last, onset, start, impacts, turns)


def _with_maps(ground: Ground, still: Round, first: Round) -> Round:
    """Return the best round with maps; starts that count other fringes have rivals, and the evidence decides.

    Few fringes do not hold the circle of the range law: its centre can run away and lose cycles.
    """
    timed = timed_round(ground, still)
    last = best_round(ground, next_round(ground, first, _FIRST_LENGTH_M))
    rivals = [last]
    for other in (timed, still):
        if min(float(np.abs(one.phase_rad - other.phase_rad).max()) for one in rivals) > _OTHER_COUNT_RAD:
            rivals.append(best_round(ground, next_round(ground, other, _FIRST_LENGTH_M)))
    return max(rivals, key=lambda r: r.log_evidence)


def _turns(ground: Ground, last: Round, normal: FloatArray, impact_s: FloatArray) -> FloatArray:
    """Return the sharp minima of the height that are not impacts already."""
    turns = find_turns(ground.bins.time_s, *_height(ground, last, normal))
    near = (np.abs(turns[:, None] - impact_s[None]) < _SAME_TURN_S).any(axis=1)
    return np.asarray(turns[~near])


def _impacts(ground: Ground, last: Round, normal: FloatArray) -> FloatArray:
    return find_kinks(ground.bins.time_s, *_height(ground, last, normal))


def _height(ground: Ground, last: Round, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the height of the places and its noise from second differences."""
    height = normal @ last.place
    second = np.diff(height[~ground.rest], 2)
    noise = float(np.median(np.abs(second))) / 0.6745 / np.sqrt(6.0) if second.size else 1e-4
    return height, np.full(height.size, max(noise, 1e-9))
