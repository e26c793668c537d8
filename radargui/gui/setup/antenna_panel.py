"""The antenna calibration panel: receivers, transmitter, wave, tracer, and the matrix T they make."""

import math
from functools import partial

import numpy as np
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QLabel, QToolButton, QVBoxLayout, QWidget

from radargui.geometry.antennas import place_antennas
from radargui.geometry.plane_wave import condition_number, t_matrix
from radargui.gui.layout import FaultText, Group, PlainLabel, button, fill
from radargui.gui.setup.fields import FieldGrid, FormPanel, NumberField, SetupForm
from radargui.gui.setup.polarization import PolarizationForm
from radargui.gui.setup.setup_model import MOST_RECEIVERS, SetupModel
from radargui.gui.setup.words import words_of
from radargui.gui.theme import Theme
from radargui.model.assumed import ASSUMED

COLUMNS = ("tilt_deg", "azimuth_deg", "distance_m")
LARGE_CONDITION = 20.0
"""An error of path length then grows twenty times in the position: 0.1 mm become 2 mm, as much as is measured."""
SINGULAR_CONDITION = 1e6
"""Beyond it T is singular but for rounding: entries have an error of about 1e-16, angles are typed to 1e-3 at best."""


class AntennaPanel(FormPanel):
    """Entry of the geometry; closed for changes while samples come in."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__(model, theme)
        self.table, self.matrix = ReceiverTable(model, theme), TMatrixView(model, theme)
        receivers, matrix = Group("Receivers"), Group("Matrix T")
        receivers.whole(self.table)
        matrix.whole(self.matrix)
        wave = SetupForm("Transmitter and wave", model, theme)
        wave.number("transmitter.distance_m")
        wave.vector("transmitter.position_m")
        wave.number("radar.frequency_hz")
        wave.number("radar.refractive_index", optional=True, hint="vacuum")
        wave.choice("radar.phase_sign")
        tracer = SetupForm("Tracer and floor", model, theme)
        tracer.number("tracer.diameter_m")
        tracer.number("tracer.u_diameter_m", optional=True, hint=f"{1e3 * ASSUMED['u_diameter_m']:g} assumed")
        tracer.number("tracer.density_kg_m3", optional=True, hint="no buoyancy")
        tracer.vector("tracer.release_position_m")
        tracer.number("floor.height_m", optional=True, hint="from the impacts")
        site = SetupForm("Site", model, theme)
        site.numbers("site", "latitude_deg", "height_m", "g_m_s2", "u_g_m_s2", optional=True)
        self._place = wave.rows
        self.lay_out(receivers, matrix, wave, PolarizationForm(model, theme), tracer, site)

    def refresh(self) -> None:
        """Show what the draft is now; of the transmitter's distance and position the one that is given."""
        super().refresh()
        by_position = self._model.value("transmitter.position_m") is not None
        # a row each, and what is wrong with each coordinate beneath
        self._place.setRowVisible(0, not by_position)
        self._place.setRowVisible(2, by_position)


class ReceiverTable(FieldGrid):
    """One row a receiver, from 1 to 4 of them."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__(*(words_of(f"receiver.{name}").label for name in COLUMNS))
        self._model = model
        self._rows = []
        for number in range(1, MOST_RECEIVERS + 1):
            remove = QToolButton()
            remove.setText("−")
            remove.setToolTip(f"Remove receiver {number}")
            remove.clicked.connect(partial(model.remove_receiver, number))
            fields = [NumberField(model, theme, f"receiver[{number}].{name}") for name in COLUMNS]
            self._rows.append(self.add_row(f"Rx {number}", fields, remove))
        self.add = button("Add receiver", model.add_receiver)
        self._grid.addWidget(self.add, self._grid.rowCount(), 0, 1, len(COLUMNS) + 2)
        model.changed.connect(self._refresh)
        self._refresh()

    def _refresh(self) -> None:
        count = self._model.n_receivers
        for number, row in enumerate(self._rows, start=1):
            for widget in row:
                widget.setVisible(number <= count)
            row[-1].setEnabled(count > 1)
        self.add.setEnabled(count < MOST_RECEIVERS)


class TMatrixView(QWidget):
    """T row by row, its condition number, and a warning where the antennas cannot tell the three directions apart."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._model = model
        self.matrix = QLabel()
        self.matrix.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.condition = PlainLabel()
        self.warning = FaultText(theme)
        fill(QVBoxLayout(self), self.matrix, self.condition, self.warning, spacing=4)
        model.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        """Compute T of the setup anew; a faulty draft leaves the last one, greyed."""
        valid = self._model.valid
        self.matrix.setEnabled(valid)
        self.condition.setEnabled(valid)
        self.warning.say("")
        if not valid:
            return
        antennas = place_antennas(self._model.setup)
        matrix = t_matrix(antennas)
        self.matrix.setText("\n".join("  ".join(f"{value:+8.4f}" for value in row) for row in matrix))
        if antennas.n_receivers < 3:
            self.condition.setText("No 3D track: it needs three receivers. Path lengths are measured all the same.")
            return
        number = condition_number(antennas)
        singular = not math.isfinite(number) or number > SINGULAR_CONDITION or np.linalg.matrix_rank(matrix) < 3
        self.condition.setText(f"Condition number: {'infinite' if singular else f'{number:.2f}'}")
        self.warning.say(_warning(number, singular=singular))


def _warning(number: float, *, singular: bool) -> str:
    if singular:
        return "T is singular: these antennas cannot tell three directions apart. Spread the azimuths, or tilt them."
    if number > LARGE_CONDITION:
        return f"An error of path length grows up to {number:.0f} times in the position. Spread the antennas further."
    return ""
