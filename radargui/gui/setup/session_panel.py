"""Where sessions are kept, who measures, what, and notes, also of a moment."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QLineEdit, QPlainTextEdit, QPushButton, QVBoxLayout, QWidget

from radargui.gui.setup.form import FormScroll, Group, plain_label, side_by_side
from radargui.session.info import JournalEntry

Details = tuple[str, str, str, str]
"""Operator, notes, sample, target, as `set_details` takes them."""


class SessionPanel(QWidget):
    """Data folder, operator, sample, target, notes, and the folder of the session that is open."""

    details_changed = Signal()
    folder_changed = Signal()
    new_asked = Signal()
    open_asked = Signal()
    mark_asked = Signal(str)

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
        self._sample = self._line("sample", "Sample", "What is measured: material, make, surface")
        self._target = self._line("target", "Target", "What it falls on, or moves in")
        for field in (self._sample, self._target):
            field.editingFinished.connect(self.details_changed)
            group.row(field.accessibleName(), field, field.toolTip())
        self._notes = QPlainTextEdit()
        self._notes.setObjectName("session.notes")
        self._notes.setPlaceholderText("what else is worth knowing …")
        self._notes.setTabChangesFocus(True)
        self._notes.setMinimumHeight(48)
        self._notes.setMaximumHeight(90)
        self._notes.textChanged.connect(self.details_changed)
        group.row("Notes", self._notes)
        self._mark = QLineEdit()
        self._mark.setObjectName("session.mark")
        self._mark.setPlaceholderText("kept with time and sample")
        self._mark.returnPressed.connect(self.ask_mark)
        self._keep_mark = QPushButton("Keep")
        self._keep_mark.clicked.connect(self.ask_mark)
        group.row("Note now", side_by_side(self._mark, self._keep_mark), "Also while a run is recorded (Ctrl+M)")
        self._marked = plain_label()
        group.row("", self._marked)
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

    @property
    def sample(self) -> str:
        """What is measured."""
        return self._sample.text().strip()

    @property
    def target(self) -> str:
        """What it falls on."""
        return self._target.text().strip()

    @property
    def details(self) -> Details:
        """What was typed."""
        return self.operator, self.notes, self.sample, self.target

    def set_details(self, operator: str, notes: str, sample: str = "", target: str = "") -> None:
        """Show what a session that was opened says of itself."""
        fields = (
            (self._operator, operator),
            (self._notes, notes),
            (self._sample, sample),
            (self._target, target),
        )
        for widget, text in fields:
            widget.blockSignals(True)
            widget.setText(text) if isinstance(widget, QLineEdit) else widget.setPlainText(text)
            widget.blockSignals(False)

    def show_session(self, path: Path | None, *, read_only: bool = False) -> None:
        """Name the session that runs go to; one for looking only takes no changes."""
        name = path.name if path else "none yet: made at the first Record"
        self._open.setText(f"{name}, for looking only" if read_only else name)
        self._open.setToolTip(str(path or ""))
        for field in (self._operator, self._sample, self._target, self._notes):
            field.setReadOnly(read_only)
        for widget in (self._mark, self._keep_mark):
            widget.setEnabled(path is not None and not read_only)
        self._marked.setText("")

    def write_mark(self) -> None:
        """Let the operator type a note."""
        self._mark.setFocus()

    def ask_mark(self) -> None:
        """Ask for the typed note to be kept."""
        text = self._mark.text().strip()
        if text:
            self._mark.clear()
            self.mark_asked.emit(text)

    def show_marked(self, entry: JournalEntry) -> None:
        """Say that a note was kept, and where."""
        where = f"{entry.run}, sample {entry.index}" if entry.run else "between runs"
        self._marked.setText(f"{entry.at[11:19]} {entry.text} ({where})")

    def set_running(self, running: bool) -> None:
        """Close or open what must not change while runs are recorded; notes stay open."""
        for widget in (self._folder, self._choose, *self._buttons):
            widget.setEnabled(not running)

    @staticmethod
    def _line(name: str, words: str, tip: str) -> QLineEdit:
        field = QLineEdit()
        field.setObjectName(f"session.{name}")
        field.setAccessibleName(words)
        field.setToolTip(tip)
        return field

    def _browse(self) -> None:
        name = QFileDialog.getExistingDirectory(self, "Data folder", str(self.data_folder))
        if name:
            self._folder.setText(name)
