"""Keep hum, noise and echo of the last second at rest, against which a motion is recognised.

Decide whether a track that was lost may count as at the release again.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.signals.hum import Hum, find_hum
from radargui.signals.segment import sliding_variance

FALLEN_M = 0.05
"""Farther from where it rested than this, it has left that place. By hand."""


class Release:
    """Remembers losses and drops until a hand has hung the tracer up.

    Attributes
    ----------
    began_anew
        See `LiveEstimate.began_anew`.
    """

    def __init__(self) -> None:
        self.began_anew = False
        # it lies where nobody knows; it has left that place; a drop has ended since it hung
        self._lies = self._left = self._fell = False

    def lose(self, *, seen: bool) -> None:
        """Note that the place is not known any more.

        Parameters
        ----------
        seen
            False if a whole drop may have passed unseen, because the signals were no circles.
        """
        self.began_anew = self._left = True
        if not seen and not self._fell:
            self._lies, self._left = True, False

    def goes(self, away_m: float) -> None:
        """Note how far from the release the track is."""
        self._left |= away_m > FALLEN_M

    def fallen(self) -> None:
        """Note that a drop has ended: a tracer that was lost in it lies somewhere until a hand has moved it."""
        self._lies, self._left, self._fell = self.began_anew, False, True

    def hang_up(self, *, strayed: bool) -> bool:
        """Note that a hand has moved the tracer; return whether the track may begin at the release.

        Parameters
        ----------
        strayed
            Whether the tracer was followed to another place: then the track begins there, and the estimate says so.
        """
        if self._lies and not self._left:
            return False
        self.began_anew = strayed and not self._lies
        self._lies = self._fell = False
        return True


PAST_S = 1.0
"""Looked at: tells 50 Hz from 60 Hz and from a drift, and a fall that begins is a small part of it."""
FIRST_S, EVERY_S = 0.2, 0.25
"""The first look, whole periods of 50 and of 60 Hz, and from one look to the next. By hand."""
AGAIN_S = 2.0
"""The hum is measured anew so often: it keeps its phase over more than the seconds of a drop. By hand."""
HUMS = 2.0
"""Quiet level above which a hum is sought: it shakes the means as much as their noise does."""
TOGETHER = 4
"""Block means averaged where the echo is weak: 2 ms still follow the Doppler of a fall, with half of the noise."""
WEAK = 4.0
"""An echo is weak that a motion would shake the voltages by less than so many times what is asked for (in variance). By
hand: the voltages at rest are the echo and an offset, which may hide half of it."""
FOLLOWED = 0.75
"""Of the variance of a circle, what is left in means of 2 ms at the Doppler of a fall of 0.3 m, at the least."""
QUIET_PERCENTILE = 20.0
"""Of the levels remembered: motion does not raise it until it fills four fifths of them. Chosen by hand."""
HUM_BEGINS, HUM_ENDS = 2.0, 1.5
"""Times the activity of the hum itself that a motion makes at the least: a lamp that doubles the hum, and a hum that
ends or changes its phase, make no more than the hum. By hand."""
NOTHING = 0.1
"""Of a block mean's noise, in variance: voltages at rest that are nearer to zero show no echo. Nothing hangs there, or
the device passes no direct voltage, as many a Doppler module does; only a motion tells then how hard one shakes them.
By hand: an echo of the noise of one sample at 2 kS/s has five times that."""
MOTION_S = 1.0
"""Remembered of the last motion."""
SEEN_AGAIN = 1.2
"""What was too weak counts as seen from so much on (see `Quiet.seen`): else it would flicker around one value."""


class Quiet:
    """Learns from block means while nothing moves.

    Parameters
    ----------
    rate_hz
        Block means a second.
    window
        Block means in a window of the activity.
    start
        Ratio of the activity (a variance) to the quiet level from which on there is a motion.

    Attributes
    ----------
    hum_level
        Activity of the hum that is removed; 0 without one.
    long_quiet
        Quiet level of the long means, not below what a hum requires; None where the echo is strong enough for the short
        means.
    seen
        Factor by which a fall would exceed the threshold, estimated from the voltages at rest, which are the echo and
        an offset. Where they are zero it is taken from the last motion; None before the first look.
    is_weak
        Whether a fall might not be seen.
    """

    def __init__(self, rate_hz: float, window: int, start: float) -> None:
        self._rate_hz, self._window, self._start = rate_hz, window, start
        self.forget()

    def forget(self) -> None:
        """Begin anew: the quiet level does not hold any more."""
        self._hum: Hum | None = None
        self._hum_first = self._hum_due = 0
        self.hum_level = 0.0
        self.long_quiet: float | None = None
        self.seen: float | None = None
        self.is_weak = False
        self._motion: deque[float] = deque(maxlen=round(MOTION_S * self._rate_hz))
        self._begin()

    def moves(self, level: FloatArray) -> None:
        """Note that the tracer moves, with this activity: the next rest is learned from what follows."""
        if self._past:
            self._motion.clear()
        self._motion.extend(level)
        self._begin()

    def _begin(self) -> None:
        self._past: deque[FloatArray] = deque()
        self._count = self._unseen = 0

    def push(self, means: FloatArray) -> bool:
        """Take the next block means at rest, shape (n_channels, n); return whether it is time for a look."""
        self._past.append(means)
        self._count += means.shape[1]
        self._unseen += means.shape[1]
        while self._count - self._past[0].shape[1] >= PAST_S * self._rate_hz:
            self._count -= self._past.popleft().shape[1]
        return self._count >= FIRST_S * self._rate_hz and self._unseen >= EVERY_S * self._rate_hz

    def look(self, end: int, noise_v: FloatArray) -> FloatArray | None:
        """Look at the past second.

        Parameters
        ----------
        end
            Block means since the first of all.
        noise_v
            White noise of a block mean of each channel, shape (n_channels,).

        Returns
        -------
        FloatArray or None
            The activity in that second, shape (n,), if the hum that is removed has changed; else None.
        """
        self._unseen = 0
        past = np.concatenate(list(self._past), axis=1)[:, -round(PAST_S * self._rate_hz) :]
        # I^2 + Q^2 at rest is A^2, and a circle of amplitude A has the variance A^2 / 2 in each of the two
        echo = float(((past.mean(axis=1) / noise_v) ** 2).mean())
        if echo < NOTHING and self._motion:
            # the variance of a circle that turns is the same A^2 / 2
            echo = float(np.median(self._motion))
        is_due, had = self._hum is None or end >= self._hum_due, self._hum is not None
        if is_due:
            self._find_hum(past, end, noise_v, echo)
        level = self.levels(past, end, noise_v)
        quiet, self.long_quiet = max(1.0, percentile(level)), None
        seen = echo / self.least(quiet)
        # against a hum longer means help nothing
        if echo < WEAK * self._start * quiet:
            over_hum = TOGETHER * HUM_BEGINS * self.hum_level / self._start
            self.long_quiet = max(1.0, percentile(self._long_levels(past, end, noise_v)), over_hum)
            seen = max(seen, TOGETHER * FOLLOWED * echo / self.long_quiet / self._start)
        self.seen = float(np.sqrt(seen))
        self.is_weak = self.seen < (SEEN_AGAIN if self.is_weak else 1.0)
        return level if is_due and (had or self._hum is not None) else None

    def _find_hum(self, past: FloatArray, end: int, noise_v: FloatArray, echo: float) -> None:
        self._hum, self.hum_level = None, 0.0
        shakes = percentile(whole_windows(past / noise_v[:, None], self._window))
        # a hum that hides nothing is left in the quiet level: its changes are then small beside the threshold
        if shakes > HUMS and echo < WEAK * self._start * shakes:
            self._hum = find_hum(past, self._rate_hz, (slice(0, past.shape[1]),), noise_v)
        if self._hum is not None:
            self.hum_level = shakes
            self._hum_first = end - past.shape[1]
            # the longer it was looked at the longer it is known
            self._hum_due = end + round(min(AGAIN_S, past.shape[1] / self._rate_hz) * self._rate_hz)

    def levels(self, means: FloatArray, end: int, noise_v: FloatArray) -> FloatArray:
        """Return the activity of block means, shape (n_channels, n), in each window that is whole.

        Parameters
        ----------
        means
            In volts, the last one before block `end`.
        end
            Block means since the first of all.
        noise_v
            White noise of one of them, shape (n_channels,).
        """
        return self._min_levels(means, end, noise_v, lambda one: one)

    def long_over_quiet(self, means: FloatArray, end: int, noise_v: FloatArray) -> FloatArray | None:
        """Return the activity of means of 2 ms over that at rest, in each window that is whole; None: not looked at."""
        return None if self.long_quiet is None else self._long_levels(means, end, noise_v) / self.long_quiet

    def _long_levels(self, means: FloatArray, end: int, noise_v: FloatArray) -> FloatArray:
        return self._min_levels(means, end, noise_v / np.sqrt(TOGETHER), _together)

    def _min_levels(
        self, means: FloatArray, end: int, noise_v: FloatArray, averaged: Callable[[FloatArray], FloatArray]
    ) -> FloatArray:
        raw = whole_windows(averaged(means / noise_v[:, None]), self._window)
        if self._hum is None:
            return raw
        time_s = (end - means.shape[1] - self._hum_first + np.arange(means.shape[1])) / self._rate_hz
        clean = whole_windows(averaged((means - self._hum.at(time_s)) / noise_v[:, None]), self._window)
        # a hum that ends, or that is out of step after a gap, is no motion: without it the voltages are quieter
        return np.asarray(np.minimum(raw, clean))

    def least(self, quiet: float) -> float:
        """Return the activity that a motion begins at, over a quiet level."""
        return max(self._start * quiet, HUM_BEGINS * self.hum_level)

    def min_to_go_on(self, quiet: float) -> float:
        """Return the activity below which it is quiet again: half of the threshold, to avoid flicker."""
        return max(0.25 * self._start * quiet, HUM_ENDS * self.hum_level)

    @property
    def long_to_go_on(self) -> float:
        """Return the same for `long_over_quiet`."""
        return (HUM_ENDS / HUM_BEGINS if self.hum_level else 0.25) * self._start


def percentile(level: FloatArray) -> float:
    """Return the quiet level among levels."""
    return float(np.percentile(level, QUIET_PERCENTILE))


def whole_windows(values: FloatArray, window: int) -> FloatArray:
    """Return the variance in each window that is whole, mean over channels, shape (n - window + 1,)."""
    before = window // 2
    return sliding_variance(values, window)[before : before + values.shape[1] - window + 1]


def _together(means: FloatArray) -> FloatArray:
    """Return the means of each `TOGETHER` block means that follow each other, shape (n_channels, n - 3)."""
    total = np.cumsum(means - means.mean(axis=1, keepdims=True), axis=1)
    total = np.concatenate([np.zeros((means.shape[0], 1)), total], axis=1)
    return np.asarray((total[:, TOGETHER:] - total[:, :-TOGETHER]) / TOGETHER)
