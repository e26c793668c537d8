"""The antenna calibration panel: receivers and the matrix T they make, polarisations, transmitter, wave, tracer."""

import math
from dataclasses import dataclass
from datetime import datetime
from functools import partial

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QSizePolicy, QToolButton, QWidget

from radargui.geometry.path_length import LARGE_CONDITION, LEAST_RECEIVERS, condition_number, place_antennas, t_matrix
from radargui.gui.background import Jobs
from radargui.gui.layout import Answer, FaultText, Group, PlainLabel, button, having
from radargui.gui.panels import Actions
from radargui.gui.setup.fields import AntennaGrid, FormPanel, ModelGroup, SetupForm
from radargui.gui.setup.geometry_sketch import GeometrySketch
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.uncertainty_map import UncertaintyMapView
from radargui.gui.setup.words import in_words
from radargui.gui.theme import Theme, draw_line, even_font, write
from radargui.model.assumed import ASSUMED
from radargui.model.calibrated_setup import calibration_words, edited_since, too_old, unit_of
from radargui.model.calibration import Calibration
from radargui.model.radar import MOST_RECEIVERS
from radargui.model.rounding import UNKNOWN, plain, quantity, with_sign
from radargui.model.scattering import LEAST_SHARE, received_fields
from radargui.model.words import percent

_ASSUMED_DEG = ASSUMED["u_polarization_deg"]
_HEIGHT, _MARGIN = 108, 4
"""Pixels (chosen by hand): beneath a dial of at most 64 two lines of 14 have room; the second is free about it."""


