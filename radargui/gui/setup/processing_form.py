"""How samples become a track, and when the recording of a run starts and ends."""

from __future__ import annotations

from typing import get_args

from radargui.gui.setup.fields import ChoiceField, NumberField
from radargui.gui.setup.form import Group
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme
from radargui.model.processing import Correction, Geometry

CORRECTIONS = {
    "joint": "Joint fit",
    "adaptive": "Adaptive",
    "published": "Published (peaks and valleys)",
    "ellipse": "Static ellipse (Heydemann)",
    "none": "None",
}
GEOMETRIES = {"exact": "Exact (near field)", "plane": "Plane wave (far field)"}


def offered(words: dict[str, str], values: tuple[str, ...]) -> dict[str, str]:
    """Return the words of all values that are allowed."""
    return {value: words.get(value, value) for value in values}


class ProcessingForm(Group):
    """Correction and geometry."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__("Processing")
        self.row(
            "IQ correction",
            ChoiceField(model, theme, "processing.correction", offered(CORRECTIONS, get_args(Correction))),
        )
        self.row("Geometry", ChoiceField(model, theme, "processing.geometry", offered(GEOMETRIES, get_args(Geometry))))


class RecordingForm(Group):
    """Rate and the limits of one recording."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__("Recording")

        def number(key: str) -> NumberField:
            return NumberField(model, theme, key)

        self.row("Rate per channel [Hz]", number("daq.rate_hz"))
        self.row("Before the motion [s]", number("recording.pretrigger_s"), "History kept from before the trigger")
        self.row("Rest that ends it [s]", number("recording.quiet_s"), "The run ends after this long without motion")
        self.row("Longest run [s]", number("recording.maximum_s"))
        self.row("Trigger [× noise]", number("recording.threshold"), "Motion counts from this many times the noise on")
