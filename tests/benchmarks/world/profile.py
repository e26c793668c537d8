"""A rate that goes from value to value over time, and the way that it adds up to, in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Span:
    """From the rate before to `rate` within `lasts_s`: evenly, or by s^2 (3 - 2 s), which starts and ends gently."""

    lasts_s: float
    rate: float
    gentle: bool = False


@dataclass(frozen=True)
class Profile:
    """Spans one after another from the rate at the start; before them nothing moves, after them the last rate holds."""

    spans: tuple[Span, ...]
    start: float = 0.0

    @property
    def lasts_s(self) -> float:
        """Length of all spans in s."""
        return sum(one.lasts_s for one in self.spans)

    def way(self, time_s: Array) -> Array:
        """Return the integral of the rate at times since the first span began, shape (n,)."""
        out = np.zeros(time_s.shape)
        rate, begin_s = self.start, 0.0
        for one in self.spans:
            within = np.clip(time_s - begin_s, 0.0, one.lasts_s)
            s = within / one.lasts_s
            # the integral of s^2 (3 - 2 s) is s^3 - s^4 / 2
            risen = one.lasts_s * (s**3 - 0.5 * s**4 if one.gentle else 0.5 * s**2)
            out += rate * within + (one.rate - rate) * risen
            rate, begin_s = one.rate, begin_s + one.lasts_s
        return out + rate * np.maximum(time_s - begin_s, 0.0)


def held(lasts_s: float, rate: float) -> Span:
    """Return a span over which the rate, reached before, does not change."""
    return Span(lasts_s, rate)


def trapezoid(length: float, speed: float, acceleration: float) -> tuple[Span, ...]:
    """Return the spans of a stage's move: up, even, down; a triangle where the length is too short for the speed.

    The length's sign is the move's.
    """
    size = abs(length)
    top = min(speed, float(np.sqrt(size * acceleration)))
    ramp_s, signed = top / acceleration, float(np.copysign(top, length))
    even_s = size / top - ramp_s
    even = (held(even_s, signed),) if even_s > 0.0 else ()
    return (Span(ramp_s, signed), *even, Span(ramp_s, 0.0))


def joined(*parts: Sequence[Span]) -> Profile:
    """Return the profile of groups of spans, one after another."""
    return Profile(tuple(one for part in parts for one in part))
