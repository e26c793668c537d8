"""A window beside the main one, as large as the screen lets it, that comes again as it was left."""

from PySide6.QtCore import QEvent, QObject, QPoint, QSize
from PySide6.QtGui import QHideEvent
from PySide6.QtWidgets import QDialog, QVBoxLayout, QWidget

from radargui.gui.layout import Margins, Part, Scroll, fill, having
from radargui.gui.mnemonics import letter_parts
from radargui.gui.settings import Settings
from radargui.gui.theme import scaled_px

_FRAME = QSize(16, 40)
"""What the system draws around a window: edges and title (chosen by hand, the largest of usual systems)."""


def fit_screen(window: QWidget, width: int, height: int) -> None:
    """Give a window a size in pixels at the usual font, no larger than the screen has room for.

    One that is seen stays on the screen with it.
    """
    room = window.screen().availableGeometry()
    window.resize(QSize(scaled_px(width), scaled_px(height)).boundedTo(room.size() - _FRAME))
    if window.isVisible():
        taken, most = window.frameGeometry(), room.bottomRight() - room.topLeft()
        last = room.topLeft() + most - QPoint(taken.width(), taken.height()) + QPoint(1, 1)
        window.move(max(room.left(), min(taken.left(), last.x())), max(room.top(), min(taken.top(), last.y())))


class Dialog(QDialog):
    """A window beside the main one.

    Parameters
    ----------
    size
        At first, in pixels at the usual font.
    name, settings
        By which and where its size, columns and parts are remembered; without them they are not.
    """

    def __init__(
        self,
        title: str,
        size: tuple[int, int],
        parent: QWidget | None = None,
        name: str = "",
        settings: Settings | None = None,
    ) -> None:
        super().__init__(parent)
        self._kept_in = settings
        fit_screen(having(self, windowTitle=title, objectName=name), *size)

    def lay_out(self, *parts: Part, margins: Margins = (9, 9, 9, 9), spacing: int = 6) -> None:
        """Put the parts one beneath the other, as they were left the last time."""
        fill(QVBoxLayout(self), *parts, margins=margins, spacing=spacing)
        if self._kept_in is not None:
            self._kept_in.restore_sizes(self)

    def event(self, event: QEvent) -> bool:
        """Give what is seen its letters, whenever something comes, goes or is called otherwise."""
        if event.type() == QEvent.Type.Show:
            for room in self.findChildren(Scroll):
                room.content.installEventFilter(self)
        if event.type() in (QEvent.Type.Show, QEvent.Type.LayoutRequest):
            letter_parts(self)
        return super().event(event)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Hear what comes and goes in what is scrolled, too."""
        if event.type() == QEvent.Type.LayoutRequest:
            letter_parts(self)
        return super().eventFilter(watched, event)

    def hideEvent(self, event: QHideEvent) -> None:  # noqa: N802 - Qt's name
        """Remember how it was left: the next one may be another object."""
        super().hideEvent(event)
        if self._kept_in is not None:
            self._kept_in.keep_sizes(self)

    def come_up(self) -> None:
        """Stand before the other windows."""
        self.show()
        self.raise_()
        self.activateWindow()
