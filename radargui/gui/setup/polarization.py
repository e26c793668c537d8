"""The antennas' polarisations: a row each with its uncertainty, and a drawing of what the angles mean."""

import math
from dataclasses import dataclass, replace

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from radargui.gui.layout import Group, PlainLabel
from radargui.gui.setup.fields import FieldGrid, NumberField
from radargui.gui.setup.setup_model import MOST_RECEIVERS, SetupModel
from radargui.gui.setup.words import words_of
from radargui.gui.theme import Theme
from radargui.model.assumed import ASSUMED
from radargui.model.polarization import LEAST_SHARE, received_fields

_ASSUMED_DEG = ASSUMED["u_polarization_deg"]
_ANTENNAS = ("transmitter", *(f"receiver[{number}]" for number in range(1, MOST_RECEIVERS + 1)))
_SHORT = ("Tx", *(f"Rx {number}" for number in range(1, MOST_RECEIVERS + 1)))
_HEIGHT, _MARGIN = 108, 4


class PolarizationForm(Group):
    """Angle and uncertainty of each antenna's electric field, and the drawing."""

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__("Polarisation")
        self._model = model
        table = FieldGrid(
            *(words_of(f"transmitter.{name}").label for name in ("polarization_deg", "u_polarization_deg"))
        )
        self._rows: list[tuple[NumberField, list[QWidget]]] = []
        for name, antenna in zip(_SHORT, _ANTENNAS, strict=True):
            angle = NumberField(model, theme, f"{antenna}.polarization_deg", optional=True)
            hint = f"{_ASSUMED_DEG:g} assumed"
            u = NumberField(model, theme, f"{antenna}.u_polarization_deg", optional=True, hint=hint)
            self._rows.append((angle, table.add_row(name, (angle, u))))
        self.sketch = PolarizationSketch(model, theme)
        said = (
            "Each antenna from behind, looking at the centre. Arrow: electric field; wedge: uncertainty; dashed: "
            "strongest signal, of which the receiver gets so much."
        )
        for part in (table, self.sketch, PlainLabel(said)):
            self.whole(part)
        model.changed.connect(self._refresh)
        self._refresh()

    def _refresh(self) -> None:
        drawn = self.sketch.antennas
        for place, (angle, row) in enumerate(self._rows):
            for widget in row:
                widget.setVisible(place <= self._model.n_receivers)
            strongest_deg = drawn[place].strongest_deg if place < len(drawn) else None
            angle.setPlaceholderText("not given" if strongest_deg is None else f"strongest, {strongest_deg:.1f}")


@dataclass(frozen=True, slots=True)
class DrawnAntenna:
    """One dial of the drawing.

    Attributes
    ----------
    name, axes
        Beneath it; what points right and what up.
    angle_deg, u_deg
        Of the field; None: not given.
    strongest_deg, share
        Of a receiver: the angle of the strongest signal, and what it gets of it; None where that is not known.
    """

    name: str
    axes: tuple[str, str]
    angle_deg: float | None
    u_deg: float
    strongest_deg: float | None = None
    share: float | None = None

    @property
    def words(self) -> str:
        """What is drawn, in words."""
        if self.angle_deg is None:
            return f"{self.name}: not given"
        got = f", {self.share:.0%} of the strongest signal" if self.share is not None else ""
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
        theme.changed.connect(self.update)
        self.refresh()

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return room for a dial each."""
        return QSize(60 * (1 + self._model.n_receivers), _HEIGHT)

    def refresh(self) -> None:
        """Take over what the draft says."""
        setup, sent = self._model.setup, self._number("transmitter.polarization_deg")
        self.antennas = [DrawnAntenna("Tx", ("x", "y"), sent, self._u("transmitter"))]
        receivers = [
            one.model_copy(update={"polarization_deg": self._number(f"receiver[{number}].polarization_deg")})
            for number, one in enumerate(setup.receiver, 1)
        ]
        fields = () if sent is None else received_fields(setup.radar, setup.transmitter, receivers, setup.tracer, sent)
        for number in range(1, len(receivers) + 1):
            drawn = DrawnAntenna(f"Rx {number}", ("h", "v"), None, self._u(f"receiver[{number}]"))
            if fields:
                own = fields[number - 1]
                drawn = replace(drawn, angle_deg=own.angle_deg, strongest_deg=own.strongest_deg, share=own.share)
            self.antennas.append(drawn)
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
        colours = (self._theme.colours.mark, *self._theme.colours.receivers)
        for place, antenna in enumerate(self.antennas):
            middle = QPointF((place + 0.5) * width, self.middle_y)
            self._dial(painter, antenna, middle, radius, QColor(colours[place]))
            below = QRectF(place * width, self.height() - 2 * line, width, line)
            painter.setPen(QColor(self._theme.colours.text))
            painter.drawText(below, Qt.AlignmentFlag.AlignCenter, antenna.name)
            said = "" if antenna.angle_deg is None else f"{antenna.angle_deg:.0f}°"
            if antenna.share is not None:
                said = f"{antenna.share:.0%}"
                weak = antenna.share < LEAST_SHARE
                painter.setPen(QColor(self._theme.colours.alarm if weak else self._theme.colours.faint))
            painter.drawText(below.translated(0.0, line), Qt.AlignmentFlag.AlignCenter, said)

    def _dial(self, painter: QPainter, antenna: DrawnAntenna, middle: QPointF, radius: float, colour: QColor) -> None:
        faint = QColor(self._theme.colours.faint)
        box = QRectF(middle.x() - radius, middle.y() - radius, 2.0 * radius, 2.0 * radius)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(QColor(self._theme.colours.line), 1.0))
        painter.drawEllipse(box)
        for angle_deg in (0.0, 90.0):
            painter.drawLine(_at(middle, radius, angle_deg + 180.0), _at(middle, radius, angle_deg))
        painter.setPen(faint)
        for name, angle_deg in zip(antenna.axes, (0.0, 90.0), strict=True):
            place = _at(middle, radius + 7.0, angle_deg)
            painter.drawText(QRectF(place.x() - 8.0, place.y() - 8.0, 16.0, 16.0), Qt.AlignmentFlag.AlignCenter, name)
        if antenna.strongest_deg is not None:
            painter.setPen(QPen(faint, 1.0, Qt.PenStyle.DashLine))
            across = antenna.strongest_deg + 180.0
            painter.drawLine(_at(middle, radius, antenna.strongest_deg), _at(middle, radius, across))
        if antenna.angle_deg is None:
            return
        wedge = QColor(colour)
        wedge.setAlpha(120)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(wedge)
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
