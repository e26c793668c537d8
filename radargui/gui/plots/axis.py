"""An axis in the units it says, and no others."""

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QFontMetricsF

_APART = 1.2
"""Least distance of numbers above one another, in heights of their letters."""


class Axis(pg.AxisItem):  # type: ignore[misc] # pyqtgraph has no types
    """An `AxisItem` that never scales its numbers by a prefix, and lays its words out only where they change."""

    def __init__(self, orientation: str) -> None:
        self._laid_out = ""
        super().__init__(orientation)
        self.autoSIPrefix = False

    def updateAutoSIPrefix(self) -> None:  # noqa: N802 - pyqtgraph's name
        """Leave the numbers as they are: pyqtgraph would keep a scale that it found once."""

    def _updateLabel(self) -> None:  # noqa: N802 - pyqtgraph's name
        # a new axis does so a dozen times, and that was a fifth of the time a window took
        words = self.labelString()
        if words != self._laid_out:
            self._laid_out = words
            super()._updateLabel()

    def tickSpacing(  # noqa: N802 - pyqtgraph's name
        self,
        minVal: float,
        maxVal: float,
        size: float,
    ) -> list[tuple[float, float]]:
        """Return spacings and offsets; numbers of a low plot stand farther apart, for pyqtgraph lets them overlap."""
        levels: list[tuple[float, float]] = super().tickSpacing(minVal, maxVal, size)
        if self.orientation in ("left", "right") and levels and size > 0.0:
            letters = QFontMetricsF(self.style["tickFont"] or self.font()).height()
            least = abs(maxVal - minVal) * _APART * letters / size
            if levels[0][0] < least:
                decade = 10.0 ** np.floor(np.log10(least))
                levels[0] = (decade * min(one for one in (1.0, 2.0, 5.0, 10.0) if one * decade >= least), 0.0)
        return levels
