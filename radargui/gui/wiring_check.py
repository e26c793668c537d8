"""The wiring check: the guide in letters that are read at the antennas, what it found, what the operator takes over."""

from collections.abc import Callable

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QVBoxLayout

from radargui.acquisition.ring import Ring
from radargui.experiment.wiring import GuideState, WiringGuide
from radargui.gui.control.state import AppState, Feed
from radargui.gui.dialog import Dialog
from radargui.gui.layout import PlainLabel, Scroll, boxed, button, fill, having, take_out, ticking
from radargui.gui.services import Services
from radargui.gui.setup.hardware_panel import HardwarePanel
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup_words import in_words
from radargui.gui.theme import scaled_font
from radargui.model.setup import Setup
from radargui.processing.wiring import WiringReport
from radargui.sources.contract import Source

_WELCOME = (
    "Half a minute at the antennas: keep still, move the tracer away, wave a hand in front of each receiver. "
    "It finds channels at the wrong antenna, I and Q exchanged, an inverted Q and dead inputs."
)
_TITLE, _LARGE, _MEDIUM = 3.0, 4.0, 1.5
"""Times the usual size of letters: the step is read from the antennas, two or three metres away."""


LOOK_MS = 40
"""How often the guide looks at the samples: a step begins within a frame or two of what is said."""


def simulated_operator(setup: Setup) -> Source:
    """Return the scene in which somebody does what the guide says; loaded when it is wanted."""
    from radargui.sources.simulated.model import WiringScene

    return WiringScene(setup)


