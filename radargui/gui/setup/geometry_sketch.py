"""The drawing of the setup, from the side and from above, to scale; follows the typing and shows what is edited."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetrics, QPainter, QPaintEvent, QPen, QPolygonF
from PySide6.QtWidgets import QSizePolicy, QWidget

from radargui.gui.layout import follow, having
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup_words import words_of
from radargui.gui.theme import Theme, draw_line, scaled_px, write
from radargui.model.arrays import FloatArray
from radargui.model.calibrated_setup import unit_of
from radargui.model.calibration import Calibration
from radargui.model.rounding import UNKNOWN, concise, with_sign
from radargui.model.scattering import received_direction, transmitted_direction
from radargui.model.setup import Setup
from radargui.physics.path_length import HALF_FIELD_M, place_antennas

_STROKE_M = 0.09
"""Half of a polarisation's stroke: long enough to show its direction at a third of a panel's width."""
_LEAST = 110
"""Pixels (chosen by hand): in less the names lie upon another."""
_EDGE_PX, _DOT_PX = 28, 4.0
"""Left free at the edges for words, and half of the edge of a mark (chosen by hand)."""
_VIEWS = (("Side", "x", "z", (0, 2)), ("Top", "x", "y", (0, 1)))
"""Name, axis to the right, axis upwards, and the places of both in x, y, z."""
_SHOWN_KEYS = (("tilt_deg", "distance_m", "release_position_m[3]"), ("azimuth_deg",))
"""What the words beside a place say in each view: what one sees from there."""
_LEARNT = 0.02
"""Share of a variance: who knows no better by more than this was told nothing (chosen by hand)."""
_BARS_MM = (50, 100, 200, 500, 1000, 2000, 5000, 10_000)
"""Lengths of the scale: the shortest one that is longer than 30 pixels is drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnPlace:
    """One place of the drawing.

    Attributes
    ----------
    keys
        What its keys in the setup begin with: of the field that has the keys it is highlighted.
    name, role
        Beside it; role of the theme's colours.
    place_m
        Shape (3,).
    field
        Direction of its electric field, shape (3,); None: not given.
    """

    keys: str
    name: str
    role: str
    place_m: FloatArray
    field: FloatArray | None = None

    @property
    def words(self) -> str:
        """Where it is, in words."""
        x, y, z = 1e3 * self.place_m
        return f"{self.name}: x {x:.0f}, y {y:.0f}, z {z:.0f} mm"


def places_of(setup: Setup) -> tuple[DrawnPlace, ...]:
    """Return transmitter, receivers and release of a setup."""
    antennas, sent = place_antennas(setup), setup.transmitter.polarization_deg
    # without the transmitter's direction no receiver has one
    got = () if sent is None else setup.received_fields()
    fields = [received_direction(one.angle_deg, one.horizontal, one.vertical) for one in got]
    own = None if sent is None else transmitted_direction(sent)
    drawn = [DrawnPlace("transmitter", "Tx", "text", antennas.transmitter_m, own)]
    for n, (place, field) in enumerate(zip_longest(antennas.receivers_m, fields), 1):
        drawn.append(DrawnPlace(f"receiver[{n}]", f"Rx {n}", f"receivers.{n - 1}", place, field))
    return (*drawn, DrawnPlace("tracer", "Release", "text", np.array(setup.tracer.release_position_m)))


def drops_say(found: Calibration | None) -> Mapping[str, str]:
    """Return what the drops say of each value, by its key: the value with its uncertainty, and the pull.

    The pull is how far it is from what was stated, in what was learnt: normal with deviation one in a right setup.
    """
    if found is None:
        return {}
    said, u_found = {}, np.sqrt(np.diag(found.covariance))
    for name, *value in zip(found.names, found.before, found.values, found.u_before, u_found, strict=True):
        stated, at, u_stated, u = map(float, value)
        learnt, (unit, scale) = u_stated**2 - u**2, unit_of(name)
        known = learnt > _LEARNT * u_stated**2
        pull = with_sign((at - stated) / math.sqrt(learnt), 1) if known else UNKNOWN
        table, _, rest = name.partition(".")
        number, _, last = rest.partition(".") if table == "receiver" else ("", "", rest)
        value_key, _, axis = last.partition(".")
        key = f"{table}[{number}]" if number else table
        at_axis = f"[{'xyz'.index(axis) + 1}]" if axis else ""
        shown = concise(at, u, "" if unit == "°" else unit, scale)
        said[f"{key}.{value_key}{at_axis}"] = f"{shown}{unit * (unit == '°')}, pull {pull}"
    return said


