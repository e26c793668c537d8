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
    folder_changed = Signal()
    mark_asked = Signal(str)

    def __init__(self, does: Actions, data_folder: Path, operator: str = "") -> None:
        super().__init__()
        group = Group("Session")
        self._folder = PathField("Data folder", data_folder)
        self._folder.line.setObjectName("session.data_folder")
        self._folder.line.setPlaceholderText(str(default_data_folder()))
        self._folder.line.textChanged.connect(lambda _text: self.folder_changed.emit())
        self.folder_fault = self._folder.fault
        group.row("Data folder", self._folder, fault=self.folder_fault)
        self._operator = QLineEdit(operator)
        self._sample, self._target, self._mark = (QLineEdit() for _ in range(3))
        for line, words in ((self._operator, "Operator"), (self._sample, "Sample"), (self._target, "Target")):
            line.setObjectName(f"session.{words.lower()}")
            line.editingFinished.connect(self.details_changed)
            group.row(words, line)
        having(self._mark, objectName="session.mark", accessibleName="Note now")
        self._notes = QPlainTextEdit(placeholderText="what else is worth knowing …", tabChangesFocus=True)
        self._notes.setObjectName("session.notes")
        self._notes.setMinimumHeight(48)
        self._notes.setMaximumHeight(90)
        self._notes.textChanged.connect(self.details_changed)
        group.row("Notes", self._notes)
        self._mark.setPlaceholderText("kept with time and sample")
        self._mark.returnPressed.connect(self.ask_mark)
        self._keep_mark = button("Keep", self.ask_mark)
        group.row("Note now", side_by_side(self._mark, self._keep_mark))
        self._marked, self._open = PlainLabel(), PlainLabel()
        group.row("", self._marked)
        group.row("Now open", self._open)
        self._buttons = (button("New session", does.new_session.trigger), button("Open…", does.sessions.trigger))
        group.whole(side_by_side(*self._buttons))
        fill(QVBoxLayout(self), FormScroll(group))
        self.show_session(None)

    @property
    def data_folder(self) -> Path:
        """Where new sessions go; the folder that the empty field shows, where nothing was typed."""
        return self._folder.path or default_data_folder()

    @property
    def details(self) -> Details:
        """What was typed."""
        lines = (self._operator, self._sample, self._target)
        operator, sample, target = (line.text().strip() for line in lines)
        return Details(operator, self._notes.toPlainText().strip(), sample, target)

    def set_details(self, operator: str, notes: str, sample: str = "", target: str = "") -> None:
        """Show what a session that was opened says of itself."""
        fields: tuple[QLineEdit | QPlainTextEdit, ...] = (self._operator, self._notes, self._sample, self._target)
        for widget, text in zip(fields, (operator, notes, sample, target), strict=True):
            with QSignalBlocker(widget):
                widget.setText(text) if isinstance(widget, QLineEdit) else widget.setPlainText(text)

    def say_at_field(self, error: BaseException) -> None:
        """Say what is wrong with the data folder, where it is that."""
        if isinstance(error, DataFolderError):
            self.folder_fault.say(f"Data folder: {error}")

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
        """Say that a note was kept, and where; the last ones stay in sight."""
        where = f"{entry.run}, sample {entry.index}" if entry.run else "between runs"
        lines = (*self._marked.text().splitlines(), f"{entry.at[11:19]} {entry.text} ({where})")
        self._marked.setText("\n".join(lines[-_MARKS_SHOWN:]))

    def set_running(self, running: bool) -> None:
        """Close or open what must not change while runs are recorded; notes stay open."""
        for widget in (self._folder, *self._buttons):
            widget.setEnabled(not running)
