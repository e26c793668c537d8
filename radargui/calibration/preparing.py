"""A recording made ready: its joint estimate, and the likelihoods that follow from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from radargui.calibration.falls import LEAST_FLIGHT_S, MOST_FLIGHTS, Falls
from radargui.calibration.likelihood import Measured
from radargui.conditioning.condition import NoMotion, condition
from radargui.estimation.adaptive.estimate import estimate_adaptive
from radargui.estimation.adaptive.found import adaptive_rounds
from radargui.estimation.joint import estimate_joint
from radargui.estimation.motion_estimate import MotionEstimate
from radargui.estimation.solve.minimise import Solution
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.recording import Recording
from radargui.model.setup import Setup

MOST_POINTS = 300
"""Of a recording's paths: what they have in common from sample to sample makes more of them worth no more."""
U_PATH_M = 3e-4
"""Of each of them, where the samples decide in the end: what a wrong geometry does to a joint estimate's paths."""


@dataclass(frozen=True)
class Prepared:
    """A recording and what an estimate says of it with the setup as it is.

    Attributes
    ----------
    name
        Of the recording.
    measured
        Paths, thinned.
    onset_s, impact_s, after_m_s, end_s
        Onset, impacts and the velocities after them, and the end of the last flight.
    """

    name: str
    measured: Measured
    onset_s: float
    impact_s: FloatArray
    after_m_s: FloatArray
    end_s: float

    def falls(self, place: str) -> Falls:
        """Return its motion as falls from a place.

        Raises
        ------
        ProcessingError
            Nothing falls in it.
        """
        if self.end_s - self.onset_s < LEAST_FLIGHT_S:
            raise ProcessingError(
                f"{self.name}: no free fall of {1e3 * LEAST_FLIGHT_S:g} ms was found",
                reasons=("it is no drop", "the antennas are far from where the setup says"),
                remedy="Give the recordings of drops with --known fall.",
            )
        return Falls(place, self.onset_s, self.impact_s, self.after_m_s, self.end_s)


def prepare(recording: Recording, setup: Setup) -> Prepared:
    """Measure the paths of a recording, each receiver by itself: of a wrong geometry they know next to nothing.

    The joint estimate would bend them: flights that obey gravity, and image theory, fit no wrong antennas, and walls
    that are not there make up for it (10 mm of path at 3 degrees).

    Parameters
    ----------
    recording, setup
        As for `processing.process`.

    Raises
    ------
    ProcessingError
        Nothing moves, or no estimate can be made.
    """
    conditioned = condition(recording, setup)
    if isinstance(conditioned, NoMotion):
        raise ProcessingError(f"{recording.name}: {conditioned.reason}")
    estimate = estimate_adaptive(adaptive_rounds(conditioned, setup))
    stride = max(1, estimate.time_s.size // MOST_POINTS)
    change = np.where(estimate.valid, estimate.change_m, np.nan)[:, ::stride]
    measured = Measured(estimate.time_s[::stride], change, U_PATH_M)
    return Prepared(recording.name, measured, estimate.onset_s, *_flights(estimate))


def solve_jointly(recording: Recording, setup: Setup, progress: Callable[[float], None] = lambda _: None) -> Solution:
    """Return the joint estimate's solution with a setup that is nearly right.

    Raises
    ------
    ProcessingError
        There is none.
    """
    conditioned = condition(recording, setup)
    if isinstance(conditioned, NoMotion):
        raise ProcessingError(f"{recording.name}: {conditioned.reason}")
    return estimate_joint(adaptive_rounds(conditioned, setup), setup, progress=progress).chosen.solution


def _flights(estimate: MotionEstimate) -> tuple[FloatArray, FloatArray, float]:
    """Return impacts, velocities after them and the end of the last flight that is used."""
    impacts = np.asarray(estimate.impact_s)[:MOST_FLIGHTS]
    edges = [estimate.onset_s, *impacts]
    last = next((n for n in range(1, len(edges)) if edges[n] - edges[n - 1] < LEAST_FLIGHT_S), len(edges) - 1)
    place = estimate.position_m
    if last == 0 or place is None:
        return np.empty(0), np.empty((0, 3)), estimate.onset_s
    end, kept, after = float(edges[last]), impacts[: last - 1], []
    for begin, stop in zip(kept, edges[2 : last + 1], strict=True):
        here = (estimate.time_s > begin + 0.003) & (estimate.time_s < stop - 0.003)
        after.append(np.polyfit(estimate.time_s[here] - begin, place[:, here].T, 2)[1])
    return kept, np.array(after).reshape(-1, 3), end
