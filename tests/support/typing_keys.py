"""Fields of the setup found by their key, and typed into as an operator does."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit, QWidget

from radargui.gui.layout import Sections


def line(window: QWidget, key: str) -> QLineEdit:
    """Return the line of a key."""
    found = window.findChild(QLineEdit, key)
    assert found is not None
    reveal(found)
    return found


def reveal(field: QWidget) -> None:
    """Open the section that a field stands in."""
    above = field.parentWidget()
    while above is not None:
        if isinstance(above, Sections):
            above.reveal(field)
        above = above.parentWidget()


def typed(window: QWidget, key: str, text: str) -> None:
    """Type a text over what stands in a line."""
    line(window, key).setFocus()
    QTest.keyClick(line(window, key), Qt.Key.Key_A, Qt.KeyboardModifier.ControlModifier)
    QTest.keyClick(line(window, key), Qt.Key.Key_Delete)
    QTest.keyClicks(line(window, key), text)
