"""What to do next, said in the middle of a panel whose plots are all empty."""

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QObject, QPoint, QRect, QSize, Qt, QTimer
from PySide6.QtWidgets import QLabel, QWidget
from shiboken6 import isValid

from radargui.gui.control.run_control import RunControl
from radargui.gui.plots.plot import Plot
from radargui.model.resources import resource_table

_LOOK_MS = 300
_EDGE = QSize(8, 4)
_ALIKE = 0.75
_DRAWN_ALWAYS = ("line", "faint", "text")
"""Roles of what stands in a plot without data: floor, unit circle, the place of the last point."""


def is_empty(plot: Plot) -> bool:
    """Return whether no curve of a plot has anything to show."""
    images = any(isinstance(item, pg.ImageItem) and item.image is not None for item in plot.getPlotItem().items)
    return not images and not any(
        role not in _DRAWN_ALWAYS and _has_data(item)
        for item, role, *_ in plot._pens  # noqa: SLF001
    )


def _has_data(item: object) -> bool:
    x, y = getattr(item, "getData", lambda: (None, None))()
    return x is not None and y is not None and bool(np.isfinite(y).any())


class EmptyPlots(QObject):
    """Looks at the plots some times a second, and says one sentence in each panel that shows nothing.

    Attributes
    ----------
    labels
        What is said, by the panel's name; stands in the largest of its plots, of equals in the middle one.
    """

    def __init__(self, panels: dict[str, QWidget], control: RunControl, parent: QObject) -> None:
        super().__init__(parent)
        self._control = control
        self._words: dict[str, tuple[str, str]] = resource_table("window/guide")["empty"]
        self._panels = {name: panel for name, panel in panels.items() if name in self._words}
        self.labels: dict[str, QLabel] = {}
        timer = QTimer(self, interval=_LOOK_MS)
        timer.timeout.connect(self.refresh)
        timer.start()

    def refresh(self) -> None:
        """Say what to do, or take it away."""
        for name, panel in self._panels.items():
            if not panel.isVisible():
                continue
            plots = [plot for plot in panel.findChildren(Plot) if plot.isVisible()]
            if plots and all(map(is_empty, plots)):
                own = next(filter(None, (plot.when_empty for plot in plots)), "")
                words = own or self._words[name][self._control.state.running]
                self._say(name, words, _best([one for one in plots if _needed(one, words)] or plots))
            elif (label := self.labels.pop(name, None)) is not None and isValid(label):
                label.deleteLater()

    def _say(self, name: str, words: str, plot: Plot) -> None:
        label = self.labels.get(name)
        if label is None or not isValid(label) or label.parentWidget() is not plot:
            if label is not None and isValid(label):
                label.deleteLater()
            label = self.labels[name] = _label(plot)
        label.setText(words)
        room = _room(plot)
        place = QRect(room.topLeft(), _needed(plot, words) or room.size())
        place.moveCenter(room.center())
        label.setGeometry(place)


def _room(plot: Plot) -> QRect:
    """Return what a plot's axes enclose below the words inside, in its pixels."""
    room = QRect(plot.getPlotItem().vb.sceneBoundingRect().toRect())
    return room.adjusted(0, plot.height_inside, 0, 0)


def _needed(plot: Plot, words: str) -> QSize | None:
    """Return the room that words take within a plot's axes; None where there is not so much."""
    room = _room(plot).size() - _EDGE
    wanted = plot.fontMetrics().boundingRect(QRect(QPoint(), room), Qt.TextFlag.TextWordWrap, words).size()
    return wanted + _EDGE if wanted.width() <= room.width() and wanted.height() <= room.height() else None


def _best(plots: list[Plot]) -> Plot:
    """Return the plot of which most is in sight, of equals the middle one."""
    seen = [plot.visibleRegion().boundingRect().size() for plot in plots]
    areas = [one.width() * one.height() for one in seen]
    equals = [plot for plot, area in zip(plots, areas, strict=True) if area >= _ALIKE * max(areas)]
    return equals[(len(equals) - 1) // 2]


def _label(plot: Plot) -> QLabel:
    made = QLabel(plot)
    made.setWordWrap(True)
    made.setStyleSheet("background: palette(base);")
    made.setAlignment(Qt.AlignmentFlag.AlignCenter)
    made.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    made.show()
    return made
