"""The report's first page in a window of its own, which follows the runs as they come in."""

from dataclasses import replace
from pathlib import Path

from PySide6.QtWidgets import QTextBrowser

from radargui.gui.layout import Dialog
from radargui.gui.runs.figures_view import SHEET
from radargui.gui.services import Services
from radargui.report.document import templates
from radargui.report.run_facts import RunFacts, glance
from radargui.session.session import Session

_Known = dict[Path, tuple[int, RunFacts]]


class ReportPreview(Dialog):
    """Reads what the results say, in a thread, and only while it is seen; a run is read again when its file changes."""

    def __init__(self, services: Services) -> None:
        super().__init__("Preview of the report", (760, 820), services.parent, "report_preview")
        self._services = services
        self._session: Session | None = None
        self._known: _Known = {}
        self._is_reading = self._is_outdated = False
        self.page = QTextBrowser()
        self.page.setOpenLinks(False)
        self.lay_out((self.page, 1))
        services.theme.changed.connect(self.refresh)

    def show_session(self, session: Session | None) -> None:
        """Follow a session."""
        self._session, self._known = session, {}
        if session is None:
            self.page.setPlainText("No session is open.")
        self.refresh()

    def refresh(self) -> None:
        """Read what has changed, where the page is seen."""
        session = self._session
        self._is_outdated = self._is_reading
        if session is None or not self.isVisible() or self._is_reading:
            return
        self._is_reading, known, alarm = True, self._known, self._services.theme.colours.alarm
        self._services.jobs.start(
            "the preview of the report", lambda: _page_of(session, known, alarm), self._read, self._failed
        )

    def _read(self, found: tuple[_Known, str]) -> None:
        self._is_reading = False
        self._known, page = found
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


def _page_of(session: Session, known: _Known, alarm: str) -> tuple[_Known, str]:
    """Return the runs read until now and the page; in the thread of the work, where matplotlib may take its time."""
    from radargui.report.facts import SessionFacts, report_facts
    from radargui.report.findings_section import findings_blocks, runs_table
    from radargui.report.rendering import pixels_of
    from radargui.report.report import labels_of

    found: _Known = {}
    for path in session.run_paths():
        changed = path.stat().st_mtime_ns if path.exists() else 0
        before = known.get(path)
        found[path] = before if before is not None and before[0] == changed else (changed, glance(path))
    labels = labels_of(session)
    runs = tuple(replace(facts, label=labels[facts.name]) for _, facts in found.values())
    facts = report_facts([SessionFacts(session.info, runs)], "")
    blocks = list(findings_blocks(facts))
    if runs:
        blocks.append(runs_table(facts.findings.sessions[0], runs))
    page = templates().get_template("blocks.html").render(blocks=blocks, picture_of=pixels_of)
    return found, SHEET.format(alarm=alarm) + page
