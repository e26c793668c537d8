"""Phase and change of path length of all receivers against time."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QVBoxLayout, QWidget

from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import start_time_s
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult

_TURN = 2.0 * np.pi


class PhaseView(QWidget):
    """Above the phase, corrected and as recorded; below L."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.phase = Plot(theme, "", "phase [turns]")
        self.path = Plot(theme, "time after the trigger [s]", "change of L [mm]")
        self.phase.setXLink(self.path)
        self.phase.getPlotItem().getAxis("bottom").setStyle(showValues=False)
        self._key = Key(theme)
        self._drawn: list[tuple[Plot, object]] = []
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(1)
        column.addWidget(self._key)
        for plot in (self.phase, self.path):
            plot.getPlotItem().getAxis("left").setWidth(58)
            column.addWidget(plot, 1)

    def show_result(self, result: RunResult) -> None:
        """Draw a result."""
        for plot, curve in self._drawn:
            plot.drop(curve)
        self._drawn = []
        paths = result.paths
        if paths is None:
            return
        time_s = paths.time_s - start_time_s(result)
        volts = result.recording.volts()
        for number in range(paths.phase_rad.shape[0]):
            role = f"receivers.{number}"
            corrected = paths.phase_rad[number] / _TURN
            raw = _raw_turns(volts[2 * number], volts[2 * number + 1], corrected, result.setup.radar.phase_sign)
            self._add(self.phase, role, time_s, raw, dashed=True)
            self._add(self.phase, role, time_s, corrected)
            self._add(self.path, role, time_s, 1000.0 * paths.change_m[number])
        receivers = (("▬", f"receivers.{number}", f"Rx {number + 1}") for number in range(paths.phase_rad.shape[0]))
        self._key.show_entries(*receivers, ("╌", "text", "phase as recorded"))
        self.path.enableAutoRange()
        self.phase.enableAutoRange(axis="y")

    def _add(self, plot: Plot, role: str, x: FloatArray, y: FloatArray, *, dashed: bool = False) -> None:
        curve = plot.line(role, dashed=dashed, connect="finite")
        curve.setDownsampling(auto=True, method="peak")
        curve.setClipToView(True)
        curve.setData(x, y)
        self._drawn.append((plot, curve))


def _raw_turns(i: FloatArray, q: FloatArray, corrected: FloatArray, sign: int) -> FloatArray:
    """Return the phase of the uncorrected signal, in turns, zero where the corrected one begins."""
    turns = sign * np.unwrap(np.arctan2(q, i)) / _TURN
    known = np.flatnonzero(np.isfinite(corrected))
    return np.asarray(turns - (turns[known[0]] - corrected[known[0]] if known.size else 0.0))
