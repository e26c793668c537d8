"""Find the impacts of the live track as it comes; for the eye, no coefficient rests on them."""

from __future__ import annotations

import numpy as np

from radargui.live.track import LiveTrack
from radargui.model.arrays import FloatArray
from radargui.motion.impacts import IMPACT_LIMITS, find_impacts

_LOOK_S = 0.2
"""From one look for impacts to the next: a mark that comes so late comes at once for the eye."""
_AGAIN_S, _LATEST_S = 0.1, 1.0
"""Looked at once more each time: an impact is told from both sides of it; the most, the first fringes come late."""
_STEP_S = 0.001
"""Between heights that are looked at: finer ones take time, and show nothing that is seen."""
_U_M = 1e-4
"""Of live heights (see `experiment.live_bounce`)."""


class LiveImpacts:
    """The impacts of the live track so far.

    Parameters
    ----------
    rate_hz
        Samples a second.

    Attributes
    ----------
    found
        Sample index and place in m of each one found, shape (4, n).
    """

    def __init__(self, rate_hz: float) -> None:
        self.found: FloatArray = np.empty((4, 0))
        self._rate_hz = rate_hz
        self._due = self._begin = 0

    def look(self, live: LiveTrack, gravity_m_s2: float) -> None:
        """Look for new ones in the newest of a track; most times nothing is done."""
        latest = live.latest
        if latest < self._due:
            return
        self._due = latest + self._samples(_LOOK_S)
        span = live.since(max(self._begin, latest - self._samples(_LATEST_S)))
        if span.index.size < 2:
            return
        step = max(1, round(_STEP_S / (span.time_s[1] - span.time_s[0])))
        time_s, places = span.time_s[::step], span.position_m[:, ::step]
        # nothing moves, or nobody knows where: then no mark comes, and the next look begins where this one did
        known = np.flatnonzero(np.isfinite(places[2]))
        if known.size:
            self._begin = int(span.index[step * known[-1]]) - self._samples(_AGAIN_S)
        for at_s in find_impacts(time_s, places[2], np.full(time_s.size, _U_M), gravity_m_s2):
            index = at_s * self._rate_hz
            # each is looked at some times
            if not self.found.size or index > self.found[0, -1] + self._samples(IMPACT_LIMITS.apart_s):
                place = places[:, np.searchsorted(time_s, at_s)]
                self.found = np.column_stack([self.found, [index, *place]])

    def _samples(self, seconds: float) -> int:
        return round(seconds * self._rate_hz)
