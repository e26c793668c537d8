"""The trail of the live track: what came since the last look, kept for a few seconds."""

from __future__ import annotations

import numpy as np

from radargui.gui.control.feed import Feed
from radargui.gui.plots.envelope import thin
from radargui.gui.track.shown_track import ShownTrack
from radargui.gui.track.space import MM
from radargui.model.arrays import FloatArray

_MOST_POINTS = 1500


class LiveTrail:
    """Pulls the newest positions of one acquisition."""

    def __init__(self, feed: Feed, seconds: float) -> None:
        self._feed = feed
        self._seconds = seconds
        self._drawn = -1
        self.moving = False

    def pull(self) -> ShownTrack | None:
        """Return the trail, its newest point last; None where there is nothing new."""
        live = self._feed.live
        if live is None:
            return None
        self.moving = live.moving
        latest = live.latest
        if latest == self._drawn:
            return None
        self._drawn = latest
        span = live.since(max(0, latest - self._feed.samples(self._seconds)))
        if span.index.size == 0:
            return None
        rows: FloatArray = thin(np.vstack([span.index[None], span.position_m]), _MOST_POINTS)
        return ShownTrack((rows[0] - latest) / self._feed.rate_hz, rows[1:] * MM)
