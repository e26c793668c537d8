"""The log as it is written: what the log file gets, filtered and searched; and what is copied for a bug report."""

import logging
from collections import deque
from functools import partial
from itertools import count
from pathlib import Path

from PySide6.QtGui import QGuiApplication, QTextCursor
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLineEdit, QPlainTextEdit

from radargui.gui.dialog import Dialog
from radargui.gui.layout import Choice, PlainLabel, button, fill, having, labelled, ticking
from radargui.gui.services import Services
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import even_font
from radargui.session.about import report_text
from radargui.system.resources import LOG_FORMAT, log_path

MAX_ENTRIES = 5000
"""Kept in memory, a megabyte or two: more stands in the file."""
COPIED_ENTRIES = 200
"""Of a bug report: some minutes of a busy program, and no more than a page of a forum takes."""
_LOOK_MS = 250
"""Chosen by hand: seldom enough to write many entries at once, often enough to follow what one does."""
_LEVELS = ((logging.DEBUG, "Everything"), (logging.WARNING, "Warnings and errors"), (logging.ERROR, "Errors only"))


class LogKeeper(logging.Handler):
    """Keeps the last entries of the log, from any thread."""

    def __init__(self) -> None:
        super().__init__()
        self.setFormatter(logging.Formatter(LOG_FORMAT))
        self.entries: deque[tuple[int, int, str]] = deque(maxlen=MAX_ENTRIES)
        self._numbers = count(1)

    def emit(self, record: logging.LogRecord) -> None:
        """Keep an entry with its number and level; called under the handler's lock."""
        try:
            self.entries.append((next(self._numbers), record.levelno, self.format(record)))
        except Exception:  # noqa: BLE001 - an entry that cannot be written must not stop who writes it
            self.handleError(record)


class LogWindow(Dialog):
    """The entries, those of a level, found and followed.

    Parameters
    ----------
    model
        The setup that a bug report holds.
    services
        Where it is computed and said.
    """

    def __init__(self, model: SetupModel, services: Services) -> None:
        super().__init__("Log", (860, 460), services.parent, "log", services.settings)
        self._model, self._services = model, services
        self.keeper = LogKeeper()
        logging.getLogger().addHandler(self.keeper)
        self._shown = 0
        self.level = having(Choice(_LEVELS), toolTip="Which entries are shown; all stand in the file")
        self.level.currentIndexChanged.connect(self.show_anew)
        self.words = having(QLineEdit(placeholderText="find …"), accessibleName="Find in the log")
        self.words.setToolTip("Words to be found in the entries; Enter goes to the next place")
        self.words.returnPressed.connect(self.find_next)
        self.follows = having(QCheckBox("Follow"), checked=True, toolTip="Stay at the newest entry")
        self.said = PlainLabel()
        mode = QPlainTextEdit.LineWrapMode.NoWrap
        self.view = QPlainTextEdit(readOnly=True, maximumBlockCount=MAX_ENTRIES, lineWrapMode=mode)
        self.view.setAccessibleName("Log")
        self.view.setFont(even_font(self.font()))
        self.view.setToolTip(f"What the log file gets since the program was started; older entries: {log_path()}")
        nexts = button("Next", self.find_next, "Go to the next place that has these words")
        above = (labelled("Show", self.level), self.level, (self.words, 1), nexts, self.follows)
        below = (button("Copy for a bug report", self.copy_report), 1, button("Close", self.reject))
        top, ends = (fill(QHBoxLayout(), *parts, spacing=6) for parts in (above, below))
        self.lay_out(top, (self.view, 1), self.said, ends)
        self._timer = ticking(self, _LOOK_MS, self.refresh)
        self.finished.connect(lambda _result: self._timer.stop())

    def come_up(self) -> None:
        """Stand before the other windows, and show what came meanwhile."""
        super().come_up()
        self.refresh()
        self._timer.start()

    def end(self) -> None:
        """Take no more entries."""
        logging.getLogger().removeHandler(self.keeper)

    def refresh(self) -> None:
        """Show what is new."""
        new = [one for one in list(self.keeper.entries) if one[0] > self._shown]
        least: int = self.level.currentData()
        lines = [text for _, level, text in new if level >= least]
        self._shown = new[-1][0] if new else self._shown
        if lines:
            bar = self.view.verticalScrollBar()
            place = bar.value()
            self.view.appendPlainText("\n".join(lines))
            bar.setValue(bar.maximum() if self.follows.isChecked() else place)

    def show_anew(self) -> None:
        """Show all entries of the level chosen."""
        self.view.clear()
        self._shown = 0
        self.refresh()

    def find_next(self) -> None:
        """Go to the next place that has the words, from the top after the last one."""
        words = self.words.text()
        found = not words or self.view.find(words)
        if not found:
            self.view.moveCursor(QTextCursor.MoveOperation.Start)
            found = self.view.find(words)
        if words and found:
            self.follows.setChecked(False)
        self.said.setText("" if found else f"“{words}” stands nowhere in what is shown.")

    def copy_report(self) -> None:
        """Copy what a bug report needs, and say what that is."""
        setup = self._model.setup
        entries = [text for *_, text in list(self.keeper.entries)[-COPIED_ENTRIES:]]
        private = {str(Path.home()): "~", str(self._services.settings.path("data_folder") or ""): "…"}
        work = partial(report_text, setup, entries, private)

        def copied(text: str) -> None:
            QGuiApplication.clipboard().setText(text)
            said = (
                f"Copied for a bug report: versions and system, the last {len(entries)} entries of the log, and the "
                f"setup, {len(text.splitlines())} lines in all. Folders were shortened; read it before you send it."
            )
            self.said.setText(said)
            self._services.board.post("info", said)

        self._services.jobs.start("the facts for a bug report", work, copied)
