"""The look: light or dark palette, following the system or chosen, and the plot colours that go with it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from PySide6.QtCore import QObject, QPointF, QRectF, QSignalBlocker, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QFontMetricsF, QPainter, QPalette, QPen
from PySide6.QtWidgets import QApplication

from radargui.gui.layout import having
from radargui.system.resources import resource_table

ThemeChoice = Literal["system", "light", "dark"]
CHOICES: tuple[ThemeChoice, ...] = ("system", "light", "dark")
_SCHEMES = dict(zip(CHOICES, (Qt.ColorScheme.Unknown, Qt.ColorScheme.Light, Qt.ColorScheme.Dark), strict=True))
"""Unknown: as the system has it."""


@dataclass(frozen=True, slots=True)
class Colours:
    """Colours of one look; data colours stay apart for colour-blind eyes (after Okabe and Ito).

    Attributes
    ----------
    window, base, raised, text, faint, line, edge, accent, on_accent
        Surfaces, writing, grid, edges of fields, selection and what is written on it.
    i, q
        The two voltages of a receiver.
    receivers
        One colour a receiver, for path lengths and phases.
    compared
        What is laid over each other: corrections of one run, sessions of a series.
    track, mark, fit
        The track, impacts and peaks, fitted curves.
    gap
        Shade where samples were lost.
    good, busy, alarm, idle
        States: each is always said in words too.
    """

    window: str
    base: str
    raised: str
    text: str
    faint: str
    line: str
    edge: str
    accent: str
    on_accent: str
    i: str
    q: str
    receivers: Sequence[str]
    compared: Sequence[str]
    track: str
    mark: str
    fit: str
    gap: str
    good: str
    busy: str
    alarm: str
    idle: str

    def role(self, name: str) -> str:
        """Return the colour of a role: `track`, `i`, `receivers.0`."""
        name, _, number = name.partition(".")
        colour = getattr(self, name)
        return str(colour[int(number)] if number else colour)


_TABLE = resource_table("window/colours")
LIGHT, DARK = (Colours(**_TABLE[look]) for look in ("light", "dark"))


class Theme(QObject):
    """Applies the chosen look to the application and tells plots when it changes."""

    changed = Signal()

    def __init__(self, application: QApplication, choice: ThemeChoice = "system") -> None:
        super().__init__()
        self.application = application
        self.choice: ThemeChoice = choice
        # Fusion is the one style that takes any palette on every system
        if application.style().objectName() != "fusion":
            application.setStyle("Fusion")
        application.styleHints().colorSchemeChanged.connect(self._refresh)
        self._system_dark = application.palette().color(QPalette.ColorRole.Window).lightness() < 128
        self.colours = LIGHT
        self.apply(choice)

    def apply(self, choice: ThemeChoice) -> None:
        """Show the look `choice`."""
        self.choice = choice
        hints = self.application.styleHints()
        with QSignalBlocker(hints):
            # the title bar follows where the system can; palettes are ours where it cannot
            hints.setColorScheme(_SCHEMES[choice])
        self._refresh()

    def _refresh(self) -> None:
        hints, schemes = self.application.styleHints(), Qt.ColorScheme
        scheme = hints.colorScheme() if self.choice == "system" else _SCHEMES[self.choice]
        dark = self._system_dark if scheme == schemes.Unknown else scheme == schemes.Dark
        self.colours = DARK if dark else LIGHT
        self.application.setPalette(palette(self.colours))
        for kind in _TABLE["edged"]:
            self.application.setPalette(edged_palette(self.colours), kind)
        for widget in self.application.allWidgets():
            if sheet := widget.styleSheet():
                # Qt looks the colours `palette(...)` of a sheet up only when it reads the sheet
                widget.setStyleSheet(sheet)
        self.changed.emit()


def palette(colours: Colours) -> QPalette:
    """Return the widget palette of a look."""
    made, groups = QPalette(QColor(colours.raised), QColor(colours.window)), QPalette.ColorGroup
    for group, table in ((groups.All, "palette"), (groups.Disabled, "disabled")):
        for name, role in _TABLE[table].items():
            made.setColor(group, QPalette.ColorRole[name], QColor(colours.role(role)))
    return made


_OUTLINE = 140
"""Fusion draws an outline in the colour of the window, so many hundredths as dark: on a dark one that is not seen."""


def edged_palette(colours: Colours) -> QPalette:
    """Return the palette of widgets whose outline is the look's `edge`; none of them shows its window's colour."""
    made = palette(colours)
    for group in (QPalette.ColorGroup.Active, QPalette.ColorGroup.Inactive):
        made.setColor(group, QPalette.ColorRole.Window, QColor(colours.edge).lighter(_OUTLINE))
    return made


def scaled_font(base: QFont, factor: float, *, bold: bool = False) -> QFont:
    """Return `base` made larger or smaller by a factor."""
    return having(QFont(base), pointSizeF=base.pointSizeF() * factor, bold=bold)


_DIGIT_PX = 7.625
"""Width of a digit in the font at which sizes in pixels were chosen."""
_INSIDE = 8.0 / 9.0
"""Words inside a plot against those around it (chosen by hand)."""


def scaled_px(size_px: float) -> int:
    """Return a size in pixels that was chosen at the usual font, as large in letters where they are larger."""
    digit = QFontMetricsF(QApplication.font()).horizontalAdvance("0")
    return round(size_px * max(1.0, digit / _DIGIT_PX))


def inside_pt() -> int:
    """Return the size of words inside a plot."""
    return max(1, round(_INSIDE * QApplication.font().pointSizeF()))


def even_font(base: QFont) -> QFont:
    """Return the font whose letters are all as wide, as large as `base`."""
    fixed = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
    return having(fixed, pointSizeF=base.pointSizeF())


def fitting_font(base: QFont, longest: str, width: float, height: float, points: tuple[float, float]) -> QFont:
    """Return `base`, bold and so large that the `longest` words fit a place, within the least and most `points`."""
    least, most = points
    font = having(QFont(base), bold=True, pointSizeF=most)
    metrics = QFontMetricsF(font)
    share = min(1.0, width / metrics.horizontalAdvance(longest), height / metrics.height())
    return having(font, pointSizeF=max(least, most * share))


CENTRED = int(Qt.AlignmentFlag.AlignCenter)


def write(
    painter: QPainter, box: QRectF, words: str, colour: str, align: int = CENTRED, font: QFont | None = None
) -> None:
    """Write words into a box in a colour; without a `font` in that of the painter."""
    if font is not None:
        painter.setFont(font)
    painter.setPen(QColor(colour))
    painter.drawText(box, align, words)


def draw_line(painter: QPainter, start: QPointF, end: QPointF, pen: QPen) -> None:
    """Draw a line."""
    painter.setPen(pen)
    painter.drawLine(start, end)