class GeometrySketch(QWidget):
    """Antennas, release, floor and field of view, with their numbers; polarisations are strokes, beams are shaded.

    Attributes
    ----------
    places
        What is drawn.
    edited
        Key of the field in which the operator is.
    drops
        What the drops of the session say, by the keys of the setup.
    """

    def __init__(self, model: SetupModel, theme: Theme) -> None:
        super().__init__()
        self._model, self._theme, self.edited = model, theme, ""
        self.places: tuple[DrawnPlace, ...] = ()
        self.drops: Mapping[str, str] = {}
        self.floor_m: float | None = None
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        named = "Drawing of the setup, from the side and from above"
        having(self, minimumHeight=_LEAST, accessibleName=named)
        theme.application.focusChanged.connect(self._focus_moved)
        theme.changed.connect(self.update)
        follow(model.changed, self.refresh)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return room for two views beside each other."""
        return QSize(300, _LEAST)

    def show_drops(self, found: Calibration | None) -> None:
        """Say beside each place what the drops of the session say of it; None: nothing."""
        self.drops = drops_say(found)
        self.refresh()

    def words_beside(self, view: int, one: DrawnPlace) -> str:
        """Return what stands beside a place in a view: its name, what is typed, and what the drops say of that."""
        lines = [one.name]
        for key in (f"{one.keys}.{name}" for name in _SHOWN_KEYS[view]):
            words, value = words_of(key), self._model.value(key)
            if isinstance(value, (int, float)):
                lines.append(f"{words.name.removeprefix(one.name).strip().lower()} {words.with_unit(value)}")
                if key in self.drops:
                    lines.append(f"drops: {self.drops[key]}")
        return "\n".join(lines)

    def refresh(self) -> None:
        """Take over the setup as it was right last."""
        self.places, self.floor_m = places_of(self._model.setup), self._model.setup.floor.height_m
        floor = "from the impacts" if self.floor_m is None else f"z {1e3 * self.floor_m:.0f} mm"
        words = "\n".join((*(one.words for one in self.places), f"Floor: {floor}"))
        self.setAccessibleDescription(words)
        self.setToolTip(
            "The setup to scale. Dashed: the field of view, 30 x 30 x 30 cm round the origin; stroke: polarisation, "
            f"as far as it lies in the drawing.\n{words}"
        )
        self.update()

    def is_edited(self, keys: str) -> bool:
        """Return whether the operator is in a field of what these keys belong to."""
        return self.edited == keys or self.edited.startswith(f"{keys}.")

    def _focus_moved(self, _old: QWidget | None, now: QWidget | None) -> None:
        # elsewhere nothing is edited; while a menu or another window is up the last one stays
        if now is not None:
            self.edited = now.objectName() if now.window() is self.window() else ""
            self.update()

    def scale(self) -> float:
        """Return pixels a metre, the same in both views."""
        edge = scaled_px(_EDGE_PX)
        width, height = 0.5 * self.width() - 2.0 * edge, self.height() - 3.0 * edge
        spans = [np.ptp(self._reach(axes), axis=1).tolist() for *_, axes in _VIEWS]
        return float(min(min(width / across, height / up) for across, up in spans))

    def at(self, view: int, place_m: FloatArray) -> QPointF:
        """Return where a place is drawn in view 0 (from the side) or 1 (from above)."""
        axes = _VIEWS[view][3]
        low, high = self._reach(axes).T
        across, up = self.scale() * (place_m[list(axes)] - 0.5 * (low + high))
        middle = 0.5 * (self.height() + scaled_px(_EDGE_PX))
        return QPointF((0.25 + 0.5 * view) * self.width() + across, middle - up)

    def _reach(self, axes: tuple[int, int]) -> FloatArray:
        """Return the ends of a view in metres, shape (2, 2)."""
        floor = [] if self.floor_m is None else [(0.0, 0.0, self.floor_m)]
        places = (one.place_m for one in self.places)
        every = np.array([*places, [-HALF_FIELD_M] * 3, [HALF_FIELD_M] * 3, *floor])[:, list(axes)]
        return np.stack([every.min(axis=0), every.max(axis=0)], axis=1)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw both views and the scale."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setOpacity(1.0 if self._model.valid else 0.5)
        for view in range(len(_VIEWS)):
            self._draw(painter, view)
        self._bar(painter)

    def _draw(self, painter: QPainter, view: int) -> None:
        title, across, up, axes = _VIEWS[view]
        colours, line = self._theme.colours, self.fontMetrics().height()
        painter.setPen(QColor(colours.text))
        left = 0.5 * view * self.width()
        painter.drawText(QPointF(left + 2, line - 3), f"{title}: {across} → , {up} ↑")
        faint, centre, half = QColor(colours.faint), np.zeros(3), np.full(3, HALF_FIELD_M)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(faint, 1.0, Qt.PenStyle.DashLine))
        painter.drawRect(QRectF(self.at(view, -half), self.at(view, half)).normalized())
        if self.floor_m is not None and axes[1] == 2:
            height = self.at(view, np.array([0.0, 0.0, self.floor_m])).y()
            bold = self.is_edited("floor")
            painter.setPen(QPen(QColor(colours.text) if bold else faint, 3.0 if bold else 1.5))
            painter.drawLine(QPointF(left + 0.08 * self.width(), height), QPointF(left + 0.42 * self.width(), height))
            words = f"Floor {words_of('floor.height_m').with_unit(self.floor_m)}"
            painter.drawText(QPointF(left + 0.08 * self.width(), height + line - 2.0), words)
        painter.setPen(QPen(faint, 1.0))
        for end in (QPointF(5, 0), QPointF(0, 5)):
            painter.drawLine(self.at(view, centre) - end, self.at(view, centre) + end)
        painter.setPen(QPen(QColor(colours.line), 1.0))
        middle = self.at(view, centre)
        for one in self.places[:-1]:
            where = self.at(view, one.place_m)
            draw_line(painter, where, middle, QPen(QColor(colours.line), 1.0))
            away = math.hypot(where.x() - middle.x(), where.y() - middle.y())
            if away > 1.0:
                # as wide as the field of view that it has to cover
                side = QPointF(middle.y() - where.y(), where.x() - middle.x()) * (self.scale() * HALF_FIELD_M / away)
                painter.setPen(Qt.PenStyle.NoPen)
                painter.setBrush(having(QColor(colours.role(one.role)), alpha=18))
                painter.drawPolygon(QPolygonF([where, middle + side, middle - side]))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        # no name upon a mark or a stroke, whichever is drawn first
        edge = (-_DOT_PX, -_DOT_PX, _DOT_PX, _DOT_PX)
        taken = [QRectF(*self._ends(view, one)).normalized().adjusted(*edge) for one in self.places]
        # nor upon the scale
        taken.append(QRectF(self.width() - 9.0 * line, self.height() - line - 4.0, 9.0 * line, line + 4.0))
        for one in self.places:
            self._place(painter, view, one, taken)

    def _ends(self, view: int, one: DrawnPlace) -> tuple[QPointF, QPointF]:
        """Return the ends of a place's stroke; where it has none, the place twice."""
        half = _STROKE_M * (np.zeros(3) if one.field is None else one.field)
        return self.at(view, one.place_m - half), self.at(view, one.place_m + half)

    def _place(self, painter: QPainter, view: int, one: DrawnPlace, taken: list[QRectF]) -> None:
        colour, where = QColor(self._theme.colours.role(one.role)), self.at(view, one.place_m)
        edited = self.is_edited(one.keys)
        size = _DOT_PX * (1.3 if edited else 1.0)
        away = 2.4 * size
        if one.field is not None:
            left, right = self._ends(view, one)
            draw_line(painter, left, right, QPen(colour, 2.5))
            away = max(away, 0.5 * max(abs(right.x() - left.x()), abs(right.y() - left.y())) + _DOT_PX)
        painter.setPen(QPen(colour, 1.5))
        painter.setBrush(colour)
        if one.keys == "tracer":
            radius = max(0.8 * size, 0.5 * self.scale() * self._model.setup.tracer.diameter_m)
            painter.drawEllipse(where, radius, radius)
        elif one.keys == "transmitter":
            tips = (QPointF(-size, -size), QPointF(size, -size), QPointF(0, size))
            painter.drawPolygon(QPolygonF([where + tip for tip in tips]))
        else:
            painter.drawRect(QRectF(where.x() - size, where.y() - size, 2 * size, 2 * size))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        if edited:
            painter.setPen(QPen(colour, 2.0))
            painter.drawEllipse(where, 2.4 * size, 2.4 * size)
        font = having(self.font(), bold=edited)
        metrics = QFontMetrics(font)
        lines = self.words_beside(view, one).split("\n")
        wide, high = max(map(metrics.horizontalAdvance, lines)) + 2.0, float(metrics.height() * len(lines))
        # beside it where no other words stand, as far as the drawing reaches
        room, away = QRectF(self.rect()).adjusted(0.0, metrics.height(), 0.0, 0.0), away + 2.0
        for across, down in (
            *((away, -0.5 * high), (-away - wide, -0.5 * high), (-0.5 * wide, away), (-0.5 * wide, -away - high)),
            *((away, -high - away), (away, away), (-away - wide, away), (-away - wide, -high - away)),
        ):
            begin = min(max(where.x() + across, room.left()), room.right() - wide)
            top = min(max(where.y() + down, room.top()), room.bottom() - high)
            box = QRectF(begin, top, wide, high)
            if not any(box.intersects(other) for other in taken):
                break
        taken.append(box)
        side = Qt.AlignmentFlag.AlignLeft if box.center().x() >= where.x() else Qt.AlignmentFlag.AlignRight
        write(painter, box, "\n".join(lines), self._theme.colours.role(one.role), int(side), font)
        painter.setFont(self.font())

    def _bar(self, painter: QPainter) -> None:
        """Draw how long so many millimetres are."""
        per_mm = 1e-3 * self.scale()
        length = next((mm for mm in _BARS_MM if mm * per_mm > 30.0), _BARS_MM[-1])
        right, foot = self.width() - 4.0, self.height() - 4.0
        pen = QPen(QColor(self._theme.colours.text), 1.5)
        draw_line(painter, QPointF(right - length * per_mm, foot), QPointF(right, foot), pen)
        words = f"{length} mm"
        wide = self.fontMetrics().horizontalAdvance(words)
        painter.drawText(QPointF(right - length * per_mm - wide - 6.0, foot + 1.0), words)
