"""The setup being edited: a draft that may be wrong for a moment, and the last setup that was right."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError
from PySide6.QtCore import QObject, Signal

from radargui.model.resources import shipped_setups
from radargui.model.setup import Setup
from radargui.model.setup_error import describe, dotted
from radargui.model.setup_file import plain, read_setup, write_setup

MOST_RECEIVERS = 4


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
        self.faulty: frozenset[str] = frozenset()
        self._draft: dict[str, Any] = plain(setup)
        self._saved = setup

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
        """Return what the draft says, else the value in force, None where there is none (or no such receiver)."""
        number = next((part for part in _parts(key) if isinstance(part, int)), 0)
        if number >= self.n_receivers:
            return None
        table, name = self._table(key)
        if name in table:
            return table[name]
        current: Any = self.setup
        for part in _parts(key):
            current = _step(current, part)
        return current

    def assign(self, key: str, value: object) -> None:
        """Set a value of the draft; None takes the key out, so that the default holds."""
        table, name = self._table(key)
        if value is None:
            table.pop(name, None)
        else:
            table[name] = value
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

    def _table(self, key: str) -> tuple[dict[str, Any], str]:
        *way, name = _parts(key)
        table: Any = self._draft
        for part in way:
            table = table[part] if isinstance(part, int) else table.setdefault(part, {})
        return table, str(name)

    def _validate(self) -> None:
        try:
            self.setup = Setup.model_validate(self._draft)
            self.error, self.faulty = "", frozenset()
        except ValidationError as fault:
            self.error = describe(fault, Setup)
            self.faulty = frozenset(dotted(_named(one["loc"])) for one in fault.errors(include_url=False))
        self.changed.emit()


def _named(loc: tuple[int | str, ...]) -> tuple[int | str, ...]:
    """Keep the parts of a place up to the key that a form shows."""
    keep = 3 if loc and loc[0] == "receiver" else 2
    return loc[:keep]


def _parts(key: str) -> list[str | int]:
    """Split `receiver[2].tilt_deg` into receiver, 1, tilt_deg."""
    parts: list[str | int] = []
    for piece in key.split("."):
        name, _, index = piece.partition("[")
        parts.append(name)
        if index:
            parts.append(int(index.rstrip("]")) - 1)
    return parts


def _step(current: Any, part: str | int) -> Any:
    if isinstance(part, int):
        return current[part] if part < len(current) else None
    return getattr(current, part, None)