class WiringCheck(Dialog):
    """Says what to do, follows the samples of the live view, shows findings, takes over what they propose.

    Attributes
    ----------
    scene
        Makes what a simulated check looks at: an operator who does what the guide says. Tests put another one here.
    """

    def __init__(self, setup_model: SetupModel, hardware: HardwarePanel, services: Services) -> None:
        super().__init__("Wiring check", (900, 560), services.parent, "wiring", services.settings)
        self._setup_model, self._hardware, self._services = setup_model, hardware, services
        self._control = control = services.control
        self._guide: WiringGuide | None = None
        self._ring: Ring | None = None
        self._wanted = self._own_view = self._measuring = False
        self._report: WiringReport | None = None
        self.scene: Callable[[Setup], Source] = simulated_operator
        self.findings: list[QLabel] = []
        self.when = PlainLabel(selectable=False)
        top = Qt.AlignmentFlag.AlignTop
        self.step = having(PlainLabel(_WELCOME, selectable=False), alignment=top | Qt.AlignmentFlag.AlignLeft)
        self.progress = QProgressBar(textVisible=False)
        self._lines = having(QVBoxLayout(), alignment=top)
        self._area = Scroll(boxed(self._lines, spacing=6))
        self.begin = button("Begin", self.check, default=True)
        self.take = button("Take over the proposals", self.take_over)
        for one in (self.begin, self.take):
            one.setFont(scaled_font(one.font(), 1.15, bold=True))
        ends = fill(QHBoxLayout(), self.begin, self.take, 1, button("Close", self.reject), spacing=6)
        parts = (self.when, self.step, self.progress, (self._area, 1), ends)
        self.lay_out(*parts, margins=(18, 14, 18, 12), spacing=10)
        services.theme.changed.connect(self._colour)
        self._show("Are the wires right?", _WELCOME)
        self._timer = ticking(self, LOOK_MS, self._look)
        self.finished.connect(lambda _result: self.end())
        control.feed_changed.connect(self._feed_changed)
        control.state_changed.connect(self._state_changed)

    def show_waiting(self, words: str = "Waiting for the samples …") -> None:
        """Say that nothing is to be done now."""
        self._show(words)
        self.begin.setEnabled(False)

    def show_step(self, state: GuideState) -> None:
        """Show what the operator does, and for how long."""
        if state.step is not None:
            when = "Now" if state.measuring else "Get ready"
            self._show(f"{when}   {state.left_s:.0f} s", state.step.instruction, state=state)

    def show_report(self, report: WiringReport) -> None:
        """Show what was found."""
        wrong = sum(finding.kind != "good" for finding in report.findings)
        title = "The wiring is right." if report.is_good else f"{wrong} finding{'s'[: wrong > 1]}"
        proposed = f"Proposed: {in_words('; '.join(report.settings()))}" if report.corrects else ""
        self._show(title, proposed, report=report)
        self.begin.setText("Check again")

    def show_failure(self, words: str) -> None:
        """Say why there is nothing to show."""
        self._show("Not checked", words)
        self.begin.setText("Check again")

    def _show(
        self, title: str, words: str = "", *, state: GuideState | None = None, report: WiringReport | None = None
    ) -> None:
        """Show a title and words, with how far the guide is, or with what was found."""
        self._report, self._measuring = report, state is not None and state.measuring
        take_out(self._lines, *self.findings)
        self.findings = [
            PlainLabel(f"{'✓' if finding.kind == 'good' else '✗'}  {finding}")
            for finding in (report.findings if report is not None else ())
        ]
        for line in self.findings:
            line.setFont(scaled_font(line.font(), _MEDIUM))
            self._lines.addWidget(line)
        self.when.setText(title)
        self.step.setText(words)
        self.when.setFont(scaled_font(self.font(), _LARGE if state else _TITLE, bold=True))
        self.step.setFont(scaled_font(self.font(), _LARGE if state else _MEDIUM))
        self.step.setVisible(bool(words))
        if state is not None:
            having(self.progress, maximum=state.total, value=state.number - (not state.measuring))
        self.progress.setVisible(state is not None)
        self._area.setVisible(state is None)
        self.take.setVisible(report is not None and report.corrects)
        self.begin.setEnabled(state is None)
        self._colour()

    def _colour(self) -> None:
        colours, report = self._services.theme.colours, self._report
        plain = colours.good if self._measuring else colours.text
        colour = plain if report is None else colours.good if report.is_good else colours.alarm
        style = f"color: {colour};"
        if self.when.styleSheet() != style:
            self.when.setStyleSheet(style)
        for line, finding in zip(self.findings, report.findings if report is not None else (), strict=True):
            line.setStyleSheet(f"color: {colours.good if finding.kind == 'good' else colours.alarm};")

    def check(self) -> None:
        """Begin the check: with the live view that runs, or with one of its own."""
        control, model = self._control, self._setup_model
        if control.state.running and control.state is not AppState.LIVE:
            self.show_failure("Runs are being recorded. Stop them before the wires are checked.")
            return
        if not model.valid:
            self.show_failure(model.error)
            return
        self._wanted = True
        self.show_waiting()
        if control.state is not AppState.LIVE:
            self._start_view()
        elif self._hardware.kind == "simulated":
            # the sphere that falls again and again does not do what the guide says
            control.stop()
        else:
            self._feed_changed(control.feed)

    def take_over(self) -> None:
        """Take the proposed settings into the setup that is edited; a live view with the old ones is ended."""
        report, model = self._report, self._setup_model
        if report is None or not report.corrects:
            return
        self.end()
        if self._control.state is AppState.LIVE:
            self._control.stop()
        model.replace(report.corrected(model.setup))
        taken = in_words(", ".join(report.settings()))
        self._services.board.post("info", f"Taken into the setup: {taken}. Save it to keep it.")
        self.take.hide()
        self.step.setText("The proposals stand in the setup: check again, then save it.")

    def end(self) -> None:
        """End the check; a live view of its own ends with it."""
        self._wanted = False
        self._guide = self._ring = None
        self._timer.stop()
        if self._own_view and self._control.state.running:
            self._control.stop()
        self._own_view = False

    def _start_view(self) -> None:
        hardware, setup = self._hardware, self._setup_model.setup
        self._own_view = True
        scene = self.scene if hardware.kind == "simulated" else None
        self._control.start_live(setup, hardware.kind, hardware.replay.file.path, make=scene)

    def _feed_changed(self, feed: Feed | None) -> None:
        if feed is None or not self._wanted:
            return
        self._wanted = False
        self._ring = feed.ring
        # a view of its own is followed from its first sample
        first = 0 if self._own_view else feed.ring.latest
        self._guide = WiringGuide(feed.setup, feed.digitisation, first_index=first)
        self._timer.start()

    def _state_changed(self) -> None:
        state = self._control.state
        if state.running:
            return
        if self._guide is not None:
            self._look()
        if self._guide is not None:
            self.end()
            self.show_failure("The samples ended before the wiring check did. Check again.")
        elif self._wanted and self._own_view:
            self.end()
            self.show_failure("There are no samples to check: see the message in the window.")
        elif self._wanted:
            # the state changes in the middle of the end of the view before: begin when that is over
            QTimer.singleShot(0, self, self._start_view)

    def _look(self) -> None:
        guide, ring = self._guide, self._ring
        if guide is None or ring is None:
            return
        state: GuideState = guide.poll(ring)
        if not guide.is_done:
            self.show_step(state)
            return
        self.end()
        self.show_waiting("Looking at what was measured …")
        self._services.jobs.start("the wiring check", guide.report, self.show_report, self._failed)

    def _failed(self, error: BaseException) -> None:
        self.show_failure("The wires could not be checked.")
        self._services.board.post_error(error)
