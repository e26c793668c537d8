"""The antenna calibration panel: receivers and the matrix T they make, polarisations, transmitter, wave, tracer."""

from datetime import datetime
from functools import partial
from itertools import zip_longest

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QToolButton, QWidget

from radargui.gui.background import Jobs
from radargui.gui.layout import ALARM, Answer, FaultText, Group, PlainLabel, button, having
from radargui.gui.panels import Actions
from radargui.gui.setup.fields import AntennaGrid, FormPanel, ModelGroup, SetupForm
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.uncertainty_map import UncertaintyMapView
from radargui.gui.setup_words import in_words
from radargui.gui.theme import Theme, even_font
from radargui.model.calibrated_setup import calibration_words, edited_since, too_old
from radargui.model.calibration import Calibration
from radargui.model.radar import MAX_RECEIVERS
from radargui.model.rounding import with_sign
from radargui.model.scattering import MIN_SHARE, received_fields
from radargui.model.words import percent
from radargui.physics.path_length import LARGE_CONDITION, MIN_RECEIVERS, condition_number, place_antennas, t_matrix


class PolarizationTable(AntennaGrid):
    """Angle and uncertainty of each antenna's electric field, and how much of the strongest signal a receiver gets."""

    def __init__(self, model: SetupModel) -> None:
        super().__init__(model, ("polarization_deg", "u_polarization_deg"), first=0)

    def beside(self, number: int) -> list[QWidget]:
        """Return the words for what a receiver gets."""
        return [having(QLabel(), toolTip="Share of the signal that the strongest angle would give")]

    def refresh(self) -> None:
        """Show what follows from the draft, also where it is refused for it."""
        super().refresh()
        setup, sent = self._model.setup, self._number("transmitter")
        receivers = [
            one.model_copy(update={"polarization_deg": self._number(f"receiver[{number}]")})
            for number, one in enumerate(setup.receiver, 1)
        ]
        wave = setup.radar, setup.transmitter, receivers, setup.tracer
        found = () if sent is None else received_fields(*wave, sent)
        for (number, (angle, _)), one in zip_longest(self.fields.items(), (None, *found)):
            angle.setPlaceholderText("not given" if one is None else f"strongest, {one.strongest_deg:.1f}")
            gets = self.rows[number][-1]
            having(gets, text="" if one is None else percent(one.share))
            gets.setStyleSheet(ALARM if one is not None and one.share < MIN_SHARE else "")

    def _number(self, antenna: str) -> float | None:
        value = self._model.value(f"{antenna}.polarization_deg")
        return float(value) if isinstance(value, (int, float)) else None


_SEEN_FROM = (
    "Of the transmitter from x towards y; of a receiver from the horizontal towards upwards, seen from behind it. The "
    "strokes in the drawing are these fields; at the end of a row: what the receiver gets of the strongest signal."
)
_BEHIND = (
    "Distances are to the phase centre. Of a horn only its aperture can be reached: the waves come from behind it, by "
    "12 ± 2 cm for 20 dB."
)
COLUMNS = ("tilt_deg", "azimuth_deg", "distance_m")
_SINGULAR = "T is singular: these antennas cannot tell three directions apart. Spread the azimuths, or tilt them."
SINGULAR_CONDITION = 1e6
"""Beyond it T is singular but for rounding: entries have an error of about 1e-16, angles are typed to 1e-3 at best."""


class AntennaPanel(FormPanel):
    """Entry of the geometry; closed for changes while samples come in."""

    def __init__(self, model: SetupModel, does: Actions, jobs: Jobs, theme: Theme) -> None:
        super().__init__(model, does.take_over.trigger)
        self.map = UncertaintyMapView(model, jobs, theme)
        self.only_shows = (self.map,)
        self.table, self.matrix = ReceiverTable(model), TMatrixView(model)
        self.calibration = CalibrationGroup(model, does)
        wave, tracer, site, air = (SetupForm(name, model) for name in ("wave", "tracer", "site", "air"))
        container = SetupForm("container", model)
        self._place = wave.rows
        behind = AntennaGrid(model, ("phase_centre_m", "u_phase_centre_m"), first=0)
        phase_centres = Group("Phase centres", behind, PlainLabel(_BEHIND))
        antennas = Group("Receivers", self.table), wave
        turned = Group("", PolarizationTable(model), PlainLabel(_SEEN_FROM))
        sections = {"Antennas": antennas, "Polarisation": (turned,), "Sphere": (tracer,)}
        advanced = self.matrix, self.map, phase_centres
        # last: what it says gets longer while somebody types above
        every = {**sections, "Room": (container, site, air), "Advanced": advanced}
        self.lay_out(self.calibration, every, last=True)

    def refresh(self) -> None:
        """Show what the draft is now; of the transmitter's distance and position the one that is given."""
        super().refresh()
        by_position = self._model.value("transmitter.position_m") is not None
        self._place.setRowVisible(0, not by_position)
        self._place.setRowVisible(1, by_position)


