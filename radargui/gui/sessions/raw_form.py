"""The layout of a plain binary file, told by the operator who sees at once what becomes of its first seconds."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLineEdit, QSpinBox

from radargui.files.raw_file import LARGEST_BYTES, TYPES, RawLayout, parse_raw_layout
from radargui.files.signals import MOST_CHANNELS
from radargui.gui.layout import Choice, FaultText, Group, PlainLabel
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.errors import UsageError

PREVIEW_S = 3.0
"""Long enough for a step or a swing of a hand, short enough to see single fringes."""
PREVIEW_SAMPLES = 200_000
"""Of each column at most; drawn in a few ms, for the plot shows lowest and highest of each pixel only."""
_LARGEST_FIELD = min(LARGEST_BYTES, 2**31 - 1)
"""The second is the largest number of a QSpinBox, which counts in 32 bits with sign."""
_SIGNS = {"i": "signed", "u": "unsigned", "f": "floating point"}
_LANE = 0.45
"""Half the height of a column in the preview, where the next one lies 1 below."""


class RawForm(Group):
    """Fields for each key of `--raw` but the rate, and the first seconds of each column below one another."""

    changed = Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__("Layout of the binary file")
        kinds = ((name, f"{8 * int(name[1])} bit, {_SIGNS[name[0]]} ({name})") for name in TYPES)
        self.kind = Choice(kinds, "i2")
        self.order = Choice((("le", "lowest byte first (le)"), ("be", "highest byte first (be)")))
        self.columns = QSpinBox(minimum=1, maximum=MOST_CHANNELS, value=2)
        self.header, self.skip = (QSpinBox(maximum=_LARGEST_FIELD) for _ in range(2))
        self.scale = QLineEdit(placeholderText="not known: codes are taken as they are")
        self.offset = QLineEdit("0")
        self.words = PlainLabel()
        self.plot = Plot(theme, "time [s]")
        self.plot.setMinimumSize(280, 200)
        self.faults = {"scale": FaultText(), "offset": FaultText()}
        self.put(("Numbers", self.kind), ("Bytes", self.order), ("Columns", self.columns))
        self.put(("Header [bytes]", self.header), ("Skip [samples]", self.skip))
        self.put(("Scale [V]", self.scale), self.faults["scale"], ("Offset [V]", self.offset), self.faults["offset"])
        self.put(self.plot, self.words)
        for choice in (self.kind, self.order):
            choice.currentIndexChanged.connect(self.changed)
        for count in (self.columns, self.header, self.skip):
            count.valueChanged.connect(self.changed)
        for line in (self.scale, self.offset):
            line.textChanged.connect(self.changed)
        self._ranges: list[str] = []
        self._curves: list[Any] = []

    def stated_layout(self) -> RawLayout | None:
        """Return the layout that the fields tell; None where one cannot be used, which is said at that field."""
        scale, offset = self.scale.text().strip(), self.offset.text().strip()
        counts = {"channels": self.columns, "header": self.header, "skip": self.skip}
        stated = {"dtype": f"{self.kind.currentData()}{self.order.currentData()}", "scale": scale, "offset": offset}
        stated |= {key: str(box.value()) for key, box in counts.items()}
        try:
            layout = parse_raw_layout(",".join(f"{key}={value}" for key, value in stated.items() if value))
        except UsageError as error:
            layout = None
            key, _, said = error.message.removeprefix("--raw: ").partition(" = ")
        for name, fault in self.faults.items():
            fault.say(f"{name.capitalize()}: {said}" if layout is None and name == key else "")
        return layout

    def show_preview(self, columns: FloatArray, rate_hz: float | None) -> None:
        """Show the beginning of each column, shape (columns, n), each as high as the others."""
        self.clear_preview()
        item = self.plot.getPlotItem()
        item.setLabel("bottom", "time [s]" if rate_hz else "sample")
        time = np.arange(columns.shape[1]) / (rate_hz or 1.0)
        for place, values in enumerate(columns):
            finite = values[np.isfinite(values)]
            low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
            self._ranges.append(f"{low:.4g} … {high:.4g}")
            middle, half = 0.5 * (low + high), 0.5 * (high - low) or 1.0
            self._curves.append(self.plot.still_line("faint"))
            self._curves[-1].setData(time, (values - middle) / half * _LANE - place)
        item.setYRange(-columns.shape[0] + 0.5, 0.5, padding=0.0)
        item.setXRange(0.0, float(time[-1]) if time.size else 1.0, padding=0.0)
        self.words.setText("Real channels are smooth; jumps all over mean another layout.")

    def name_columns(self, targets: Mapping[str, str]) -> None:
        """Write beside each column its number, what it is chosen as, and its lowest and highest value; colour those."""
        ticks = []
        for place, (curve, span) in enumerate(zip(self._curves, self._ranges, strict=True)):
            target = targets.get(str(place), "")
            curve.setPen(self.plot.colour(target[0].lower() if target else "faint"))
            ticks.append((-place, " ".join(filter(None, (str(place), target, span)))))
        self.plot.getPlotItem().getAxis("left").setTicks([ticks])

    def clear_preview(self) -> None:
        """Show nothing: the layout does not fit the file."""
        self.plot.take_all_out()
        self._curves.clear()
        self._ranges.clear()
        self.name_columns({})
        self.words.setText("")
