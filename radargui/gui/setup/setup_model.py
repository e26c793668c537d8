"""The setup that is edited: a draft that may be wrong for a moment, the last one that was right, and its file."""

from collections.abc import Callable, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import BaseModel, ValidationError
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog, QMessageBox

from radargui.gui.notices import Notice, NoticeBoard
from radargui.gui.services import Services
from radargui.gui.settings import Settings
from radargui.gui.setup_words import called, entries_of, faults_of, parts_of
from radargui.model.errors import RadarGuiError, SetupError
from radargui.model.radar import MAX_RECEIVERS, Radar
from radargui.model.setup import Setup, dump_setup, parse_setup, plain, read_setup, write_setup
from radargui.model.setup_error import ChangedSetting, changed_settings, flattened
from radargui.model.words import counted
from radargui.system.resources import default_setup_path, shipped_setups

_TABLES = {name: info.default for name, info in Setup.model_fields.items()} | {"radar": Radar()}
_DEFAULTS = {name: table.model_dump() for name, table in _TABLES.items() if isinstance(table, BaseModel)}
"""What holds where the draft says nothing; of antennas nothing does."""


_State: TypeAlias = tuple[Path | None, Setup, dict[str, Any]]


class SetupModel(QObject):
    """Keeps the draft, validates it at each change, reads and writes the setup file.

    Keys are dotted as in error messages, receivers counted from 1: `receiver[2].tilt_deg`. While a session is reviewed
    its setup stands in place of the operator's own one, which comes back as it was left.

    Attributes
    ----------
    reviewed
        Name of the session whose setup is shown; empty: the operator's own is.
    """

    changed = Signal()
    edited = Signal(str, object, object)
    """What the operator has edited of his own setup (a key; empty: more than one value), with what takes it back and
    what does it again."""

    def __init__(self, setup: Setup, path: Path | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.path = path
        self.setup = setup
        self.error = ""
        self._faults: dict[str, str] = {}
        self._draft: dict[str, Any] = plain(setup)
        self._saved, self._of_file = setup, setup.model_dump()
        self._of_last_run: Setup | None = None
        self.reviewed = ""
        self._own: tuple[Path | None, Setup, Setup, dict[str, Any]] | None = None

    def review(self, setup: Setup, name: str) -> None:
        """Show the setup of a session, which is not edited; where it is the operator's own nothing changes."""
        self.end_review()
        if setup != self.setup:
            self._own, self.reviewed = (self.path, self._saved, self.setup, self._draft), name
            self._begin(None, setup, plain(setup))

    def end_review(self) -> None:
        """Show the operator's own setup again, as it was left."""
        if self._own is not None:
            (path, saved, _, draft), self._own, self.reviewed = self._own, None, ""
            self._begin(path, saved, draft)

    @property
    def own_setup(self) -> Setup:
        """The operator's own setup, also while that of a session is shown."""
        return self.setup if self._own is None else self._own[2]

    @property
    def own_path(self) -> Path | None:
        """The file of the operator's own setup."""
        return self.path if self._own is None else self._own[0]

    @property
    def valid(self) -> bool:
        """Whether the draft is a setup that can be used."""
        return not self.error

    @property
    def modified(self) -> bool:
        """Whether the draft differs from what the file says."""
        return bool(self.error) or self.setup != self._saved

    @property
    def n_receivers(self) -> int:
        """Number of receivers of the draft."""
        return len(self._draft["receiver"])

    @property
    def shipped(self) -> bool:
        """Whether the file is one that came with the program, not to be written over."""
        return self.path is not None and self.path.resolve() in {path.resolve() for path in shipped_setups()}

    def note_run(self) -> None:
        """Remember the setup as that of a run, for `since_last_run`."""
        self._of_last_run = self.setup
        self.changed.emit()

    @property
    def since_last_run(self) -> dict[str, Any]:
        """Keys whose values are others now than at the last run, with those of then; empty before the first run."""
        if self._of_last_run is None or not self.valid or self.reviewed:
            return {}
        return {one.key: one.before for one in changed_settings(self._of_last_run, self.setup)}

    @property
    def unsaved(self) -> tuple[str, ...]:
        """Keys whose values are not those of the file, of the operator's own setup."""
        saved, draft = (self._saved, self._draft) if self._own is None else (self._own[1], self._own[3])
        before, now = (dict(flattened(one, every=True)) for one in (plain(saved), draft))
        # of a calibration its file is named, not each covariance
        keys = (key for key in before | now if not key.startswith("calibration.content"))
        return tuple(key for key in keys if before.get(key) != now.get(key))

    def fault_of(self, key: str) -> str:
        """Return what is wrong with a value, in the words and the unit of its field; empty where nothing is."""
        # a fault of a list is one of each of its entries, and that of an entry one of the list
        texts = (text for one, text in self._faults.items() if key == one or _is_entry(key, one) or _is_entry(one, key))
        return next(texts, "")

    def saved_value(self, key: str) -> Any:
        """Return what the file says, None where it has no such value."""
        return _found(self._of_file, key)

    def differs(self, key: str) -> bool:
        """Return whether a value is not the file's; those of a receiver that the file does not have are no change."""
        if _receiver(key) >= min(self.n_receivers, self._saved.n_receivers):
            return False
        own, saved = (dict(flattened(one, every=True)) for one in (self.value(key), self.saved_value(key)))
        return own != saved

    def differences(self, other: Setup) -> tuple[ChangedSetting, ...]:
        """Return what another setup has otherwise than the operator's own one."""
        return changed_settings(other, self.own_setup)

    def undo(self, key: str) -> None:
        """Take back a value that was changed since the file was read or saved."""
        self.assign(key, _found(plain(self._saved), key))

    def undo_all(self) -> None:
        """Take back all that was changed since the file was read or saved."""
        self.replace(self._saved)

    def take(self, setup: Setup, path: Path | None = None) -> None:
        """Begin with a setup; without a path it belongs to no file."""
        self.end_review()
        before = self._state
        self._begin(path, setup, plain(setup))
        self._announce(before)

    def _begin(self, path: Path | None, saved: Setup, draft: dict[str, Any]) -> None:
        self.path, self._saved, self._of_file, self._draft = path, saved, saved.model_dump(), draft
        self._validate()

    @property
    def _state(self) -> _State:
        """The draft and its file, to come back to."""
        return self.path, self._saved, deepcopy(self._draft)

    def _announce(self, before: _State, key: str = "") -> None:
        """Say that something was edited since, where it was; with the file that it was edited in."""
        after = self._state
        if after == before:
            return

        def go_to(state: _State) -> None:
            self.end_review()
            # where no other file was opened, what was saved meanwhile is saved
            path, saved = self._state[:2] if before[0] == after[0] else state[:2]
            self._begin(path, saved, deepcopy(state[2]))

        self.edited.emit(key, lambda: go_to(before), lambda: go_to(after))

    def save(self, path: Path) -> None:
        """Write the setup; comments of a file that is there survive, else those of the file it came from.

        Raises
        ------
        SetupError
            The file cannot be written.
        """
        write_setup(self.setup, path, self.path)
        self._own, self.reviewed = None, ""
        self._begin(path, self.setup, plain(self.setup))

    def replace(self, setup: Setup) -> None:
        """Take over a whole setup."""
        self.end_review()
        before = self._state
        self._draft = plain(setup)
        self._validate()
        self._announce(before)

    def value(self, key: str) -> Any:
        """Return what the draft says, else the default, None where there is none (or no such receiver)."""
        if _receiver(key) >= self.n_receivers:
            return None
        drafted = _found(self._draft, key)
        return drafted if drafted is not None else _found(_DEFAULTS, key)

    def assign(self, key: str, value: object) -> None:
        """Set a value of the operator's own draft; None takes the key out, so that the default holds."""
        self.end_review()
        before = self._state
        self._put(key, value)
        self._validate()
        self._announce(before, key)

    def _put(self, key: str, value: object) -> None:
        *way, name = parts_of(key)
        table: Any = self._draft
        for number, part in enumerate(way):
            if not isinstance(part, int) and part not in table:
                whole = ".".join(str(one) for one in way)
                is_place = isinstance(name, int) and number + 1 == len(way)
                # of one that nobody has given yet each number is missing
                table[part] = list(self.value(whole) or [""] * entries_of(whole)) if is_place else {}
            table = table[part]
        if value is not None:
            table[name] = value
        elif isinstance(table, list) and isinstance(name, int):
            table[name] = ""
            if not any(table):
                self._put(".".join(str(one) for one in way), None)
        elif isinstance(table, dict):
            table.pop(name, None)

    def add_receiver(self) -> None:
        """Add a receiver that continues the ring of those there."""
        before, receivers = self._state, self._draft["receiver"]
        if len(receivers) < MAX_RECEIVERS:
            azimuth = receivers[-1].get("azimuth_deg", 0.0)
            turned = (azimuth + 90.0) % 360.0 if isinstance(azimuth, (int, float)) else 0.0
            receivers.append({**receivers[-1], "azimuth_deg": turned})
            self._receivers_changed()
            self._announce(before)

    def remove_receiver(self, number: int) -> None:
        """Take receiver `number` (from 1) out; the last one stays."""
        before, receivers = self._state, self._draft["receiver"]
        if len(receivers) > 1:
            del receivers[number - 1]
            self._receivers_changed(number)
            self._announce(before)

    def _receivers_changed(self, removed: int | None = None) -> None:
        channels = self._draft.get("daq", {}).get("channels")
        if isinstance(channels, list):
            if removed is not None:
                del channels[2 * removed - 2 : 2 * removed]
            free = (f"ai{number}" for number in range(64) if f"ai{number}" not in channels)
            while len(channels) < 2 * len(self._draft["receiver"]):
                channels.append(next(free))
        self._validate()

    def _validate(self) -> None:
        try:
            self.setup = Setup.model_validate(self._draft)
            self.error, self._faults = "", {}
        except ValidationError as error:
            self._faults, self.error = faults_of(error)
        self.changed.emit()


def _is_entry(key: str, of: str) -> bool:
    return key.endswith("]") and key.rpartition("[")[0] == of


def _receiver(key: str) -> int:
    """Return the index of the receiver that a key belongs to, 0 for other keys."""
    return next((part for part in parts_of(key) if isinstance(part, int)), 0) if key.startswith("receiver") else 0


def _found(tables: Any, key: str) -> Any:
    """Return what stands at a key below plain tables, None where nothing does."""
    try:
        for part in parts_of(key):
            tables = tables[part]
    except (KeyError, IndexError, TypeError):
        return None
    return tables


FILTER = "Setup files (*.toml);;All files (*)"
_FILE, _DRAFT = "setup_file", "setup_draft"
MAX_NAMED = 4
"""Keys in a sentence (chosen by hand): more are not read, and an ellipsis says that there are some."""


def first_setup(path: Path | None, settings: Settings, board: NoticeBoard) -> SetupModel:
    """Return the setup to begin with: the one asked for, the last one, or the shipped default."""
    remembered = settings.path(_FILE)
    for candidate in filter(None, (path, remembered)):
        try:
            model = SetupModel(read_setup(candidate), candidate)
        except SetupError as error:
            board.post_error(error)
            continue
        if path is None and (text := settings.text(_DRAFT)):
            try:
                model.replace(parse_setup(text, "the setup edited last"))
            except SetupError as error:
                board.post_of_setup("warning", f"What was edited last could not be taken over. {error}")
        if changed := model.unsaved:
            many = f"{counted(len(changed), 'value')} changed since {candidate.name} was saved"
            _notify_while_unsaved(
                model, Notice("warning", f"The setup is as you left it: {many} ({named(changed)})."), board
            )
        return model
    return SetupModel(read_setup(default_setup_path()), default_setup_path())


def _notify_while_unsaved(model: SetupModel, notice: Notice, board: NoticeBoard) -> None:
    board.post(notice.level, notice.text)
    model.changed.connect(lambda: None if model.unsaved else board.dismiss(notice))


def named(keys: Sequence[str]) -> str:
    """Return what values are called, the first ones of many."""
    return ", ".join(map(called, keys[:MAX_NAMED])) + (" …" if len(keys) > MAX_NAMED else "")


def tried(step: Callable[[], None], say: Callable[[RadarGuiError], object]) -> bool:
    """Return whether a step could be done; what is wrong is said."""
    try:
        step()
    except RadarGuiError as error:
        say(error)
        return False
    return True


class SetupFileController:
    """The dialogs around the setup file."""

    def __init__(self, model: SetupModel, services: Services) -> None:
        self.model, self._services = model, services

    def may_discard(self) -> bool:
        """Ask before edits are lost that stand in no file; saving them first is an answer too."""
        changed = self.model.unsaved
        if not changed:
            return True
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self._services.parent,
            "RadarGUI",
            f"Changes of the setup are not saved: {named(changed)}. Without saving they are lost.",
            button.Save | button.Discard | button.Cancel,
            button.Cancel,
        )
        if answer == button.Save:
            self.model.end_review()
            return self.save()
        return answer == button.Discard

    def ask_open(self) -> None:
        """Let the operator choose a setup file."""
        if not self.may_discard():
            return
        start = str(self.model.path.parent) if self.model.path else ""
        name, _ = QFileDialog.getOpenFileName(self._services.parent, "Open setup", start, FILTER)
        if name:
            self.open(Path(name))

    def take_over(self) -> None:
        """Make the setup of the session that is reviewed the operator's own, which is asked for where it was edited."""
        setup = self.model.setup
        if self.model.reviewed and self.may_discard():
            self.model.take(setup)

    def open(self, path: Path) -> bool:
        """Read a setup file; what is wrong with it is shown and the setup stays."""
        return tried(lambda: self.model.take(read_setup(path), path), self._services.board.post_error)

    def save(self) -> bool:
        """Save where the setup came from; a shipped file is never written over."""
        if self.model.path is None or self.model.shipped:
            return self.ask_save()
        return self.save_to(self.model.path)

    def ask_save(self) -> bool:
        """Let the operator choose where to save."""
        folder = Path.home() if self.model.path is None or self.model.shipped else self.model.path.parent
        start = folder / (self.model.path.name if self.model.path else "setup.toml")
        name, _ = QFileDialog.getSaveFileName(self._services.parent, "Save setup", str(start), FILTER)
        return bool(name) and self.save_to(Path(name))

    def save_to(self, path: Path) -> bool:
        """Save; comments of the user's file survive."""
        if not self.model.valid:
            self._services.board.post("error", f"The setup is not saved: {self.model.error}")
            return False
        return tried(lambda: self.model.save(path), self._services.board.post_error)

    def remember(self) -> None:
        """Keep the file's name, and edits that were not saved."""
        settings, model = self._services.settings, self.model
        model.end_review()
        if model.path is not None:
            settings.put(_FILE, model.path)
        if model.valid and (model.modified or model.path is None):
            settings.put(_DRAFT, dump_setup(model.setup))
        else:
            settings.forget(_DRAFT)
