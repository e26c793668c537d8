"""The antenna calibration panel: receivers, transmitter, wave, tracer, and the matrix T they make."""

from __future__ import annotations

from PySide6.QtWidgets import QVBoxLayout, QWidget

from radargui.gui.setup.error_line import ErrorLine
from radargui.gui.setup.fields import ChoiceField, NumberField, VectorField
from radargui.gui.setup.form import FormScroll, Group, hint, side_by_side
from radargui.gui.setup.receiver_table import ReceiverTable
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.t_matrix_view import TMatrixView
from radargui.gui.theme import Theme

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
            ChoiceField(model, "radar.phase_sign", _SIGNS),
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
        outer.addWidget(ErrorLine(model, theme))

    def set_running(self, running: bool) -> None:
        """Close or open the form for changes."""
        self._content.setEnabled(not running)
        self._hint.setVisible(running)
