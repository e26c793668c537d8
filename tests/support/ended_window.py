"""The window that the system ends: it records a simulated circle by itself and says when, and where.

python -m support.ended_window SETUP
"""

from __future__ import annotations

import os
import sys

from PySide6.QtCore import QTimer
from support.killing import hear_signals

from radargui.cli import main
from radargui.experiment import series
from radargui.experiment.processing_apart import ProcessingHere
from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow


class RecordingWindow(MainWindow):
    """Presses its own button, and writes the run to the standard output as soon as it is being recorded."""

    def show(self) -> None:
        super().show()
        # moves on until it is ended: of a drop a busy computer may see the end only
        self.setup_model.assign("simulation.scene", "circle")
        self.setup_model.assign("recording.maximum_s", 60.0)
        timer = QTimer(self)
        timer.timeout.connect(self._watch)
        QTimer.singleShot(0, self.actions_.record.trigger)
        timer.start(20)
        self._told = False

    def _watch(self) -> None:
        session = self.control.session
        if not self._told and self.control.state is AppState.RECORDING and session is not None and session.recording:
            self._told = True
            os.write(1, f"{session.recording}\n".encode())


if __name__ == "__main__":
    import radargui.gui.main_window

    hear_signals()
    series.ProcessingApart = ProcessingHere  # type: ignore[misc]
    radargui.gui.main_window.MainWindow = RecordingWindow  # type: ignore[misc]
    # as the operator starts it: the command line around the window hears the system too
    sys.argv[1:] = ["--open", sys.argv[1]]
    main()
