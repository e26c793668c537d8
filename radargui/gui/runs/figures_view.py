"""Figures of a run, and the report so far, as the report writes them."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from html import escape

from PySide6.QtCore import Signal
from PySide6.QtGui import QTextOption
from PySide6.QtWidgets import QTextBrowser

from radargui.gui.background import OneAtATime
from radargui.gui.dialog import Dialog
from radargui.gui.layout import having
from radargui.gui.services import Services
from radargui.gui.setup.words import LINK, in_words
from radargui.gui.theme import Theme
from radargui.model.result import RunResult
from radargui.model.uncertainty_budget import SHARES, UncertaintyBudget, variance_shares
from radargui.report.content import Grid, templates
from radargui.report.facts import Glances
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_section
from radargui.session.session import Session

_LETTERS = 66
"""In which a table fits the panel on a screen of 1366 pixels."""
LEAST_SHOWN = 0.005
"""Share of a variance below which a part of the budget is no stripe that anybody would see."""


class FiguresView(QTextBrowser):
    """Everything selectable; what is said of a value of the setup leads to its field."""

    field_asked = Signal(str)

    def __init__(self, theme: Theme) -> None:
        super().__init__(openLinks=False)
        self.anchorClicked.connect(lambda url: self.field_asked.emit(url.toString().removeprefix(LINK)))
        self.setAccessibleName("Result of the run")
        self._theme = theme
        self._result: RunResult | None = None
        self.notes: tuple[str, ...] = ()
        """How the run was recorded, one line each; written beneath the figures."""
        # no word of a title is broken
        self.setWordWrapMode(QTextOption.WrapMode.WordWrap)
        theme.changed.connect(self._write)

    def show_result(self, result: RunResult) -> None:
        """Write the figures of a result."""
        self._result = result
        self._write()

    def clear(self) -> None:
        """Forget the result."""
        self._result = None
        super().clear()

    def _write(self) -> None:
        if self._result is not None:
            notes = "<br>".join(map(escape, self.notes))
            self.setHtml(f"{page_of(self._result, self._theme)}<p>{notes}</p>")


SHEET = """<style>
h3 {{ font-size: medium; margin: 8px 0 0 0; }}
th, td {{ font-weight: normal; padding: 1px 4px; text-align: right; }}
.grid td {{ white-space: nowrap; }}
.grid td.words {{ white-space: normal; text-align: left; }}
.left, .facts th, .facts td {{ text-align: left; }}
.warning {{ color: {alarm}; }}
</style>"""
"""Titles and sentences may take several lines, figures are never broken."""


def page_of(result: RunResult, theme: Theme) -> str:
    """Return what the report says of a run in simple HTML; what it warns of in the colour of an alarm."""
    blocks = run_section(take_facts(result, "", columns=0), result.setup).blocks
    shown = [part for one in blocks for part in (one.within(_LETTERS) if isinstance(one, Grid) else (one,))]
    said = in_words(templates().get_template("blocks.html").render(blocks=shown), linked=True)
    stripes = _stripes(result.uncertainty_budget, theme) if result.uncertainty_budget else ()
    return SHEET.format(alarm=theme.colours.alarm) + said + "".join(stripes)


def _stripes(budget: UncertaintyBudget, theme: Theme) -> Iterator[str]:
    colours = dict(zip(SHARES, (theme.colours.i, theme.colours.q, theme.colours.fit), strict=True))
    for name, line in (("e", budget.e), ("g", budget.g_m_s2), ("position", budget.position_m)):
        shares = {share: round(100.0 * part) for share, part in variance_shares(line).items() if part >= LEAST_SHOWN}
        if shares:
            bar = (f"<td width='{part}%' bgcolor='{colours[share]}'>&nbsp;</td>" for share, part in shares.items())
            said = ", ".join(f"{share} {part} %" for share, part in shares.items())
            yield f"<p>What makes u of {name}, by squares: {said}</p>"
            yield f"<table width='100%' cellspacing='0'><tr>{''.join(bar)}</tr></table>"


class ReportPreview(Dialog):
    """Reads what the results say, in a thread, and only while it is seen; a run is read again when its file changes."""

    def __init__(self, services: Services) -> None:
        super().__init__("Preview of the report", (760, 820), services.parent, "report_preview", services.settings)
        self._services = services
        self._session: Session | None = None
        self._reads = OneAtATime(services.jobs, "the preview of the report", self.refresh)
        self.page = having(QTextBrowser(openLinks=False), accessibleName="The report so far")
        self.lay_out((self.page, 1))
        services.theme.changed.connect(self.refresh)

    def show_session(self, session: Session | None) -> None:
        """Follow a session."""
        if session is None or self._session is None or session.path != self._session.path:
            self.page.setPlainText("Reading …" if session else "No session is open.")
        self._session = session
        self.refresh()

    def refresh(self) -> None:
        """Read what has changed, where the page is seen."""
        if self._session is None or not self.isVisible():
            self._reads.outdate()
            return
        work = partial(_front_page, self._session, self._services.glances, self._services.theme.colours.alarm)
        self._reads.start(work, self._show, lambda error: self.page.setPlainText(str(error)))

    def _show(self, page: str) -> None:
        bar = self.page.verticalScrollBar()
        place = bar.value()
        self.page.setHtml(page)
        bar.setValue(place)


def _front_page(session: Session, glances: Glances, alarm: str) -> str:
    """Return the page; in the thread of the work, where matplotlib may take its time."""
    from radargui.report.facts import report_facts
    from radargui.report.findings_section import findings_blocks, runs_table
    from radargui.report.html import pixels_of
    from radargui.report.report import labels_of

    labels, found = labels_of(session), glances.session_facts(session)
    runs = tuple(replace(facts, label=labels[facts.name]) for facts in found.runs)
    facts = report_facts([replace(found, runs=runs)], "")
    blocks = list(findings_blocks(facts))
    if runs:
        blocks.append(runs_table(facts.findings.sessions[0], runs))
    page = templates().get_template("blocks.html").render(blocks=blocks, picture_of=pixels_of)
    return SHEET.format(alarm=alarm) + page
