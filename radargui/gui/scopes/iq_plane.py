"""The IQ plane of one receiver: the last second as the converter gave it, or corrected onto the unit circle."""

from __future__ import annotations

import numpy as np

from radargui.gui.plots.plot import Plot
from radargui.gui.plots.ranges import SteadyRange
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray


class IQPlane(Plot):
    """Q upwards against I, equal units on both axes."""

    def __init__(self, theme: Theme, number: int, *, corrected: bool) -> None:
        super().__init__(theme, equal=True, live=True)
        # axis words or a title would take half of so small a plot
        self.write_inside(f"Rx {number} corr. [ampl.]" if corrected else f"Rx {number} raw [V]")
        self._corrected = corrected
        self._range = SteadyRange()
        if corrected:
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            self.fast_line("faint", dashed=True).setData(np.cos(turn), np.sin(turn))
        self._curve = self.fast_line(f"receivers.{number - 1}")
        self._now = self.marker("text", size=7)
        self.setToolTip("Corrected onto the unit circle (dashed)" if corrected else "As the converter gave it")
        self._show(1.3)

    @property
    def points(self) -> int:
        """How many points are drawn."""
        data = self._curve.getData()[0]
        return 0 if data is None else len(data)

    def draw(self, i: FloatArray, q: FloatArray) -> None:
        """Draw points in time order, shape (n,) each; NaN is left out."""
        self._curve.setData(i, q)
        known = np.isfinite(i) & np.isfinite(q)
        last = np.flatnonzero(known)[-1:]
        self._now.setData(i[last], q[last])
        if self._corrected or not last.size:
            return
        reach = float(np.hypot(i[known], q[known]).max())
        if self._range.fit(-reach, reach):
            self._show(self._range.half)

    def _show(self, half: float) -> None:
        """Show a square of that half width, with room for the words above."""
        self.setRange(xRange=(-half, half), yRange=(-half, 1.3 * half), padding=0)

    def clear_data(self) -> None:
        """Show nothing."""
        self._curve.setData([], [])
        self._now.setData([], [])
