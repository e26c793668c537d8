"""Nothing is unexplained: every input, button, column and plot says what it is, and in which unit."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QListView,
    QMenu,
    QPlainTextEdit,
    QTableView,
    QToolButton,
    QWidget,
)

from radargui.gui.main_window import MainWindow
from radargui.gui.plots.plot import Plot
from radargui.gui.setup.fields import Changed

INPUTS = (QAbstractButton, QLineEdit, QAbstractSpinBox, QComboBox, QPlainTextEdit, Plot)


def tip_of(widget: QWidget) -> str:
    """Return what Qt shows over a widget: its own tip, else that of what it stands in."""
    one: QWidget | None = widget
    while one is not None and not one.isWindow():
        if one.toolTip():
            return one.toolTip()
        one = one.parentWidget()
    return ""


def is_no_input(widget: QWidget) -> bool:
    """Return whether nobody enters anything: words, or what Qt put there by itself, as the cross that clears a line."""
    in_line = isinstance(widget, QToolButton) and isinstance(widget.parentWidget(), QLineEdit)
    if isinstance(widget, QPlainTextEdit) and widget.isReadOnly():
        return True
    if type(widget) is QAbstractButton and isinstance(widget.parentWidget(), QTableView):
        return True  # the corner of a table, which older versions of Qt give no name
    own = widget.objectName().startswith(("qt_spinbox", "qt_tableview", "qt_toolbar_ext", "qt_menubar_ext", "Scroll"))
    return own or (in_line and not isinstance(widget, Changed))


def words_on(widget: QWidget) -> str:
    return str(getattr(widget, "text", str)() or widget.accessibleName() or widget.objectName())


def unexplained(root: QWidget) -> Iterator[str]:
    """Yield what has no tip, or one that says no more than what stands on it."""
    for widget in root.findChildren(QWidget):
        if isinstance(widget, INPUTS) and not is_no_input(widget):
            tip = tip_of(widget)
            if not tip or (isinstance(widget, QAbstractButton) and tip == words_on(widget)):
                yield f"{type(widget).__name__} {words_on(widget)!r} in {type(widget.parentWidget()).__name__}"
    for table in root.findChildren(QTableView):
        for column in range(table.model().columnCount()):
            title, tip = (
                str(table.model().headerData(column, Qt.Orientation.Horizontal, role) or "")
                for role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole)
            )
            unit = re.search(r"\[(.+)\]", title)
            if not tip or (unit and unit[1].partition("/")[0] not in tip):
                yield f"column {title!r} of {table.objectName()}"


def unnamed(root: QWidget) -> Iterator[str]:
    """Yield what the keys come to and who does not see it is not told what it is."""
    for widget in root.findChildren(QWidget):
        tabbed = widget.focusPolicy() & Qt.FocusPolicy.TabFocus and widget.focusProxy() is None
        own = widget.objectName().startswith("qt_") or isinstance(widget, QListView) or widget.inherits("QMenu")
        menu = any(isinstance(one, QMenu) for one in ancestors(widget))
        if tabbed and not own and not menu:
            face = QAccessible.queryAccessibleInterface(widget)
            if face is not None and not face.text(QAccessible.Text.Name):
                yield f"{type(widget).__name__} {widget.objectName()!r} in {type(widget.parentWidget()).__name__}"


def ancestors(widget: QWidget) -> Iterator[QWidget]:
    one = widget.parentWidget()
    while one is not None:
        yield one
        one = one.parentWidget()


def test_every_input_button_column_and_plot_says_what_it_is(window: MainWindow, record_one: Any) -> None:
    does = window.actions_
    record_one(window)
    window.runs.table.selectRow(0)
    for action in (does.sessions, does.wiring, does.log, does.guide, does.preview, does.calibrate):
        action.trigger()
    for action in (does.import_, does.export_samples, does.compare):
        action.trigger()
    for kind in ("simulated", "ni", "replay"):
        window.hardware.choose(kind)
    QApplication.processEvents()
    assert sorted(set(unexplained(window))) == []
    assert sorted(set(unnamed(window))) == []
    dialogs = {type(one).__name__ for one in window.findChildren(QWidget) if one.isWindow()}
    assert {"WiringCheck", "LogWindow", "ImportDialog", "ExportDialog"} <= dialogs
    assert {"CalibrationDialog", "ReprocessDialog"} <= dialogs
    assert window.guide.isVisible()


def test_the_window_has_its_icon_in_bar_and_desktop(qapp: QApplication) -> None:
    from PySide6.QtGui import QIcon

    from radargui.system.resources import resources_folder

    icon = QIcon(str(resources_folder() / "window" / "radargui.svg"))
    for size in (16, 32, 256):
        image = icon.pixmap(size).toImage()
        assert image.width() == size
        # no blank: the ground of the sign and the bow of the fall
        assert len({image.pixelColor(x, size // 2).name() for x in range(size)}) >= 2
