"""The window of the wiring check: the step in letters that are read at the antennas, then what was found."""

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QScrollArea, QVBoxLayout, QWidget

from radargui.experiment.wiring import GuideState
from radargui.gui.layout import Dialog, PlainLabel, button, fill, take_out
from radargui.gui.setup.words import in_words
from radargui.gui.theme import Theme, scaled_font
from radargui.processing.wiring import WiringFinding, WiringReport

_WELCOME = (
    "Half a minute at the antennas: keep still, move the tracer away, wave a hand in front of each receiver. "
    "It finds channels at the wrong antenna, I and Q exchanged, an inverted Q and dead inputs."
)
_TITLE, _LARGE, _MEDIUM = 3.0, 4.0, 1.5
"""Times the usual size of letters: the step is read from the antennas, two or three metres away."""


class WiringDialog(Dialog):
    """Says what to do; shows findings and what they propose."""

    begin_asked = Signal()
    take_asked = Signal()

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__("Wiring check", (900, 560), parent)
        self._theme = theme
        self._report: WiringReport | None = None
        self._found: list[QLabel] = []
        self._measuring = False
        self.when = PlainLabel(selectable=False)
        self.when.setFont(scaled_font(self.font(), _TITLE, bold=True))
        self.step = PlainLabel(_WELCOME, selectable=False)
        self.step.setAlignment(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        self.progress = QProgressBar()
        self.progress.setTextVisible(False)
        findings = QWidget()
        self._lines = fill(QVBoxLayout(findings), spacing=6)
        self._lines.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._area = QScrollArea()
        self._area.setWidget(findings)
        self._area.setWidgetResizable(True)
        self._area.setFrameShape(QScrollArea.Shape.NoFrame)
        self.begin = button("Begin", self.begin_asked, default=True)
        self.take = button("Take over the proposals", self.take_asked)
        for one in (self.begin, self.take):
            one.setFont(scaled_font(one.font(), 1.15, bold=True))
        ends = fill(QHBoxLayout(), self.begin, self.take, 1, button("Close", self.reject), spacing=6)
        parts = (self.when, self.step, self.progress, (self._area, 1), ends)
        self.lay_out(*parts, margins=(18, 14, 18, 12), spacing=10)
        theme.changed.connect(self._colour)
        self._show("Are the wires right?", _WELCOME)

    def finding_texts(self) -> tuple[str, ...]:
        """Return the findings shown."""
        return tuple(line.text() for line in self._found)

    def show_waiting(self, words: str = "Waiting for the samples …") -> None:
        """Say that nothing is to be done now."""
        self._clear()
        self._show(words, "")
        self.begin.setEnabled(False)

    def show_step(self, state: GuideState) -> None:
        """Show what the operator does, and for how long."""
        if state.step is None:
            return
        when = "Now" if state.measuring else "Get ready"
        self._show(f"{when}   {state.left_s:.0f} s", state.step.instruction, large=True, measuring=state.measuring)
        self.progress.setVisible(True)
        self.progress.setRange(0, state.total)
        self.progress.setValue(state.number - (not state.measuring))
        self._area.setVisible(False)
        self.begin.setEnabled(False)

    def show_report(self, report: WiringReport) -> None:
        """Show what was found."""
        self._clear()
        wrong = sum(finding.kind != "good" for finding in report.findings)
        title = "The wiring is right." if report.is_good else f"{wrong} finding{'s'[: wrong > 1]}"
        proposed = f"Proposed: {in_words('; '.join(report.settings()))}" if report.corrects else ""
        self._show(title, proposed)
        for finding in report.findings:
            line = PlainLabel(_said(finding))
            line.setFont(scaled_font(line.font(), _MEDIUM))
            self._lines.addWidget(line)
            self._found.append(line)
        self._report = report
        self._offer_repeat()
        self.take.setVisible(report.corrects)
        self._colour()

    def show_failure(self, words: str) -> None:
        """Say why there is nothing to show."""
        self._clear()
        self._show("Not checked", words)
        self._offer_repeat()

    def show_taken(self) -> None:
        """Say that the proposals stand in the setup."""
        self.take.setVisible(False)
        self.step.setText("The proposals stand in the setup: check again, then save it.")

    def _offer_repeat(self) -> None:
        self.begin.setEnabled(True)
        self.begin.setText("Check again")

    def _show(self, title: str, words: str, *, large: bool = False, measuring: bool = False) -> None:
        self.when.setText(title)
        if words != self.step.text():
            self.step.setText(words)
        self.when.setFont(scaled_font(self.font(), _LARGE if large else _TITLE, bold=True))
        self.step.setFont(scaled_font(self.font(), _LARGE if large else _MEDIUM))
        self.step.setVisible(bool(words))
        self._measuring = measuring
        self.progress.setVisible(False)
        self._area.setVisible(True)
        self.take.setVisible(False)
        self._colour()

    def _clear(self) -> None:
        self._report = None
        take_out(self._lines, *self._found)
        self._found.clear()

    def _colour(self) -> None:
        colours = self._theme.colours
        good = self._report is not None and self._report.is_good
        bad = self._report is not None and not good
        colour = colours.alarm if bad else colours.good if good or self._measuring else colours.text
        style = f"color: {colour};"
        if self.when.styleSheet() != style:
            self.when.setStyleSheet(style)
        if self._report is not None:
            for line, finding in zip(self._found, self._report.findings, strict=True):
                colour = colours.good if finding.kind == "good" else colours.alarm
                line.setStyleSheet(f"color: {colour};")


def _said(finding: WiringFinding) -> str:
    return f"{'✓' if finding.kind == 'good' else '✗'}  {finding}"
