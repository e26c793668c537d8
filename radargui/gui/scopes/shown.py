"""What the scopes show: samples that come in, or those that were held when the display was paused."""

from __future__ import annotations

from dataclasses import dataclass

from radargui.acquisition.baseband import Baseband
from radargui.gui.control.state import Feed


@dataclass(frozen=True, eq=False)
class Shown:
    """Samples to look at, up to `end`.

    Attributes
    ----------
    feed
        Where they are and under which setup they were taken.
    end
        Absolute index after the newest that is shown.
    zero
        Absolute index that is 0 on the axes of time.
    window_s
        How far back from `end` is looked.
    live
        Whether more come in.
    """

    feed: Feed
    end: int
    zero: int
    window_s: float
    live: bool

    @property
    def part(self) -> tuple[object, ...]:
        """What tells one part of the samples from another."""
        return self.feed.ring, self.end, self.window_s

    @property
    def first(self) -> int:
        """Absolute index of the oldest that is shown."""
        return max(self.feed.ring.first, self.end - round(self.window_s * self.feed.rate_hz))

    def time_s(self, index: float) -> float:
        """Return the time of an absolute index on the axes."""
        return (index - self.zero) / self.feed.rate_hz


class Follower:
    """Keeps a `Baseband` in step with what is shown; made anew when another ring, window or band is looked at."""

    def __init__(self) -> None:
        self._of: tuple[object, ...] = ()
        self.band: Baseband | None = None

    def follow(self, shown: Shown, half_band_hz: float) -> Baseband:
        """Return the signals of what is shown, as far as they are taken in; a long past takes some calls."""
        of = (shown.feed.ring, half_band_hz, shown.window_s)
        if self.band is None or of != self._of or self.band.end > shown.end:
            self._of = of
            sign = shown.feed.setup.radar.phase_sign
            self.band = Baseband(shown.feed.ring, shown.feed.rate_hz, half_band_hz, shown.window_s, sign)
        self.band.pull(shown.end)
        return self.band
