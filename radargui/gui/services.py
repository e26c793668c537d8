"""What every controller may use, and the edits that are taken back by Ctrl+Z and done again by Ctrl+Shift+Z."""

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtGui import QUndoCommand, QUndoStack
from PySide6.QtWidgets import QWidget

from radargui.gui.background import Jobs, WorkStrip
from radargui.gui.control.run_control import RunControl
from radargui.gui.notices import NoticeBoard
from radargui.gui.settings import Settings
from radargui.gui.theme import Theme
from radargui.report.facts import Glances

Does = Callable[[], object]


class _Edit(QUndoCommand):
    """An edit that is done already when it is noted."""

    def __init__(self, words: str, back: Does, again: Does, key: str) -> None:
        super().__init__(words)
        self.back, self.again, self.key = back, again, key
        self._done = True

    def id(self) -> int:
        """Return a number that lets steps be joined: only those of one value are."""
        return hash(self.key) % (1 << 31) if self.key else -1

    def mergeWith(self, other: QUndoCommand) -> bool:  # noqa: N802 - Qt's name
        """Join the next step of the same value: what is typed in one go is one edit."""
        joined = isinstance(other, _Edit) and other.key == self.key
        if joined and isinstance(other, _Edit):
            self.again = other.again
        return joined

    def undo(self) -> None:
        """Take the edit back."""
        self.back()

    def redo(self) -> None:
        """Do it again; at first there is nothing to do."""
        if not self._done:
            self.again()
        self._done = False


class EditHistory(QUndoStack):
    """The edits of the window in their order; what they change while they are taken back is no new edit."""

    def __init__(self) -> None:
        super().__init__()
        self._replays = False
        self._sealed = 0

    def note(self, words: str, back: Does, again: Does, value: str = "") -> None:
        """Keep an edit that was just done.

        Parameters
        ----------
        words
            What was edited.
        back, again
            Take it back, and do it again.
        value
            What it is of, where further ones of the same value belong to it until `seal`; empty: it stands alone.
        """
        if not self._replays:
            self.push(_Edit(words, self._replaying(back), self._replaying(again), value and f"{value} {self._sealed}"))

    def seal(self) -> None:
        """Let what is edited from now on be a step of its own."""
        self._sealed += 1

    def _replaying(self, does: Does) -> Does:
        def replay() -> None:
            self._replays = True
            try:
                does()
            finally:
                self._replays = False
                self.seal()

        return replay


@dataclass(frozen=True, slots=True)
class Services:
    """Look, memory, messages, work, what runs, what was read for reports, what was edited, whom dialogs belong to."""

    theme: Theme
    settings: Settings
    board: NoticeBoard
    jobs: Jobs
    work: WorkStrip
    control: RunControl
    glances: Glances
    history: EditHistory
    parent: QWidget
