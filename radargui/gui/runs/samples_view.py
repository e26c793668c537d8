"""All samples of a run at a glance: lowest and highest of each bin, there before anything is processed."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QVBoxLayout, QWidget

from radargui.files.overview import Overview
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray


class SamplesView(QWidget):
    """One plot a receiver, time counted from the first sample."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.plots: list[Plot] = []
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(1)
        self._column.addWidget(Key(theme, ("▬", "i", "I"), ("▬", "q", "Q")))

    def show_overview(self, overview: Overview) -> None:
        """Draw an overview."""
        count = len(overview.channel_names) // 2
        for plot in self.plots:
            self._column.removeWidget(plot)
            plot.hide()
            plot.deleteLater()
        self.plots = [
            Plot(self._theme, "time [s]" if number == count - 1 else "", f"Rx {number + 1} [V]")
            for number in range(count)
        ]
        for number, plot in enumerate(self.plots):
            plot.getPlotItem().getAxis("left").setWidth(58)
            plot.setXLink(self.plots[-1])
            for row, role in ((2 * number, "i"), (2 * number + 1, "q")):
                curve = plot.line(role, connect="finite")
                curve.setClipToView(True)
                curve.setData(*boxes(overview, row))
            self._column.addWidget(plot, 1)


def boxes(overview: Overview, row: int) -> tuple[FloatArray, FloatArray]:
    """Return time [s] and value of a line around each bin of a channel, shape (4 * n_bins,) each.

    A box says where the samples of a bin are and no more; a line from bin to bin would look like a signal.
    """
    low, high = overview.lowest[row], overview.highest[row]
    bin_s = overview.bin_samples / overview.sample_rate_hz
    starts = np.arange(low.size) * bin_s
    time_s = np.stack([starts, starts, starts + bin_s, starts + bin_s], axis=1).ravel()
    return time_s, np.stack([low, high, high, low], axis=1).ravel()