class ReceiverTable(AntennaGrid):
    """One row a receiver, from 1 to 4 of them."""

    def __init__(self, model: SetupModel) -> None:
        self.add = button("Add receiver", model.add_receiver)
        super().__init__(model, COLUMNS)
        self._grid.addWidget(self.add, self._grid.rowCount(), 0, 1, len(COLUMNS) + 2)

    def beside(self, number: int) -> list[QWidget]:
        """Return the button that removes a receiver."""
        remove = having(QToolButton(), text="−", toolTip=f"Remove receiver {number}")
        remove.clicked.connect(partial(self._model.remove_receiver, number))
        return [remove]

    def refresh(self) -> None:
        """Show the rows of the receivers that are there."""
        super().refresh()
        count = self._model.n_receivers
        for row in self.rows.values():
            row[-1].setEnabled(count > 1)
        self.add.setEnabled(count < MAX_RECEIVERS)


class TMatrixView(ModelGroup):
    """T row by row, its condition number, and a warning where the antennas cannot tell the three directions apart."""

    def __init__(self, model: SetupModel) -> None:
        self.matrix, self.condition, self.warning = QLabel(), PlainLabel(), FaultText()
        self.matrix.setFont(even_font(self.matrix.font()))
        super().__init__("Matrix T", model, self.matrix, self.condition, self.warning)

    def refresh(self) -> None:
        """Compute T of the setup anew; a faulty draft leaves the last one, greyed."""
        for part in (self.matrix, self.condition):
            part.setEnabled(self._model.valid)
        self.warning.say("")
        if not self._model.valid:
            return
        antennas = place_antennas(self._model.setup)
        matrix = t_matrix(antennas)
        self.matrix.setText("\n".join("  ".join(f"{with_sign(value, 4):>8}" for value in row) for row in matrix))
        if antennas.n_receivers < MIN_RECEIVERS:
            self.condition.setText("No 3D track: it needs three receivers. Path lengths are measured all the same.")
            return
        number = condition_number(antennas)
        # not a number counts too
        singular = not number <= SINGULAR_CONDITION
        self.condition.setText(f"Condition number: {'infinite' if singular else f'{number:.2f}'}")
        grows = f"An error of path length grows up to {number:.0f} times in the position. Spread the antennas further."
        if singular or number > LARGE_CONDITION:
            self.warning.say(_SINGULAR if singular else grows)


class CalibrationGroup(ModelGroup):
    """Beside the antennas: which calibration they have, what is wrong with it, and the way to another."""

    taken, found = Signal(), Signal(object)

    def __init__(self, model: SetupModel, does: Actions) -> None:
        self.words, self.checked, self.fault = PlainLabel(), Answer(), FaultText()
        self.begin = button("Calibrate the antennas…", does.calibrate.trigger)
        self.take_over = button("Take over", lambda: self.taken.emit())
        self.take_over.setToolTip(
            "Write what the drops say into the setup, and keep it as a calibration; Undo all changes takes it back"
        )
        super().__init__("Calibration", model, self.words, self.fault, self.checked, self.begin, self.take_over)
        self.show_drops(None)

    def show_drops(self, found: Calibration | None) -> None:
        """Show what the drops of the session say of the antennas; None: nothing."""
        self.take_over.setVisible(found is not None)
        self.found.emit(found)

    def refresh(self) -> None:
        """Show what holds for the setup now."""
        setup = self._model.setup
        words = calibration_words(setup) or "none: angles and distances as measured by hand"
        self.words.setText(f"{words[0].upper()}{words[1:]}")
        edited = edited_since(setup)
        old = too_old(setup, datetime.now().astimezone())
        faults = filter(None, (old, in_words(edited.text) if edited else ""))
        self.fault.say(". ".join(f"{one[0].upper()}{one[1:]}" for one in faults))
