"""Drives the wiring check from the live view: begins it, follows the samples, takes over what is proposed."""

from collections.abc import Callable

from PySide6.QtCore import QObject, QTimer, Signal

from radargui.experiment.wiring import GuideState, WiringGuide
from radargui.gui.control.app_state import AppState
from radargui.gui.control.feed import Feed
from radargui.gui.control.run_control import RunControl
from radargui.gui.services import Services
from radargui.gui.setup.hardware_panel import HardwarePanel
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import in_words
from radargui.gui.wiring.wiring_dialog import WiringDialog
from radargui.model.setup import Setup
from radargui.processing.wiring import WiringReport
from radargui.sources.contract import Source

LOOK_MS = 40
"""How often the guide looks at the samples: a step begins within a frame or two of what is said."""


def simulated_operator(setup: Setup) -> Source:
    """Return the simulation of an operator who does what the guide says."""
    from radargui.sources.simulated.wiring_scene import WiringScene

    return WiringScene(setup)


class WiringController(QObject):
    """The check and its dialog.

    Attributes
    ----------
    scene
        Makes what a simulated check looks at; tests put another one here.
    done
        The report is there.
    """

    done = Signal(object)

    def __init__(
        self, control: RunControl, setup_model: SetupModel, hardware: HardwarePanel, services: Services
    ) -> None:
        super().__init__(services.parent)
        self._control, self._setup_model, self._hardware, self._services = control, setup_model, hardware, services
        self._dialog: WiringDialog | None = None
        self._guide: WiringGuide | None = None
        self._feed: Feed | None = None
        self._wanted = self._own_view = False
        self._report: WiringReport | None = None
        self.scene: Callable[[Setup], Source] = simulated_operator
        self._timer = QTimer(self, interval=LOOK_MS)
        self._timer.timeout.connect(self._look)
        control.feed_changed.connect(self._feed_changed)
        control.state_changed.connect(self._state_changed)

    @property
    def dialog(self) -> WiringDialog:
        """The dialog, made when it is first asked for."""
        if self._dialog is None:
            dialog = WiringDialog(self._services.theme, self._services.parent)
            dialog.begin_asked.connect(self.begin)
            dialog.take_asked.connect(self.take_over)
            dialog.finished.connect(lambda _result: self.end())
            self._dialog = dialog
        return self._dialog

    def show(self) -> None:
        """Show the dialog."""
        self.dialog.come_up()

    def begin(self) -> None:
        """Begin the check: with the live view that runs, or with one of its own."""
        control, model = self._control, self._setup_model
        if control.state.running and control.state is not AppState.LIVE:
            self.dialog.show_failure("Runs are being recorded. Stop them before the wires are checked.")
            return
        if not model.valid:
            self.dialog.show_failure(model.error)
            return
        self._report = None
        self._wanted = True
        self.dialog.show_waiting()
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
        self._services.board.post(
            "info", f"Taken into the setup: {in_words(', '.join(report.settings()))}. Save it to keep it."
        )
        self.dialog.show_taken()

    def end(self) -> None:
        """End the check; a live view of its own ends with it."""
        self._wanted = False
        self._guide = self._feed = None
        self._timer.stop()
        if self._own_view and self._control.state.running:
            self._control.stop()
        self._own_view = False

    def _start_view(self) -> None:
        hardware, setup = self._hardware, self._setup_model.setup
        self._own_view = True
        scene = self.scene if hardware.kind == "simulated" else None
        self._control.start_live(setup, hardware.kind, hardware.replay.path, make=scene)

    def _feed_changed(self, feed: Feed | None) -> None:
        if feed is None or not self._wanted or feed.ring is None or feed.acquisition.digitisation is None:
            return
        self._wanted = False
        self._feed = feed
        # a view of its own is followed from its first sample
        first = 0 if self._own_view else feed.ring.latest
        self._guide = WiringGuide(feed.setup, feed.acquisition.digitisation, first_index=first)
        self._timer.start()

    def _state_changed(self) -> None:
        state = self._control.state
        if state.running:
            return
        if self._guide is not None:
            self._look()
        if self._guide is not None:
            self.end()
            self.dialog.show_failure("The samples ended before the wiring check did. Check again.")
        elif self._wanted and self._own_view:
            self.end()
            self.dialog.show_failure("There are no samples to check: see the message in the window.")
        elif self._wanted:
            # the state changes in the middle of the end of the view before: begin when that is over
            QTimer.singleShot(0, self, self._start_view)

    def _look(self) -> None:
        guide, feed = self._guide, self._feed
        if guide is None or feed is None or feed.ring is None:
            return
        state: GuideState = guide.poll(feed.ring)
        if not guide.is_done:
            self.dialog.show_step(state)
            return
        self.end()
        self.dialog.show_waiting("Looking at what was measured …")
        self._services.jobs.start("the wiring check", guide.report, self._found, self._failed)

    def _found(self, report: WiringReport) -> None:
        self._report = report
        self.dialog.show_report(report)
        self.done.emit(report)

    def _failed(self, error: BaseException) -> None:
        self.dialog.show_failure("The wires could not be checked.")
        self._services.board.post_error(error)
