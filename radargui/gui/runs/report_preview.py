"""The report's first page in a window of its own, which follows the runs as they come in."""

from dataclasses import replace

from PySide6.QtWidgets import QTextBrowser

from radargui.gui.layout import Dialog
from radargui.gui.runs.figures_view import SHEET
from radargui.gui.services import Services
from radargui.report.document import templates
from radargui.report.glances import Glances
from radargui.session.session import Session


class ReportPreview(Dialog):
    """Reads what the results say, in a thread, and only while it is seen; a run is read again when its file changes."""

    def __init__(self, glances: Glances, services: Services) -> None:
        super().__init__("Preview of the report", (760, 820), services.parent, "report_preview")
        self._services, self._glances = services, glances
        self._session: Session | None = None
        self._is_reading = self._is_outdated = False
        self.page = QTextBrowser()
        self.page.setOpenLinks(False)
        self.lay_out((self.page, 1))
        services.theme.changed.connect(self.refresh)

    def show_session(self, session: Session | None) -> None:
        """Follow a session."""
        self._session = session
        if session is None:
            self.page.setPlainText("No session is open.")
        self.refresh()

    def refresh(self) -> None:
        """Read what has changed, where the page is seen."""
        session = self._session
        self._is_outdated = self._is_reading
        if session is None or not self.isVisible() or self._is_reading:
            return
        self._is_reading, glances, alarm = True, self._glances, self._services.theme.colours.alarm
        self._services.jobs.start(
            "the preview of the report", lambda: _page_of(session, glances, alarm), self._read, self._failed
        )

    def _read(self, page: str) -> None:
        self._is_reading = False
        if self._is_outdated:
            self.refresh()
            return
        bar = self.page.verticalScrollBar()
        place = bar.value()
        self.page.setHtml(page)
        bar.setValue(place)

    def _failed(self, error: BaseException) -> None:
        self._is_reading = False
        self.page.setPlainText(str(error))


def _page_of(session: Session, glances: Glances, alarm: str) -> str:
    """Return the page; in the thread of the work, where matplotlib may take its time."""
    from radargui.report.facts import report_facts
    from radargui.report.findings_section import findings_blocks, runs_table
    from radargui.report.rendering import pixels_of
    from radargui.report.report import labels_of

    labels, found = labels_of(session), glances.session_facts(session)
    runs = tuple(replace(facts, label=labels[facts.name]) for facts in found.runs)
    facts = report_facts([replace(found, runs=runs)], "")
    blocks = list(findings_blocks(facts))
    if runs:
        blocks.append(runs_table(facts.findings.sessions[0], runs))
    page = templates().get_template("blocks.html").render(blocks=blocks, picture_of=pixels_of)
    return SHEET.format(alarm=alarm) + page
