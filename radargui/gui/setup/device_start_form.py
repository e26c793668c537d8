"""Settings of the NI device that say when a run starts, and what happens after an error."""

from __future__ import annotations

from PySide6.QtWidgets import QCheckBox

from radargui.gui.setup.fields import Changed, ChoiceField, NumberField, TextField
from radargui.gui.setup.form import Group
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme

STARTS = {"now": "At once", "digital": "Digital edge", "analog": "Analogue edge"}
EDGES = {"rising": "Rising", "falling": "Falling"}


class CheckField(QCheckBox):
    """Yes or no."""

    def __init__(self, model: SetupModel, theme: Theme, key: str, words: str, tip: str) -> None:
        super().__init__(words)
        self._model = model
        self.key = key
        self.setObjectName(key)
        self.setToolTip(tip)
        self.clicked.connect(lambda checked: model.assign(key, checked))
        model.changed.connect(self.refresh)
        self.refresh()
        self.changed = Changed(self, model, theme, key, lambda value: "yes" if value else "no")

    def refresh(self) -> None:
        """Show what the draft says."""
        self.setChecked(self._model.value(self.key) is True)


class DeviceStartForm:
    """Rows for the group of the device; what does not belong to the chosen start is hidden."""

    def __init__(self, group: Group, model: SetupModel, theme: Theme) -> None:
        self._group = group
        self._model = model
        start = ChoiceField(model, theme, "daq.start", STARTS)
        group.row("Sampling starts", start, "At once: a run begins with the motion. At an edge: the edge is t = 0")
        self._source = TextField(model, theme, "daq.start_source", optional=True, hint="PFI0, or I1 where analogue")
        group.row("Edge of", self._source, "Digital: a terminal, PFI0. Analogue: APFI0, or a channel, I1 or ai0")
        self._edge = ChoiceField(model, theme, "daq.start_edge", EDGES)
        group.row("Edge", self._edge)
        self._level = NumberField(model, theme, "daq.start_level_v")
        group.row("Level [V]", self._level)
        self._pretrigger = CheckField(
            model,
            theme,
            "daq.start_pretrigger",
            "Samples from before the edge",
            "A reference trigger: the device keeps what came before the edge. Not every device can",
        )
        group.whole(self._pretrigger)
        group.whole(
            CheckField(
                model,
                theme,
                "recording.restart_after_error",
                "Start again after an error",
                "A device that failed is started again within the run; what was lost meanwhile is a gap",
            )
        )
        self._within = NumberField(model, theme, "recording.restart_within_s")
        group.row("Tried for [s]", self._within)
        start.activated.connect(lambda _index: self._settle(start.currentData()))
        model.changed.connect(self._refresh)
        self._refresh()

    def _settle(self, start: str) -> None:
        """Let what goes with a start that was just chosen be there, and nothing that cannot go with it."""
        model = self._model
        if start == "now":
            model.assign("daq.start_pretrigger", None)
        elif model.value("daq.start_source") is None:
            model.assign("daq.start_source", "PFI0" if start == "digital" else "I1")

    def _refresh(self) -> None:
        start = self._model.value("daq.start")
        rows = self._group.rows
        for field in (self._source, self._edge, self._pretrigger):
            rows.setRowVisible(field, start != "now")
        rows.setRowVisible(self._level, start == "analog")
        rows.setRowVisible(self._within, self._model.value("recording.restart_after_error") is True)