class PolarizationForm(ModelGroup):
    """Angle and uncertainty of each antenna's electric field, and the drawing."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        table = AntennaGrid(model, ("polarization_deg", "u_polarization_deg"), first=0)
        self._angles = [fields[0] for fields in table.fields.values()]
        self.sketch = PolarizationSketch(model, theme)
        said = (
            "Each antenna from behind, looking at the centre. Arrow: electric field; wedge: uncertainty; dashed: "
            "strongest signal, of which the receiver gets so much."
        )
        super().__init__("Polarisation", model, table, self.sketch, PlainLabel(said))

    def refresh(self) -> None:
        """Show the angles that hold where none is given."""
        drawn = self.sketch.antennas
        for place, angle in enumerate(self._angles):
            strongest_deg = drawn[place].strongest_deg if place < len(drawn) else None
            angle.setPlaceholderText("not given" if strongest_deg is None else f"strongest, {strongest_deg:.1f}")


@dataclass(frozen=True, slots=True)
class DrawnAntenna:
    """One dial of the drawing.

    Attributes
    ----------
    name, axes
        Beneath it; what points right and what up.
    u_deg, angle_deg
        Of the field; None: not given.
    strongest_deg, share
        Of a receiver: the angle of the strongest signal, and what it gets of it; None where that is not known.
    """

    name: str
    axes: tuple[str, str]
    u_deg: float
    angle_deg: float | None
    strongest_deg: float | None = None
    share: float | None = None

    @property
    def words(self) -> str:
        """What is drawn, in words."""
        if self.angle_deg is None:
            return f"{self.name}: not given"
        got = f", {percent(self.share)} of the strongest signal" if self.share is not None else ""
        return f"{self.name}: {self.angle_deg:.1f}° ± {self.u_deg:g}° from {self.axes[0]} towards {self.axes[1]}{got}"


class PolarizationSketch(QWidget):
    """A dial for each antenna; follows typing, also where the setup is refused for it."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._model, self._theme = model, theme
        self.antennas: list[DrawnAntenna] = []
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setAccessibleName("Drawing of the polarisations")
        model.changed.connect(self.refresh)
        self.refresh()

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return room for a dial each."""
        return QSize(60 * (1 + self._model.n_receivers), _HEIGHT)

    def refresh(self) -> None:
        """Take over what the draft says."""
        setup, sent = self._model.setup, self._number("transmitter.polarization_deg")
        receivers = [
            one.model_copy(update={"polarization_deg": self._number(f"receiver[{number}].polarization_deg")})
            for number, one in enumerate(setup.receiver, 1)
        ]
        found: list[tuple[float | None, ...]] = [(None,)] * len(receivers)
        if sent is not None:
            fields = received_fields(setup.radar, setup.transmitter, receivers, setup.tracer, sent)
            found = [(one.angle_deg, one.strongest_deg, one.share) for one in fields]
        self.antennas = [
            DrawnAntenna("Tx", ("x", "y"), self._u("transmitter"), sent),
            *(DrawnAntenna(f"Rx {n}", ("h", "v"), self._u(f"receiver[{n}]"), *own) for n, own in enumerate(found, 1)),
        ]
        words = "\n".join(one.words for one in self.antennas)
        self.setAccessibleDescription(words)
        self.setToolTip(f"{words}\nh is horizontal, v points up as far as the antenna's tilt lets it")
        self.update()

    def _number(self, key: str) -> float | None:
        value = self._model.value(key)
        return float(value) if isinstance(value, (int, float)) else None

    def _u(self, antenna: str) -> float:
        u_deg = self._number(f"{antenna}.u_polarization_deg")
        return _ASSUMED_DEG if u_deg is None else min(max(u_deg, 0.0), 90.0)

    @property
    def middle_y(self) -> float:
        """How far below the top the middles of the dials are, in pixels."""
        return self._radius + 3 * _MARGIN

    @property
    def _radius(self) -> float:
        below = 2 * self.fontMetrics().height()
        return min(0.5 * self.width() / len(self.antennas) - 12.0, 0.5 * (self.height() - below) - 2 * _MARGIN)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the dials side by side."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        width, line, radius = self.width() / len(self.antennas), self.fontMetrics().height(), self._radius
        own = self._theme.colours
        colours = (own.text, *own.receivers)
        for place, antenna in enumerate(self.antennas):
            middle = QPointF((place + 0.5) * width, self.middle_y)
            self._dial(painter, antenna, middle, radius, QColor(colours[place]))
            below = QRectF(place * width, self.height() - 2 * line, width, line)
            write(painter, below, antenna.name, own.text)
            said, colour = "" if antenna.angle_deg is None else f"{antenna.angle_deg:.0f}°", own.text
            if antenna.share is not None:
                said, colour = percent(antenna.share), own.alarm if antenna.share < LEAST_SHARE else own.faint
            write(painter, below.translated(0.0, line), said, colour)

    def _dial(self, painter: QPainter, antenna: DrawnAntenna, middle: QPointF, radius: float, colour: QColor) -> None:
        faint, line = QColor(self._theme.colours.faint), QPen(QColor(self._theme.colours.line), 1.0)
        box = QRectF(middle.x() - radius, middle.y() - radius, 2.0 * radius, 2.0 * radius)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(line)
        painter.drawEllipse(box)
        for name, angle_deg in zip(antenna.axes, (0.0, 90.0), strict=True):
            draw_line(painter, _at(middle, radius, angle_deg + 180.0), _at(middle, radius, angle_deg), line)
            place = _at(middle, radius + 7.0, angle_deg)
            write(painter, QRectF(place.x() - 8.0, place.y() - 8.0, 16.0, 16.0), name, self._theme.colours.faint)
        if antenna.strongest_deg is not None:
            start, end = (_at(middle, radius, antenna.strongest_deg + half) for half in (0.0, 180.0))
            draw_line(painter, start, end, QPen(faint, 1.0, Qt.PenStyle.DashLine))
        if antenna.angle_deg is None:
            return
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(having(QColor(colour), alpha=120))
        for end_deg in (antenna.angle_deg, antenna.angle_deg + 180.0):
            # sixteenths of a degree, counted as the angle is
            painter.drawPie(box, round(16.0 * (end_deg - antenna.u_deg)), round(32.0 * antenna.u_deg))
        painter.setPen(QPen(colour, 2.0))
        for end_deg in (antenna.angle_deg, antenna.angle_deg + 180.0):
            tip = _at(middle, radius, end_deg)
            painter.drawLine(middle, tip)
            for side in (150.0, -150.0):
                painter.drawLine(tip, _at(tip, 0.25 * radius, end_deg + side))


def _at(middle: QPointF, radius: float, angle_deg: float) -> QPointF:
    """Return the point so far from the middle, the angle counted from the right upwards."""
    angle = math.radians(angle_deg)
    return QPointF(middle.x() + radius * math.cos(angle), middle.y() - radius * math.sin(angle))


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
        self.sketch, self.map = GeometrySketch(model, theme), UncertaintyMapView(model, jobs, theme)
        self.only_shows = (self.map,)
        self.table, self.matrix, self.calibration = ReceiverTable(model), TMatrixView(model), CalibrationGroup(model)
        wave, tracer, site, air = (SetupForm(name, model) for name in ("wave", "tracer", "site", "air"))
        container = SetupForm("container", model)
        self._place = wave.rows
        upper = (Group("Receivers", self.table), self.calibration, self.matrix, self.map, wave)
        # above what scrolls: it follows the typing wherever that is
        behind = AntennaGrid(model, ("phase_centre_m", "u_phase_centre_m"), first=0)
        phase_centres = Group("Phase centres", behind, PlainLabel(_BEHIND))
        lower = (PolarizationForm(model, theme), phase_centres, tracer, container, site, air)
        self.lay_out(*upper, *lower, above=self.sketch)

    def refresh(self) -> None:
        """Show what the draft is now; of the transmitter's distance and position the one that is given."""
        super().refresh()
        by_position = self._model.value("transmitter.position_m") is not None
        # a row each, and what is wrong with each coordinate beneath
        self._place.setRowVisible(0, not by_position)
        self._place.setRowVisible(2, by_position)


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
        self.add.setEnabled(count < MOST_RECEIVERS)


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
        if antennas.n_receivers < LEAST_RECEIVERS:
            self.condition.setText("No 3D track: it needs three receivers. Path lengths are measured all the same.")
            return
        number = condition_number(antennas)
        # not a number counts too
        singular = not number <= SINGULAR_CONDITION
        self.condition.setText(f"Condition number: {'infinite' if singular else f'{number:.2f}'}")
        grows = f"An error of path length grows up to {number:.0f} times in the position. Spread the antennas further."
        if singular or number > LARGE_CONDITION:
            self.warning.say(_SINGULAR if singular else grows)


