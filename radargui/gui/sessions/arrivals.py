"""What comes from outside: files and folders dropped onto the window, and those that were opened before."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QMenu

from radargui.gui.services import Services
from radargui.gui.sessions.session_controller import SessionController
from radargui.gui.sessions.transfer_controller import TransferController
from radargui.session.info import FILE_NAME

_MOST = 8
"""Sessions and setups that the menu remembers (chosen by hand): more are found by search."""
_KEPT = "recent"


class Arrivals(QObject):
    """Opens what is dropped: a session, a setup, a folder of recordings or recordings, which are imported."""

    def __init__(self, sessions: SessionController, transfer: TransferController, services: Services) -> None:
        super().__init__(services.parent)
        self._sessions, self._transfer, self._services = sessions, transfer, services
        self._model, self._menu = sessions.setup_file.model, QMenu()
        services.parent.setAcceptDrops(True)
        services.parent.installEventFilter(self)
        services.control.session_changed.connect(self._note_session)
        self._model.changed.connect(lambda: self.note(self._model.own_path))

    def fill(self, menu: QMenu) -> None:
        """Add the menu of what was opened before."""
        self._menu = menu.addMenu("Open recent")
        self._show()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Take what is dropped."""
        if isinstance(event, QDropEvent) and event.type() in (QEvent.Type.DragEnter, QEvent.Type.Drop):
            paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
            if paths:
                event.acceptProposedAction()
                if event.type() == QEvent.Type.Drop:
                    self.open(paths)
            return bool(paths)
        return super().eventFilter(watched, event)

    def open(self, paths: Sequence[Path]) -> None:
        """Open a session or a setup; everything else is imported, of a folder what is in it."""
        first = paths[0].parent if paths[0].name == FILE_NAME else paths[0]
        if (first / FILE_NAME).is_file():
            self._sessions.open(first)
        elif first.suffix == ".toml":
            if self._services.control.state.running:
                self._services.board.post("warning", "Stop before another setup is opened.")
            elif self._sessions.setup_file.may_discard():
                self._sessions.setup_file.open(first)
        else:
            inside = (sorted(one.iterdir()) if one.is_dir() else [one] for one in paths)
            self._transfer.ask_import(tuple(one for files in inside for one in files if one.is_file()))

    def note(self, path: Path | None) -> None:
        """Remember what was opened."""
        known = self._known
        if path is not None and str(path) not in known[:1]:
            kept = dict.fromkeys((str(path), *known))
            self._services.settings.put(_KEPT, "\n".join(list(kept)[:_MOST]))
            self._show()

    @property
    def _known(self) -> list[str]:
        return self._services.settings.text(_KEPT).splitlines()

    def _note_session(self) -> None:
        session = self._services.control.session
        self.note(session.path if session else None)

    def _show(self) -> None:
        self._menu.clear()
        for number, text in enumerate(self._known, 1):
            path = Path(text)
            self._menu.addAction(f"&{number} {path.name} ({path.parent.name})", partial(self.open, [path]))
        self._menu.menuAction().setVisible(bool(self._menu.actions()))
