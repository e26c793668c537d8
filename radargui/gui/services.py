"""What every controller may use."""

from dataclasses import dataclass

from PySide6.QtWidgets import QWidget

from radargui.gui.background import Jobs, WorkStrip
from radargui.gui.notices import NoticeBoard
from radargui.gui.settings import Settings
from radargui.gui.theme import Theme


@dataclass(frozen=True, slots=True)
class Services:
    """Look, memory, messages, background work, and the widget that dialogs belong to."""

    theme: Theme
    settings: Settings
    board: NoticeBoard
    jobs: Jobs
    work: WorkStrip
    parent: QWidget
