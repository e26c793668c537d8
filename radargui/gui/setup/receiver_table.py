"""The table of receivers: tilt, azimuth, distance; each cell a field of its own."""

from __future__ import annotations

from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QToolButton, QWidget

from radargui.gui.setup.fields import NumberField
from radargui.gui.setup.setup_model import MOST_RECEIVERS, SetupModel
from radargui.gui.theme import Theme

COLUMNS = (("tilt_deg", "Tilt [°]", 1.0), ("azimuth_deg", "Azimuth [°]", 1.0), ("distance_m", "Distance [mm]", 1000.0))


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
