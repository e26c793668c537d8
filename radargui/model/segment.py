"""The segment of a recording in which the tracer moves, and the rest before it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Segment:
    """Sample ranges of the motion and of the rest before it.

    Attributes
    ----------
    first, last
        Samples first:last hold the motion (last excluded).
    rest_first, rest_last
        Samples rest_first:rest_last lie at rest before the motion; equal where there is no rest.
    """

    first: int
    last: int
    rest_first: int
    rest_last: int

    @property
    def has_rest(self) -> bool:
        """Whether there is rest before the motion."""
        return self.rest_last > self.rest_first

    def counted_from(self, start: int) -> Segment:
        """Return the same segment counted from sample `start` on."""
        return Segment(self.first - start, self.last - start, self.rest_first - start, self.rest_last - start)
