"""Where sessions are kept, who measures, and notes."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QLineEdit, QPlainTextEdit, QPushButton, QVBoxLayout, QWidget

from radargui.gui.setup.form import FormScroll, Group, plain_label, side_by_side


class SessionPanel(QWidget):
    """Data folder, operator, notes, and the folder of the session that is open."""

    details_changed = Signal()
    folder_changed = Signal()
    new_asked = Signal()
    open_asked = Signal()

    def __init__(self, data_folder: Path, operator: str = "") -> None:
        super().__init__()
        content = QWidget()
        column = QVBoxLayout(content)
        column.setContentsMargins(6, 6, 6, 6)
        group = Group("Session")
        self._folder = QLineEdit(str(data_folder))
        self._folder.setObjectName("session.data_folder")
        self._folder.textChanged.connect(lambda _text: self.folder_changed.emit())
        self._choose = QPushButton("Choose…")
        self._choose.clicked.connect(self._browse)
        group.row("Data folder", side_by_side(self._folder, self._choose), "A new session makes its folder here")
        self._operator = QLineEdit(operator)
        self._operator.setObjectName("session.operator")
        self._operator.editingFinished.connect(self.details_changed)
        group.row("Operator", self._operator)
        self._notes = QPlainTextEdit()
        self._notes.setObjectName("session.notes")
        self._notes.setPlaceholderText("sphere, floor, what was changed …")
        self._notes.setTabChangesFocus(True)
        self._notes.setMinimumHeight(48)
        self._notes.setMaximumHeight(90)
        self._notes.textChanged.connect(self.details_changed)
        group.row("Notes", self._notes)
        self._open = plain_label()
        group.row("Now open", self._open)
        new = QPushButton("New session")
        new.clicked.connect(self.new_asked)
        old = QPushButton("Open…")
        old.clicked.connect(self.open_asked)
        self._buttons = (new, old)
        group.whole(side_by_side(new, old))
        column.addWidget(group)
        column.addStretch(1)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(0, 0, 0, 0)
        outer.addWidget(FormScroll(content))
        self.show_session(None)

    @property
    def data_folder(self) -> Path:
        """Where new sessions go."""
        return Path(self._folder.text().strip().strip('"')).expanduser()

    @property
    def operator(self) -> str:
        """Who measures."""
        return self._operator.text().strip()

    @property
    def notes(self) -> str:
        """What the operator wrote."""
        return self._notes.toPlainText().strip()

    def set_details(self, operator: str, notes: str) -> None:
        """Show operator and notes of a session that was opened."""
        for widget, text in ((self._operator, operator), (self._notes, notes)):
            widget.blockSignals(True)
            widget.setText(text) if isinstance(widget, QLineEdit) else widget.setPlainText(text)
            widget.blockSignals(False)

    def show_session(self, path: Path | None) -> None:
        """Name the session that runs go to."""
        self._open.setText(path.name if path else "none yet: made at the first Record")
        self._open.setToolTip(str(path or ""))

    def set_running(self, running: bool) -> None:
        """Close or open what must not change while runs are recorded; notes stay open."""
        for widget in (self._folder, self._choose, *self._buttons):
            widget.setEnabled(not running)

    def _browse(self) -> None:
        name = QFileDialog.getExistingDirectory(self, "Data folder", str(self.data_folder))
        if name:
            self._folder.setText(name)
