"""The table of receivers: tilt, azimuth, distance; each cell a field of its own."""

from __future__ import annotations

from PySide6.QtWidgets import QGridLayout, QLabel, QPushButton, QToolButton, QVBoxLayout, QWidget

from radargui.gui.setup.fields import NumberField
from radargui.gui.setup.setup_model import MOST_RECEIVERS, SetupModel
from radargui.gui.theme import Theme

COLUMNS = (("tilt_deg", "Tilt [°]", 1.0), ("azimuth_deg", "Azimuth [°]", 1.0), ("distance_m", "Distance [mm]", 1000.0))


class ReceiverTable(QWidget):
    """One row a receiver, from 1 to 4 of them."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._model = model
        self._theme = theme
        self._shown = 0
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._grid_box = QWidget()
        self._column.addWidget(self._grid_box)
        self.add = QPushButton("Add receiver")
        self.add.clicked.connect(model.add_receiver)
        self._column.addWidget(self.add)
        model.changed.connect(self._refresh)
        self._refresh()

    def _refresh(self) -> None:
        count = self._model.n_receivers
        if count == self._shown:
            return
        self._shown = count
        self._grid_box.hide()
        self._column.removeWidget(self._grid_box)
        self._grid_box.deleteLater()
        self._grid_box = QWidget()
        self._column.insertWidget(0, self._grid_box)
        grid = QGridLayout(self._grid_box)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        for column, (_, words, _) in enumerate(COLUMNS, start=1):
            grid.addWidget(QLabel(words), 0, column)
        for number in range(1, count + 1):
            grid.addWidget(QLabel(f"Rx {number}"), number, 0)
            for column, (name, words, scale) in enumerate(COLUMNS, start=1):
                field = NumberField(self._model, self._theme, f"receiver[{number}].{name}", scale=scale)
                field.setAccessibleName(f"Receiver {number} {words}")
                grid.addWidget(field, number, column)
            remove = QToolButton()
            remove.setText("−")
            remove.setToolTip(f"Remove receiver {number}")
            remove.setEnabled(count > 1)
            remove.clicked.connect(lambda _checked=False, number=number: self._model.remove_receiver(number))
            grid.addWidget(remove, number, 4)
        self.add.setEnabled(count < MOST_RECEIVERS)
