"""Where sessions are kept, who measures, what, and notes, also of a moment."""

from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QLineEdit, QPlainTextEdit, QVBoxLayout, QWidget

from radargui.gui.control.state import Details
from radargui.gui.layout import FormScroll, Group, PathField, PlainLabel, button, fill, having, side_by_side
from radargui.gui.panels import Actions
from radargui.session.info import DataFolderError, JournalEntry, default_data_folder

_MARKS_SHOWN = 5
"""Lines (chosen by hand): more take room from the fields; all are kept in the journal."""


class SessionPanel(QWidget):
    """Data folder, operator, sample, target, notes, and the folder of the session that is open."""

    details_changed = Signal()
    edited = Signal(object, object)
    """What takes back what was just typed, and what does it again."""
    folder_changed = Signal()
    mark_asked = Signal(str)

    def __init__(self, does: Actions, data_folder: Path, operator: str = "") -> None:
        super().__init__()
        self.folder = PathField("Data folder", data_folder)
        having(self.folder.line, objectName="session.data_folder", placeholderText=str(default_data_folder()))
        self.folder.line.textChanged.connect(self.folder_changed)
        self._lines = {words: QLineEdit() for words in ("Operator", "Sample", "Target")}
        self._lines["Operator"].setText(operator)
        for words, line in self._lines.items():
            line.setObjectName(f"session.{words.lower()}")
            line.editingFinished.connect(self.details_changed)
        self._notes = QPlainTextEdit(placeholderText="what else is worth knowing …", tabChangesFocus=True)
        having(self._notes, objectName="session.notes", minimumHeight=48, maximumHeight=90)
        self._notes.textChanged.connect(self.details_changed)
        self._known = self.details
        self.details_changed.connect(self._announce)
        self.mark = QLineEdit(placeholderText="kept with time and sample")
        having(self.mark, objectName="session.mark", accessibleName="Note now")
        self.mark.returnPressed.connect(self.ask_mark)
        self._keep_mark = button("Keep", self.ask_mark)
        self._marked, self._open = PlainLabel(), PlainLabel()
        self._buttons = (button("New session", does.new_session.trigger), button("Open…", does.sessions.trigger))
        group = Group("Session", ("Data folder", self.folder), *self._lines.items(), ("Notes", self._notes))
        group.put(("Note now", side_by_side(self.mark, self._keep_mark)), ("", self._marked), ("Now open", self._open))
        group.put(side_by_side(*self._buttons))
        fill(QVBoxLayout(self), FormScroll(group))
        self.show_session(None)

    @property
    def data_folder(self) -> Path:
        """Where new sessions go; the folder that the empty field shows, where nothing was typed."""
        return self.folder.path or default_data_folder()

    @property
    def details(self) -> Details:
        """What was typed."""
        operator, sample, target = (line.text().strip() for line in self._lines.values())
        return Details(operator, self._notes.toPlainText().strip(), sample, target)

    def _announce(self) -> None:
        before, after = self._known, self.details
        if after != before:
            self._known = after
            self.edited.emit(lambda: self._type(before), lambda: self._type(after))

    def _type(self, details: Details) -> None:
        """Type other details in the operator's place."""
        self.set_details(details.operator, details.notes, details.sample, details.target)
        self.details_changed.emit()

    def set_details(self, operator: str, notes: str, sample: str = "", target: str = "") -> None:
        """Show what a session that was opened says of itself."""
        for line, text in zip(self._lines.values(), (operator, sample, target), strict=True):
            # told only when the operator has ended a line
            line.setText(text)
        with QSignalBlocker(self._notes):
            self._notes.setPlainText(notes)
        self._known = self.details

    def say_at_field(self, error: BaseException) -> None:
        """Say what is wrong with the data folder, where it is that."""
        if isinstance(error, DataFolderError):
            self.folder.refuse(f"Data folder: {error}")

    def show_session(self, path: Path | None, *, read_only: bool = False) -> None:
        """Name the session that runs go to; one for looking only takes no changes."""
        name = path.name if path else "none yet: made at the first Record"
        having(self._open, text=f"{name}, for looking only" if read_only else name, toolTip=str(path or ""))
        self._notes.setReadOnly(read_only)
        for line in self._lines.values():
            line.setReadOnly(read_only)
        for widget in (self.mark, self._keep_mark):
            widget.setEnabled(path is not None and not read_only)
        self._marked.setText("")

    def ask_mark(self) -> None:
        """Ask for the typed note to be kept."""
        text = self.mark.text().strip()
        if text:
            self.mark.clear()
            self.mark_asked.emit(text)

    def show_marked(self, entry: JournalEntry) -> None:
        """Say that a note was kept, and where; the last ones stay in sight."""
        where = f"{entry.run}, sample {entry.index}" if entry.run else "between runs"
        lines = (*self._marked.text().splitlines(), f"{entry.at[11:19]} {entry.text} ({where})")
        self._marked.setText("\n".join(lines[-_MARKS_SHOWN:]))

    def set_running(self, running: bool) -> None:
        """Close or open what must not change while runs are recorded; notes stay open."""
        for widget in (self.folder, *self._buttons):
            widget.setEnabled(not running)
