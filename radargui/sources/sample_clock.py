"""Which sample a device takes at a time of this computer's clock, told from when its samples arrive."""

from __future__ import annotations

_DRIFT = 200e-6
"""Relative: the device's clock and this computer's agree better than this."""


class SampleClock:
    """Time of sample 0, t_0 = min over blocks of (arrival - end index / rate).

    No sample can arrive before it is taken, so the block that waited least tells best. What is known ages by the
    largest drift between the two clocks, so that a slow device clock is followed over hours.

    Parameters
    ----------
    rate_hz
        Rate of the samples.
    """

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._zero_s: float | None = None
        self._last_s = 0.0

    def arrived(self, end_index: int, now_s: float) -> None:
        """Take that all samples before `end_index` had arrived at `now_s`."""
        zero_s = now_s - end_index / self._rate_hz
        if self._zero_s is not None:
            zero_s = min(zero_s, self._zero_s + _DRIFT * max(now_s - self._last_s, 0.0))
        self._zero_s, self._last_s = zero_s, now_s

    def index_at(self, now_s: float) -> int:
        """Return the index of the sample taken at `now_s`; 0 where none has arrived yet."""
        return 0 if self._zero_s is None else round((now_s - self._zero_s) * self._rate_hz)
