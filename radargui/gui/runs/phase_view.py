"""Phase and change of path length of all receivers against time, broken where a path was lost."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QVBoxLayout, QWidget

from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult

_TURN = 2.0 * np.pi


class PhaseView(QWidget):
    """Above the phase, corrected and as recorded; below L."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.phase = Plot(theme, "", "phase [turns]")
        self.path = Plot(theme, "time [s]", "change of L [mm]")
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

    def clear(self) -> None:
        """Forget the result."""
        for plot, curve in self._drawn:
            plot.drop(curve)
        self._drawn = []

    def show_result(self, result: RunResult) -> None:
        """Draw a result."""
        self.clear()
        paths = result.paths
        if paths is None:
            return
        zero_s, zero = result.zero
        self.path.relabel(f"time after {zero} [s]")
        time_s = paths.time_s - zero_s
        volts = result.recording.volts()
        restarts = paths.restarts()
        pieces_s = np.insert(time_s, restarts, time_s[restarts])
        lost = [("│", "gap", "path lost, L has another zero from here on")] if restarts.size else []
        for plot in (self.phase, self.path):
            for restart in restarts:
                self._drawn.append((plot, plot.rule("gap", float(time_s[restart]), dashed=False)))
        for number in range(paths.phase_rad.shape[0]):
            role = f"receivers.{number}"
            corrected = paths.phase_rad[number] / _TURN
            raw = _raw_turns(volts[2 * number], volts[2 * number + 1], corrected, result.setup.radar.phase_sign)
            self._add(self.phase, role, time_s, raw, dashed=True)
            self._add(self.phase, role, pieces_s, np.insert(corrected, restarts, np.nan))
            self._add(self.path, role, pieces_s, np.insert(1000.0 * paths.change_m[number], restarts, np.nan))
        receivers = (("▬", f"receivers.{number}", f"Rx {number + 1}") for number in range(paths.phase_rad.shape[0]))
        self._key.show_entries(*receivers, ("╌", "text", "phase as recorded"), *lost)
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
