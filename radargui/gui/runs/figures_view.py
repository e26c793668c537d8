"""Figures of a run, and the report so far, as the report writes them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from html import escape

from PySide6.QtCore import Signal
from PySide6.QtGui import QResizeEvent, QShowEvent, QTextOption
from PySide6.QtWidgets import QHBoxLayout, QTextBrowser

from radargui.gui.background import OneAtATime
from radargui.gui.dialog import Dialog
from radargui.gui.layout import button, fill, having
from radargui.gui.services import Services
from radargui.gui.setup_words import LINK, called, called_u, in_words, words_of, words_of_u
from radargui.gui.theme import Theme
from radargui.model.result import RunResult
from radargui.model.rounding import plain
from radargui.model.setup import Setup
from radargui.model.setup_error import ChangedSetting
from radargui.model.uncertainty_budget import SHARES, UncertaintyBudget, budget_rows, variance_shares
from radargui.report.content import Content, Facts, Grid, templates
from radargui.report.facts import Glances
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_section
from radargui.session.session import Session

_SIX = (
    "Result",
    "e of the first impact",
    "g (combined u)",
    "First fall",
    "Flight before the first impact seen",
    "g against the site",
    "Correction, geometry",
)
"""What the report says of a run that stands first here: of the two flights a run has one."""
_MIN_LETTERS = 34
"""Of a table: in fewer it has no columns to part."""
_MAX_DIFFERENT = 12
"""Values of the setup that are named; more are counted."""
MIN_SHOWN = 0.005
"""Share of a variance below which a part of the budget is no stripe that anybody would see."""


class FiguresView(QTextBrowser):
    """What the run gave: the result in six lines, what is to be known before, budget, setup, and all figures.

    Everything is selectable; what is said of a value of the setup leads to its field.

    Attributes
    ----------
    differences
        Tells what a setup has otherwise than the window's.
    """

    field_asked = Signal(str)

    def __init__(self, theme: Theme) -> None:
        super().__init__(openLinks=False)
        self.anchorClicked.connect(lambda url: self.field_asked.emit(url.toString().removeprefix(LINK)))
        self.setAccessibleName("Result of the run")
        self._theme = theme
        self._result: RunResult | None = None
        self._letters = 0
        self.differences: Callable[[Setup], Sequence[ChangedSetting]] = lambda _setup: ()
        self.notes: tuple[str, ...] = ()
        """How the run was recorded, one line each; written beneath the figures."""
        # no word of a title is broken
        self.setWordWrapMode(QTextOption.WrapMode.WordWrap)
        theme.changed.connect(self._write)

    def show_result(self, result: RunResult) -> None:
        """Write the figures of a result, once they are looked at."""
        self._result = result
        self._write()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Write what came while it was hidden."""
        super().showEvent(event)
        self._write()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        """Part the tables anew where they fit no more, or need not be parted."""
        super().resizeEvent(event)
        if self._room != self._letters:
            place = self.verticalScrollBar().value()
            self._write()
            self.verticalScrollBar().setValue(place)

    def clear(self) -> None:
        """Forget the result."""
        self._result = None
        super().clear()

    @property
    def _room(self) -> int:
        """The letters that stand beside each other."""
        # with the bar, which comes and goes with what is written
        wide = self.width() - self.verticalScrollBar().sizeHint().width()
        return max(_MIN_LETTERS, wide // self.fontMetrics().horizontalAdvance("0") - 2)

    def _write(self) -> None:
        if self._result is not None and self.isVisible():
            notes, self._letters = "<br>".join(map(escape, self.notes)), self._room
            self.setHtml(f"{page_of(self._result, self._theme, self._letters, self._setup_words())}<p>{notes}</p>")

    def _setup_words(self) -> str:
        """Return what of the run's setup is otherwise than in the panels, each with a link to its field, as HTML."""
        lines = []
        for one in self.differences(self._result.setup) if self._result else ():
            was, now = (escape(words_of(one.key).with_unit(value)) for value in (one.before, one.after))
            lines.append(f'<a href="{LINK}{one.key}">{escape(called(one.key))}</a>: {was} (panels: {now})')
        more = [f"and {len(lines) - _MAX_DIFFERENT} more"] if len(lines) > _MAX_DIFFERENT else []
        return "<br>".join((*lines[:_MAX_DIFFERENT], *more)) or "as in the panels"


SHEET = """<style>
h3 {{ font-size: medium; margin: 8px 0 0 0; }}
th, td {{ font-weight: normal; padding: 1px 4px; text-align: right; }}
.grid td {{ white-space: nowrap; }}
.grid td.words {{ white-space: normal; text-align: left; }}
.left, .facts th, .facts td {{ text-align: left; }}
.warning {{ color: {alarm}; }}
</style>"""
"""Titles and sentences may take several lines, figures are never broken."""


def page_of(result: RunResult, theme: Theme, letters: int = 66, setup_words: str = "") -> str:
    """Return what the report says of a run in simple HTML; what it warns of in the colour of an alarm.

    Parameters
    ----------
    letters
        In which a table fits.
    setup_words
        What is said of the run's setup, as HTML; empty: nothing.
    """
    facts, budget = take_facts(result, "", columns=0), result.uncertainty_budget
    # what was assumed stands last, with names and units of the fields instead of those of the setup file
    stated = None if budget is None else replace(budget, assumed={})
    blocks = run_section(replace(facts, uncertainty_budget=stated), result.setup).blocks
    shown = [part for one in blocks for part in (one.within(letters) if isinstance(one, Grid) else (one,))]
    # what speaks against the figures stands before them
    first = next((place for place, one in enumerate(shown) if isinstance(one, Facts)), len(shown))
    rows = dict(one.rows) if first < len(shown) and isinstance(one := shown[first], Facts) else {}
    six = {name: rows.pop(name) for name in _SIX if name in rows}
    stripes = _stripes(budget, theme) if budget else ()
    above = _written(*shown[:first], Facts.of(six))
    setup = f"<h3>Setup of this run</h3><p>{setup_words}</p>" if setup_words else ""
    below = _written(Facts.of(rows, "All figures" if rows else ""), *shown[first + 1 :], *_assumed(budget))
    return "".join((SHEET.format(alarm=theme.colours.alarm), above, *stripes, setup, below))


def _written(*blocks: Content) -> str:
    return in_words(templates().get_template("blocks.html").render(blocks=blocks), linked=True)


def _assumed(budget: UncertaintyBudget | None) -> Iterator[Facts]:
    """Yield the table of what was assumed of the setup; none where nothing was."""
    known = [(called_u(key), words_of_u(key), u) for key, u in (budget.assumed if budget else {}).items()]
    if known:
        values = ((name, f"{plain(u, 2, scale=words.scale)}{words.tail}") for name, words, u in known)
        yield Facts(tuple(values), "Assumed, because the setup does not say")


def _stripes(budget: UncertaintyBudget, theme: Theme) -> Iterator[str]:
    colours = dict(zip(SHARES, (theme.colours.i, theme.colours.q, theme.colours.fit), strict=True))
    for name, line in (("e", budget.e), ("g", budget.g_m_s2), ("position", budget.position_m)):
        shares = {share: round(100.0 * part) for share, part in variance_shares(line).items() if part >= MIN_SHOWN}
        if shares:
            bar = (f"<td width='{part}%' bgcolor='{colours[share]}'>&nbsp;</td>" for share, part in shares.items())
            said = ", ".join(f"{share} {part}\u00a0%" for share, part in shares.items())
            yield f"<p>What makes u of {name}, by squares: {said}</p>"
            yield f"<table width='100%' cellspacing='0'><tr>{''.join(bar)}</tr></table>"


class BudgetView(QTextBrowser):
    """Whose share of the uncertainty is how large: as a table, and as stripes."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.setAccessibleName("Uncertainty budget")
        self._theme = theme

    def show_result(self, result: RunResult) -> None:
        """Write the budget of a result."""
        budget = result.uncertainty_budget
        if budget is None:
            self.setPlainText("This run has no budget: it needs a track.")
            return
        header, *rows = budget_rows(budget)
        said = _written(Grid(header, tuple(rows), "Standard uncertainties", left=(0,)))
        sheet = SHEET.format(alarm=self._theme.colours.alarm)
        self.setHtml("".join((sheet, said, *_stripes(budget, self._theme), _written(*_assumed(budget)))))


class ReportPreview(Dialog):
    """The report as it would be now, to be saved.

    It reads what the results say, in a thread, and only while it is seen; a run is read again when its file changes.

    Parameters
    ----------
    save
        Makes the report.
    """

    def __init__(self, services: Services, save: Callable[[], object]) -> None:
        super().__init__("Report", (760, 820), services.parent, "report_preview", services.settings)
        self._services = services
        self._session: Session | None = None
        self._reads = OneAtATime(services.jobs, "the preview of the report", self.refresh)
        self.page = having(QTextBrowser(openLinks=False), accessibleName="The report so far")
        self.save = button("Save", save, "Writes the report as PDF, HTML, CSV and JSON", default=True)
        self.lay_out((self.page, 1), fill(QHBoxLayout(), 1, self.save, button("Close", self.reject)))
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
    from radargui.report.report import labels_of
    from radargui.report.typesetting import pixels_of

    labels, found = labels_of(session), glances.session_facts(session)
    runs = tuple(replace(facts, label=labels[facts.name]) for facts in found.runs)
    facts = report_facts([replace(found, runs=runs)], "")
    blocks = list(findings_blocks(facts))
    if runs:
        blocks.append(runs_table(facts.findings.sessions[0], runs))
    page = templates().get_template("blocks.html").render(blocks=blocks, picture_of=pixels_of)
    return SHEET.format(alarm=alarm) + page