class DropsView(QLabel):
    """A line for each value of the antennas: as it is stated, as the drops say it, and how far apart that is."""

    def __init__(self) -> None:
        super().__init__(textFormat=Qt.TextFormat.PlainText)
        self.setFont(even_font(self.font()))
        self.setAccessibleName("What the drops say")
        self.setToolTip(
            "Stated in the setup, found by the drops of the session with its standard uncertainty, and the pull: "
            "normal with deviation one where the setup is right"
        )

    def show_calibration(self, found: Calibration | None) -> None:
        """Show the values of a calibration."""
        self.setText("" if found is None else "\n".join(_lines(found)))


def _lines(found: Calibration) -> list[str]:
    rows = [("The drops say", "stated", "found", "pull")]
    u_found = np.sqrt(np.diag(found.covariance))
    for name, *value in zip(found.names, found.before, found.values, found.u_before, u_found, strict=True):
        stated, at, u_stated, u = map(float, value)
        unit, scale = unit_of(name)
        learnt = u_stated**2 - u**2
        # what is known no better has told nothing
        pull = with_sign((at - stated) / math.sqrt(learnt), 1) if learnt > 0.02 * u_stated**2 else UNKNOWN
        words = name.replace("receiver.", "Rx ").replace("transmitter.", "Tx ").replace("position_m.", "")
        label = words.removesuffix("_deg").removesuffix("_m").replace(".", " ")
        rows.append((label, f"{plain(stated * scale, 6)} {unit}", quantity(at, u, unit, scale), pull))
    widths = [max(len(row[column]) for row in rows) for column in range(4)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]


class CalibrationGroup(ModelGroup):
    """Beside the antennas: which calibration they have, what is wrong with it, and the way to another."""

    asked, taken = Signal(), Signal()

    def __init__(self, model: SetupModel) -> None:
        self.words, self.checked, self.fault = PlainLabel(), Answer(), FaultText()
        self.begin = button("Calibrate the antennas…", lambda: self.asked.emit())
        self.drops = DropsView()
        self.take_over = button("Take over", lambda: self.taken.emit())
        self.take_over.setToolTip(
            "Write what the drops say into the setup, and keep it as a calibration; Undo all changes takes it back"
        )
        super().__init__("Calibration", model, self.words, self.fault, self.checked, self.begin)
        for part in (self.drops, self.take_over):
            self.put(part)
        self.show_drops(None)

    def show_drops(self, found: Calibration | None) -> None:
        """Show what the drops of the session say of the antennas; None: nothing."""
        self.drops.show_calibration(found)
        for part in (self.drops, self.take_over):
            part.setVisible(found is not None)

    def refresh(self) -> None:
        """Show what holds for the setup now."""
        setup = self._model.setup
        words = calibration_words(setup) or "none: angles and distances as measured by hand"
        self.words.setText(f"{words[0].upper()}{words[1:]}")
        edited = edited_since(setup)
        old = too_old(setup, datetime.now().astimezone())
        faults = filter(None, (old, in_words(edited.text) if edited else ""))
        self.fault.say(". ".join(f"{one[0].upper()}{one[1:]}" for one in faults))
