"""What every controller may use."""

from dataclasses import dataclass

from PySide6.QtWidgets import QWidget

from radargui.gui.background import Jobs, WorkStrip
from radargui.gui.control.run_control import RunControl
from radargui.gui.history import EditHistory
from radargui.gui.notices import NoticeBoard
from radargui.gui.settings import Settings
from radargui.gui.theme import Theme
from radargui.report.facts import Glances


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
