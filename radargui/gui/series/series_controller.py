"""What the series panel shows: read in the background when runs come, while it is seen."""

from pathlib import Path

from PySide6.QtCore import QObject

from radargui.gui.control.run_control import RunControl
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.series.series_panel import SeriesPanel
from radargui.gui.services import Services
from radargui.report.facts import ReportFacts, report_facts
from radargui.report.glances import Glances
from radargui.session.session import Session


class SeriesController(QObject):
    """Joins the panel with the session that is open and those that it is compared with."""

    def __init__(
        self, control: RunControl, runs: RunListPanel, panel: SeriesPanel, glances: Glances, services: Services
    ) -> None:
        super().__init__(services.parent)
        self._control, self._panel, self._glances, self._services = control, panel, glances, services
        self._others: tuple[Path, ...] = ()
        self._is_reading = self._is_outdated = False
        panel.seen.connect(self.refresh)
        panel.alone.clicked.connect(lambda: self.compare(()))
        for changed in (runs.model.rowsInserted, runs.model.dataChanged, runs.model.modelReset):
            changed.connect(lambda *_: self.refresh())

    def compare(self, sessions: tuple[Path, ...]) -> None:
        """Show these sessions beside the one that is open; none: that one alone."""
        self._others = sessions
        self.refresh()

    def refresh(self) -> None:
        """Read what has changed, where the panel is seen; what comes meanwhile is read afterwards."""
        self._is_outdated = self._is_reading
        if self._is_reading or not self._panel.isVisible():
            return
        own, glances = self._control.session, self._glances
        others = [path for path in self._others if own is None or path != own.path]

        def work() -> ReportFacts | None:
            sessions = [*([own] if own else []), *(Session.open(path, write=False) for path in others)]
            return report_facts([glances.session_facts(one) for one in sessions], "") if sessions else None

        self._is_reading = True
        self._services.jobs.start("the series", work, self._read, self._failed)

    def _read(self, facts: ReportFacts | None) -> None:
        self._is_reading = False
        if self._is_outdated:
            self.refresh()
        else:
            self._panel.show_facts(facts)

    def _failed(self, error: BaseException) -> None:
        self._is_reading, self._others = False, ()
        self._services.board.post_error(error)
