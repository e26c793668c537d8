"""Axis ranges that stay put: they grow at once when needed and shrink only after a while, in round steps."""

import math

_STEPS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)
"""Round numbers in a decade, none above 5/3 of the one before: a range is never much larger than what it holds."""

LEAST = 1e-2
"""Half of a range at the least, in the unit that is shown (chosen by hand): around a speed of 0, or a dead input, finer
figures would be noise of the arithmetic, and have no room beside the axis."""


def round_up(value: float) -> float:
    """Return the next round number at or above a positive value."""
    if not math.isfinite(value) or value <= 0.0:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in _STEPS if step * decade >= value * (1.0 - 1e-12))


class SteadyRange:
    """A range low..high around what is shown.

    Parameters
    ----------
    patience
        How many times in a row the shown values must be much smaller before the range shrinks.
    """

    def __init__(self, patience: int = 90) -> None:
        self._patience = patience
        self._small = 0
        self.centre = 0.0
        self.half = 0.0

    def fit(self, low: float, high: float) -> bool:
        """Fit the range to values low..high; return whether it changed."""
        if not (math.isfinite(low) and math.isfinite(high)):
            return False
        fits = self.centre - self.half <= low and high <= self.centre + self.half
        needed = 0.5 * (high - low) * 1.08
        if fits and self.half > 0.0:
            self._small = self._small + 1 if needed < 0.35 * self.half else 0
            if self._small < self._patience:
                return False
        self._small = 0
        half = round_up(max(needed, LEAST, 1e-4 * abs(high + low)))
        grid = half / 5.0
        centre = round(0.5 * (low + high) / grid) * grid
        changed = (centre, half) != (self.centre, self.half)
        self.centre, self.half = centre, half
        return changed

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest shown value."""
        return self.centre - self.half, self.centre + self.half
