"""Opens and saves setup files, and keeps edits that were not saved for the next start."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QWidget

from radargui.gui.notices import NoticeBoard
from radargui.gui.settings import Settings
from radargui.gui.setup.setup_model import SetupModel
from radargui.model.errors import RadarGuiError, SetupError
from radargui.model.resources import default_setup_path
from radargui.model.setup_file import dump_setup, parse_setup, read_setup

FILTER = "Setup files (*.toml);;All files (*)"
_FILE, _DRAFT = "setup_file", "setup_draft"


def first_setup(path: Path | None, settings: Settings, board: NoticeBoard) -> SetupModel:
    """Return the setup to begin with: the one asked for, the last one, or the shipped default."""
    remembered = settings.path(_FILE)
    for candidate in (path, remembered):
        if candidate is None:
            continue
        try:
            model = SetupModel(read_setup(candidate), candidate)
        except SetupError as error:
            board.post_error(error)
            continue
        if candidate == remembered and path is None:
            _take_draft(model, settings, board)
        return model
    return SetupModel(read_setup(default_setup_path()), default_setup_path())


def _take_draft(model: SetupModel, settings: Settings, board: NoticeBoard) -> None:
    text = settings.text(_DRAFT)
    if not text:
        return
    try:
        model.replace(parse_setup(text, "the setup edited last"))
    except SetupError as error:
        board.post("warning", f"What was edited last could not be taken over. {error}")


class SetupDesk(QObject):
    """The dialogs around the setup file."""

    def __init__(self, model: SetupModel, settings: Settings, board: NoticeBoard, window: QWidget) -> None:
        super().__init__(window)
        self._model = model
        self._settings = settings
        self._board = board
        self._window = window

    def ask_open(self) -> None:
        """Let the operator choose a setup file."""
        start = str(self._model.path.parent) if self._model.path else ""
        name, _ = QFileDialog.getOpenFileName(self._window, "Open setup", start, FILTER)
        if name:
            self.open(Path(name))

    def open(self, path: Path) -> bool:
        """Read a setup file; what is wrong with it is shown and the setup stays."""
        return self._tried(lambda: self._model.load(path))

    def save(self) -> bool:
        """Save where the setup came from; a shipped file is never written over."""
        if self._model.path is None or self._model.shipped:
            return self.ask_save()
        return self.save_to(self._model.path)

    def ask_save(self) -> bool:
        """Let the operator choose where to save."""
        folder = Path.home() if self._model.path is None or self._model.shipped else self._model.path.parent
        start = folder / (self._model.path.name if self._model.path else "setup.toml")
        name, _ = QFileDialog.getSaveFileName(self._window, "Save setup", str(start), FILTER)
        return bool(name) and self.save_to(Path(name))

    def save_to(self, path: Path) -> bool:
        """Save; comments of the user's file survive."""
        if not self._model.valid:
            self._board.post("error", f"The setup is not saved: {self._model.error}")
            return False
        return self._tried(lambda: self._model.save(path))

    def remember(self) -> None:
        """Keep the file's name, and edits that were not saved."""
        if self._model.path is not None:
            self._settings.put(_FILE, self._model.path)
        if self._model.modified and self._model.valid:
            self._settings.put(_DRAFT, dump_setup(self._model.setup))
        else:
            self._settings.forget(_DRAFT)

    def _tried(self, step: object) -> bool:
        try:
            step()
        except RadarGuiError as error:
            self._board.post_error(error)
            return False
        return True
