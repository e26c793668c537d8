"""Opens and saves setup files, and keeps edits that were not saved for the next start."""

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QFileDialog, QMessageBox

from radargui.gui.menus import Actions
from radargui.gui.notices import NoticeBoard
from radargui.gui.services import Services
from radargui.gui.settings import Settings
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import called
from radargui.model.errors import RadarGuiError, SetupError
from radargui.model.resources import default_setup_path
from radargui.model.setup import Setup
from radargui.model.setup_file import dump_setup, parse_setup, read_setup

FILTER = "Setup files (*.toml);;All files (*)"
_FILE, _DRAFT = "setup_file", "setup_draft"
_MOST_NAMED = 4


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


class SetupFileController(QObject):
    """The dialogs around the setup file."""

    def __init__(self, model: SetupModel, does: Actions, services: Services) -> None:
        super().__init__(services.parent)
        self._model, self._window = model, services.parent
        self._settings, self._board = services.settings, services.board
        does.open_setup.triggered.connect(self.ask_open)
        does.undo_setup.triggered.connect(lambda: model.undo())
        does.save_setup.triggered.connect(self.save)
        does.save_setup_as.triggered.connect(self.ask_save)

    def may_discard(self) -> bool:
        """Ask before edits are lost that stand in no file; saving them first is an answer too."""
        changed = self._model.unsaved
        if not changed:
            return True
        named = ", ".join(map(called, changed[:_MOST_NAMED])) + (" …" if len(changed) > _MOST_NAMED else "")
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self._window,
            "RadarGUI",
            f"Changes of the setup are not saved: {named}. Without saving they are lost.",
            button.Save | button.Discard | button.Cancel,
            button.Cancel,
        )
        return answer == button.Discard or (answer == button.Save and self.save())

    def take(self, setup: Setup) -> bool:
        """Take over the setup of a session, unless the operator wants to keep what he edited."""
        if not self.may_discard():
            return False
        self._model.take(setup)
        return True

    def ask_open(self) -> None:
        """Let the operator choose a setup file."""
        if not self.may_discard():
            return
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
        if self._model.valid and (self._model.modified or self._model.path is None):
            self._settings.put(_DRAFT, dump_setup(self._model.setup))
        else:
            self._settings.forget(_DRAFT)

    def _tried(self, step: Callable[[], None]) -> bool:
        try:
            step()
        except RadarGuiError as error:
            self._board.post_error(error)
            return False
        return True
