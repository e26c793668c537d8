"""An axis in the units it says, and no others."""

import pyqtgraph as pg


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
