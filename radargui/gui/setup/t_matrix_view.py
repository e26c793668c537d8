"""The matrix T of the antennas and its condition number, live."""

from __future__ import annotations

import math

import numpy as np
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from radargui.geometry.antennas import place_antennas
from radargui.geometry.plane_wave import condition_number, t_matrix
from radargui.gui.setup.form import plain_label
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme

LARGE_CONDITION = 20.0
SINGULAR_CONDITION = 1e6


class TMatrixView(QWidget):
    """T row by row, its condition number, and a warning where the antennas cannot tell the three directions apart."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._model = model
        self._theme = theme
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        self.matrix = QLabel()
        self.matrix.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.condition = plain_label()
        self.warning = plain_label()
        for widget in (self.matrix, self.condition, self.warning):
            layout.addWidget(widget)
        model.changed.connect(self.refresh)
        theme.changed.connect(self.refresh)
        self.refresh()

    def refresh(self) -> None:
        """Compute T of the setup anew; a faulty draft leaves the last one, greyed."""
        colours = self._theme.colours
        valid = self._model.valid
        self.matrix.setEnabled(valid)
        self.condition.setEnabled(valid)
        self.warning.setStyleSheet(f"color: {colours.alarm}; font-weight: bold;")
        if not valid:
            self.warning.setVisible(False)
            return
        antennas = place_antennas(self._model.setup)
        matrix = t_matrix(antennas)
        self.matrix.setText("\n".join("  ".join(f"{value:+8.4f}" for value in row) for row in matrix))
        if antennas.n_receivers < 3:
            self.condition.setText("No 3D track: it needs three receivers. Path lengths are measured all the same.")
            self.warning.setVisible(False)
            return
        number = condition_number(antennas)
        singular = not math.isfinite(number) or number > SINGULAR_CONDITION or np.linalg.matrix_rank(matrix) < 3
        self.condition.setText(f"Condition number: {'infinite' if singular else f'{number:.2f}'}")
        self.warning.setText(_warning(number, singular=singular))
        self.warning.setVisible(bool(self.warning.text()))


def _warning(number: float, *, singular: bool) -> str:
    if singular:
        return "T is singular: these antennas cannot tell three directions apart. Spread the azimuths, or tilt them."
    if number > LARGE_CONDITION:
        return f"An error of path length grows up to {number:.0f} times in the position. Spread the antennas further."
    return ""
