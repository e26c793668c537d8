"""The setup being edited: a draft that may be wrong for a moment, and the last setup that was right."""

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from PySide6.QtCore import QObject, Signal

from radargui.gui.setup.words import faults_of
from radargui.model.radar import Radar
from radargui.model.resources import shipped_setups
from radargui.model.setup import Setup
from radargui.model.setup_file import plain, read_setup, write_setup

MOST_RECEIVERS = 4
_TABLES = {name: info.default for name, info in Setup.model_fields.items()} | {"radar": Radar()}
_DEFAULTS = {name: table.model_dump() for name, table in _TABLES.items() if isinstance(table, BaseModel)}
"""What holds where the draft says nothing; of antennas nothing does."""


class SetupModel(QObject):
    """Keeps the draft, validates it at each change, reads and writes the setup file.

    Keys are dotted as in error messages, receivers counted from 1: `receiver[2].tilt_deg`.
    """

    changed = Signal()

    def __init__(self, setup: Setup, path: Path | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.path = path
        self.setup = setup
        self.error = ""
        self._faults: dict[str, str] = {}
        self._draft: dict[str, Any] = plain(setup)
        self._saved = setup
        self._of_last_run: Setup | None = None

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
        if self._of_last_run is None or not self.valid:
            return {}
        before, now = _flat(self._of_last_run.model_dump()), _flat(self.setup.model_dump())
        return {key: before.get(key) for key in (before | now) if before.get(key) != now.get(key)}

    @property
    def unsaved(self) -> tuple[str, ...]:
        """Keys whose values are not those of the file."""
        before, now = _flat(plain(self._saved)), _flat(self._draft)
        return tuple(key for key in (before | now) if before.get(key) != now.get(key))

    def fault_of(self, key: str) -> str:
        """Return what is wrong with a value, in the words and the unit of its field; empty where nothing is."""
        # a fault of a list is one of each of its entries, and that of an entry one of the list
        texts = (text for one, text in self._faults.items() if key == one or _is_entry(key, one) or _is_entry(one, key))
        return next(texts, "")

    def saved_value(self, key: str) -> Any:
        """Return what the file says, None where it has no such value."""
        return _found(self._saved.model_dump(), key)

    def differs(self, key: str) -> bool:
        """Return whether a value is not the file's; those of a receiver that the file does not have are no change."""
        if _receiver(key) >= min(self.n_receivers, self._saved.n_receivers):
            return False
        return _flat(self.value(key)) != _flat(self.saved_value(key))

    def undo(self, key: str = "") -> None:
        """Take back what was changed since the file was read or saved; without a key everything."""
        if not key:
            self.replace(self._saved)
            return
        table: Any = plain(self._saved)
        for part in _parts(key):
            table = table[part] if isinstance(part, int) else table.get(part, {})
        self.assign(key, None if table == {} else table)

    def take(self, setup: Setup) -> None:
        """Begin with a setup that belongs to no file."""
        self.path, self._saved = None, setup
        self.replace(setup)

    def load(self, path: Path) -> None:
        """Read a setup file.

        Raises
        ------
        SetupError
            The file cannot be used; the draft stays as it was.
        """
        setup = read_setup(path)
        self.path = path
        self._saved = setup
        self.replace(setup)

    def save(self, path: Path) -> None:
        """Write the setup; comments of a file that is there survive.

        Raises
        ------
        SetupError
            The file cannot be written.
        """
        write_setup(self.setup, path)
        self.path = path
        self._saved = self.setup
        self.changed.emit()

    def replace(self, setup: Setup) -> None:
        """Take over a whole setup."""
        self._draft = plain(setup)
        self._validate()

    def value(self, key: str) -> Any:
        """Return what the draft says, else the default, None where there is none (or no such receiver)."""
        if _receiver(key) >= self.n_receivers:
            return None
        drafted = _found(self._draft, key)
        return drafted if drafted is not None else _found(_DEFAULTS, key)

    def assign(self, key: str, value: object) -> None:
        """Set a value of the draft; None takes the key out, so that the default holds."""
        *way, name = _parts(key)
        table: Any = self._draft
        for number, part in enumerate(way):
            if not isinstance(part, int) and part not in table:
                whole = ".".join(str(one) for one in way)
                table[part] = list(self.value(whole)) if isinstance(name, int) and number + 1 == len(way) else {}
            table = table[part]
        if value is not None:
            table[name] = value
        elif isinstance(table, dict):
            table.pop(name, None)
        self._validate()

    def add_receiver(self) -> None:
        """Add a receiver that continues the ring of those there."""
        receivers = self._draft["receiver"]
        if len(receivers) >= MOST_RECEIVERS:
            return
        last = receivers[-1]
        azimuth = last.get("azimuth_deg", 0.0)
        turned = (azimuth + 90.0) % 360.0 if isinstance(azimuth, (int, float)) else 0.0
        receivers.append({**last, "azimuth_deg": turned})
        self._receivers_changed()

    def remove_receiver(self, number: int) -> None:
        """Take receiver `number` (from 1) out; the last one stays."""
        receivers = self._draft["receiver"]
        if len(receivers) > 1:
            del receivers[number - 1]
            self._receivers_changed(number)

    def _receivers_changed(self, removed: int | None = None) -> None:
        channels = self._draft.get("daq", {}).get("channels")
        if isinstance(channels, list):
            if removed is not None:
                del channels[2 * removed - 2 : 2 * removed]
            while len(channels) < 2 * len(self._draft["receiver"]):
                free = (f"ai{number}" for number in range(64) if f"ai{number}" not in channels)
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
    return next((part for part in _parts(key) if isinstance(part, int)), 0) if key.startswith("receiver") else 0


def _parts(key: str) -> list[str | int]:
    """Split `receiver[2].tilt_deg` into receiver, 1, tilt_deg."""
    parts: list[str | int] = []
    for piece in key.split("."):
        name, _, index = piece.partition("[")
        parts.append(name)
        if index:
            parts.append(int(index.rstrip("]")) - 1)
    return parts


def _found(tables: Any, key: str) -> Any:
    """Return what stands at a key below plain tables, None where nothing does."""
    try:
        for part in _parts(key):
            tables = tables[part]
    except (KeyError, IndexError, TypeError):
        return None
    return tables


def _flat(value: Any, name: str = "") -> dict[str, Any]:
    """Return every single value below a table by its dotted name, lists counted from 1."""
    if isinstance(value, dict):
        parts = [(f"{name}.{key}".lstrip("."), one) for key, one in value.items()]
    elif isinstance(value, (list, tuple)):
        parts = [(f"{name}[{number}]", one) for number, one in enumerate(value, start=1)]
    else:
        return {name: value}
    return {key: one for part, below in parts for key, one in _flat(below, part).items()}
