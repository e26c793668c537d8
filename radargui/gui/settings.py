"""What the window remembers between starts; a corrupt memory never blocks the start."""

import contextlib
import time
from pathlib import Path
from typing import Any

from PySide6.QtCore import QByteArray, QSettings
from PySide6.QtWidgets import QDialog, QSplitter, QWidget

from radargui.gui.table import RowTable
from radargui.gui.theme import CHOICES, ThemeChoice

LAYOUT_VERSION = 4
"""Of the panels: one more where they change so that a layout kept before no longer fits; that one is then left out."""


class Settings:
    """Typed access to QSettings: a value of the wrong type reads as if it were not there.

    Parameters
    ----------
    path
        File to use; the user's own settings where left out.
    """

    def __init__(self, path: Path | None = None) -> None:
        self.set_aside: Path | None = None
        self._store = self._open(path)
        if self._store.status() == QSettings.Status.FormatError:
            damaged = Path(self._store.fileName())
            aside = damaged.with_name(f"{damaged.name}.corrupt-{int(time.time())}")
            with contextlib.suppress(OSError):
                damaged.replace(aside)
                self.set_aside = aside
            self._store = self._open(path)

    @staticmethod
    def _open(path: Path | None) -> QSettings:
        ini, scope = QSettings.Format.IniFormat, QSettings.Scope.UserScope
        return QSettings(str(path), ini) if path is not None else QSettings(ini, scope, "RadarGUI", "RadarGUI")

    def text(self, key: str, default: str = "") -> str:
        """Return a text."""
        value = self._value(key)
        return value if isinstance(value, str) else default

    def number(self, key: str, default: float, low: float, high: float) -> float:
        """Return a number within its range."""
        try:
            value = float(self._value(key))
        except (TypeError, ValueError):
            return default
        return value if low <= value <= high else default

    def blob(self, key: str) -> QByteArray:
        """Return bytes, empty where there are none."""
        value = self._value(key)
        return value if isinstance(value, QByteArray) else QByteArray()

    def path(self, key: str) -> Path | None:
        """Return a path, None where there is none."""
        text = self.text(key)
        return Path(text) if text else None

    def theme(self) -> ThemeChoice:
        """Return the chosen look."""
        text = self.text("theme", "system")
        return next((choice for choice in CHOICES if choice == text), "system")

    def put(self, key: str, value: Any) -> None:
        """Remember a value; paths are kept as text."""
        self._store.setValue(key, str(value) if isinstance(value, Path) else value)

    def forget(self, key: str) -> None:
        """Forget a value."""
        self._store.remove(key)

    def keep_sizes(self, root: QWidget) -> None:
        """Remember how the operator set a window, and the dialogs, splitters and columns in it that have a name."""
        for table in root.findChildren(RowTable):
            if table.columns_chosen:
                self.put(_columns(table), table.horizontalHeader().saveState())
        for part in (root, *root.findChildren(QSplitter), *root.findChildren(QDialog)):
            if isinstance(part, QSplitter | QDialog) and part.objectName():
                state = part.saveState() if isinstance(part, QSplitter) else part.saveGeometry()
                self.put(f"sizes/{part.objectName()}", state)

    def restore_sizes(self, root: QWidget) -> None:
        """Set dialogs, splitters and columns as they were kept."""
        for table in root.findChildren(RowTable):
            table.columns_chosen |= table.horizontalHeader().restoreState(self.blob(_columns(table)))
        for splitter in root.findChildren(QSplitter):
            splitter.restoreState(self.blob(f"sizes/{splitter.objectName()}"))
        if isinstance(root, QDialog):
            root.restoreGeometry(self.blob(f"sizes/{root.objectName()}"))

    def sync(self) -> None:
        """Write to disk now."""
        self._store.sync()

    def _value(self, key: str) -> Any:
        try:
            return self._store.value(key)
        except Exception:  # noqa: BLE001 - a damaged variant raises what it likes
            return None


def _columns(table: RowTable[Any]) -> str:
    """Return what the widths are remembered by: not those of a table with other columns."""
    return f"sizes/{table.objectName()}/{table.model().columnCount()}"
