"""The antenna calibration panel: receivers, transmitter, wave, tracer, and the matrix T they make."""

from __future__ import annotations

from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QToolButton, QVBoxLayout, QWidget

from radargui.gui.setup.error_line import ChangeLine, ErrorLine
from radargui.gui.setup.fields import ChoiceField, NumberField, VectorField
from radargui.gui.setup.form import FormScroll, Group, hint, side_by_side
from radargui.gui.setup.setup_model import MOST_RECEIVERS, SetupModel
from radargui.gui.setup.t_matrix_view import TMatrixView
from radargui.gui.theme import Theme

COLUMNS = (("tilt_deg", "Tilt [°]", 1.0), ("azimuth_deg", "Azimuth [°]", 1.0), ("distance_m", "Distance [mm]", 1000.0))
_SIGNS = {1: "+1 (I = A cos, Q = A sin)", -1: "−1 (Q inverted)"}


class AntennaPanel(QWidget):
    """Entry of the geometry; closed for changes while samples come in."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._content = QWidget()
        column = QVBoxLayout(self._content)
        column.setContentsMargins(6, 6, 6, 6)

        receivers = Group("Receivers")
        self.table = ReceiverTable(model, theme)
        receivers.whole(self.table)
        column.addWidget(receivers)

        matrix = Group("Matrix T")
        self.matrix = TMatrixView(model, theme)
        matrix.whole(self.matrix)
        column.addWidget(matrix)

        wave = Group("Transmitter and wave")
        wave.row(
            "Distance [mm]",
            NumberField(model, theme, "transmitter.distance_m", scale=1000.0),
            "From the centre of the field of view, on the z axis",
        )
        wave.row("Frequency [GHz]", NumberField(model, theme, "radar.frequency_hz", scale=1e-9))
        wave.row(
            "Phase sign",
            ChoiceField(model, theme, "radar.phase_sign", _SIGNS),
            "Moving the tracer away must raise every path length",
        )
        column.addWidget(wave)

        tracer = Group("Tracer and floor")
        tracer.row("Diameter [mm]", NumberField(model, theme, "tracer.diameter_m", scale=1000.0))
        release = [VectorField(model, theme, "tracer.release_position_m", axis) for axis in range(3)]
        tracer.row(
            "Release x, y, z [mm]",
            side_by_side(*release),
            "Centre of the sphere where it hangs before the fall",
        )
        tracer.row(
            "Floor z [mm]",
            NumberField(model, theme, "floor.height_m", scale=1000.0, optional=True, hint="from the impacts"),
            "Centre of the sphere where it touches; empty: found from the impacts",
        )
        column.addWidget(tracer)
        column.addStretch(1)

        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(FormScroll(self._content), 1)
        self._hint = hint("Stop to change the antennas.")
        outer.addWidget(self._hint)
        outer.addWidget(ChangeLine(model))
        outer.addWidget(ErrorLine(model, theme))

    def set_running(self, running: bool) -> None:
        """Close or open the form for changes."""
        self._content.setEnabled(not running)
        self._hint.setVisible(running)


class ReceiverTable(QWidget):
    """One row a receiver, from 1 to 4 of them."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._model = model
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        for column, (_, words, _) in enumerate(COLUMNS, start=1):
            grid.addWidget(QLabel(words), 0, column)
        self._rows = [self._row(grid, theme, number) for number in range(1, MOST_RECEIVERS + 1)]
        self.add = QPushButton("Add receiver")
        self.add.clicked.connect(model.add_receiver)
        grid.addWidget(self.add, MOST_RECEIVERS + 1, 0, 1, len(COLUMNS) + 2)
        model.changed.connect(self._refresh)
        self._refresh()

    def _row(self, grid: QGridLayout, theme: Theme, number: int) -> list[QWidget]:
        row: list[QWidget] = [QLabel(f"Rx {number}")]
        for name, words, scale in COLUMNS:
            field = NumberField(self._model, theme, f"receiver[{number}].{name}", scale=scale)
            field.setAccessibleName(f"Receiver {number} {words}")
            row.append(field)
        remove = QToolButton()
        remove.setText("−")
        remove.setToolTip(f"Remove receiver {number}")
        remove.clicked.connect(lambda: self._model.remove_receiver(number))
        row.append(remove)
        for column, widget in enumerate(row):
            grid.addWidget(widget, number, column)
        return row

    def _refresh(self) -> None:
        count = self._model.n_receivers
        for number, row in enumerate(self._rows, start=1):
            for widget in row:
                widget.setVisible(number <= count)
            row[-1].setEnabled(count > 1)
        self.add.setEnabled(count < MOST_RECEIVERS)
