"""The map of the position uncertainty to expect over the field of view, computed beside the drawing thread."""

from functools import cached_property, partial

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSignalBlocker
from PySide6.QtGui import QHideEvent, QShowEvent
from PySide6.QtWidgets import QDoubleSpinBox, QHBoxLayout, QWidget

from radargui.gui.background import Jobs
from radargui.gui.layout import TIPS, Group, PlainLabel, boxed, having, ticking
from radargui.gui.plots.key import ColourBar
from radargui.gui.plots.plot import Plot
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme
from radargui.model.setup import Setup
from radargui.physics.path_length import HALF_FIELD_M
from radargui.processing.expected_uncertainty import POINTS, UncertaintyMap, map_of

_CALM_MS = 150
"""After the last key: longer than from key to key, shorter than a look from the field to the map."""
_FIELD_MM = QRectF(*(2 * [-1e3 * HALF_FIELD_M]), *(2 * [2e3 * HALF_FIELD_M]))
"""Left, lower edge, width and height of the field of view."""
_COLOURS = "cividis"
"""Made for colour-blind eyes: lightness alone tells the order."""
_LEFT = 48
"""Width of the left axes in pixels (chosen by hand): in less the figures are cut, more is taken from the curves."""
_PLANES = (("z [mm]", "y = 0"), ("y [mm]", "z = 0"))


class UncertaintyMapView(Group):
    """The map as the setup is now; nothing is computed while nobody looks at it.

    Attributes
    ----------
    shown
        The map that is drawn; None: none can be, or none yet.
    """

    def __init__(self, model: SetupModel, jobs: Jobs, theme: Theme) -> None:
        super().__init__("Position uncertainty to expect")
        self._model, self._jobs = model, jobs
        self.shown: UncertaintyMap | None = None
        self._of: tuple[Setup, float] | None = None
        self.snr = QDoubleSpinBox(minimum=0.0, maximum=120.0, decimals=0, suffix=" dB")
        having(self.snr, objectName="map.snr", value=model.setup.simulation.snr_db)
        self._own_snr = False
        self._theme, self._images = theme, list[pg.ImageItem]()
        self.scale = ColourBar(TIPS["plots"]["Colours of the uncertainty"])
        self.words, self.here, self._row = PlainLabel(), PlainLabel(), QHBoxLayout()
        self.put(("SNR", self.snr), boxed(self._row), self.scale, self.words, self.here)
        self._soon = ticking(self, _CALM_MS, self._begin, once=True)
        model.changed.connect(self._changed)
        self.snr.valueChanged.connect(self._snr_changed)

    @cached_property
    def plots(self) -> list[Plot]:
        """One a plane; made when they are first looked at: plots are what a new window waits for."""
        made = []
        for number, (left, plane) in enumerate(_PLANES):
            plot = Plot(self._theme, "x [mm]", left, left_px=_LEFT, equal=True)
            plot.write_inside(plane)
            having(plot, fixedHeight=176, toolTip=TIPS["plots"]["Uncertainty"])
            image = pg.ImageItem(colorMap=pg.colormap.get(_COLOURS))
            image.setZValue(-10)
            plot.addItem(image)
            plot.scene().sigMouseMoved.connect(partial(self._read, plot, number))
            self._row.addWidget(plot, 1)
            made.append(plot)
            self._images.append(image)
        return made

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Compute what changed while nobody looked."""
        super().showEvent(event)
        self.plots  # noqa: B018 - makes them
        self._changed()

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802 - Qt's name
        """Leave for later what was about to be computed."""
        super().hideEvent(event)
        self._soon.stop()

    def _snr_changed(self) -> None:
        self._own_snr = True
        self._changed()

    def _changed(self) -> None:
        if not self._own_snr:
            with QSignalBlocker(self.snr):
                self.snr.setValue(self._model.setup.simulation.snr_db)
        if self.isVisible() and self._model.valid and self._of != (self._model.setup, self.snr.value()):
            self._soon.start()

    def _begin(self) -> None:
        self._of = asked = (self._model.setup, self.snr.value())
        self._jobs.start(
            "the map of the uncertainty",
            partial(map_of, *asked),
            self.show_map,
            lambda error: self._say(f"No map: {error}"),
            lambda: self._of is asked,
        )

    def show_map(self, found: UncertaintyMap | None) -> None:
        """Draw a map; None: no place can be determined."""
        self.shown = found
        known = np.empty(0) if found is None else found.planes_mm[np.isfinite(found.planes_mm)]
        parts: tuple[QWidget, ...] = (*self.plots, self.scale)
        for part in parts:
            part.setVisible(bool(known.size))
        if found is None or not known.size:
            self._say("No position can be told: it needs three receivers that are not in one line of sight.")
            return
        low, high = float(known.min()), float(known.max())
        for plot, image, plane in zip(self.plots, self._images, found.planes_mm, strict=True):
            # row by column: the first axis is x, to the right
            image.setImage(plane.T, levels=(low, max(high, 1.000001 * low)), axisOrder="row-major")
            image.setRect(_FIELD_MM)
            plot.setRange(_FIELD_MM, padding=0.02)
        table = pg.colormap.get(_COLOURS).map(np.linspace(0.0, 1.0, 16), mode="float")
        self.scale.show_ends(table, f"{low:.2f} mm", f"{high:.2f} mm")
        self._say(f"±{found.release_mm:.2f} mm a coordinate at the release, most of it from {found.largest_share}.")

    def _say(self, words: str) -> None:
        self.words.setText(words)
        self.here.setText("Point at the map to read it." if self.shown is not None else "")

    def _read(self, plot: Plot, number: int, where: QPointF) -> None:
        """Say what the map has under the pointer."""
        if self.shown is None:
            return
        at = plot.getPlotItem().vb.mapSceneToView(where)
        step = 2e3 * HALF_FIELD_M / (POINTS - 1)
        column, row = (round((value + 1e3 * HALF_FIELD_M) / step) for value in (at.x(), at.y()))
        if 0 <= column < POINTS and 0 <= row < POINTS:
            up = "zy"[number]
            u_mm = self.shown.planes_mm[number, column, row]
            self.here.setText(f"x {round(at.x())} mm, {up} {round(at.y())} mm: ±{u_mm:.2f} mm a coordinate")
