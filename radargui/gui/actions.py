"""Everything the window can do, as actions with their keys; menus and buttons share them."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QMainWindow


class Actions:
    """One attribute an action."""

    def __init__(self, window: QMainWindow) -> None:
        self._window = window
        self.start = self._make("Start", "F5", tip="Show what the source gives, without recording")
        self.record = self._make("Record", "F9", "R", tip="Record runs: armed, triggered by motion, processed, saved")
        self.stop = self._make("Stop", "F5", "Shift+F5", tip="End what runs; what was recorded is kept")
        self.pause = self._make("Pause display", "F6", tip="Hold the plots; samples are taken all the same")
        self.pause.setCheckable(True)
        self.open_setup = self._make("Open setup…", "Ctrl+O")
        self.save_setup = self._make("Save setup", "Ctrl+S")
        self.save_setup_as = self._make("Save setup as…", "Ctrl+Shift+S")
        self.new_session = self._make("New session", "Ctrl+N", tip="The next Record makes a new session")
        self.sessions = self._make("Sessions…", "Ctrl+F", tip="Find, look at and open what was recorded before")
        self.open_session = self._make("Open session folder…", "Ctrl+Shift+O")
        self.import_ = self._make("Import recordings…", "Ctrl+I", tip="CSV, MATLAB, TDMS, SigMF as a session")
        self.export_samples = self._make(
            "Export samples…", "Ctrl+Shift+E", tip="A run or the session as CSV, MATLAB, TDMS, SigMF"
        )
        self.mark = self._make("Note now", "Ctrl+M", tip="Keep a note of this moment, also while a run is recorded")
        self.report = self._make("Make report", "Ctrl+R", tip="PDF, HTML, CSV and JSON of this session")
        self.export = self._make("Export tables of the run…", "Ctrl+E")
        self.compare = self._make(
            "Process again and compare…", "Shift+F8", tip="Other correction, geometry or setup; keep or discard"
        )
        self.reprocess = self._make("Process run again with this setup", "F8")
        self.reject = self._make(
            "Reject run, or take it back",
            "Del",
            "Backspace",
            tip="The chosen run, or the last one; it is kept",
        )
        # the same keys mean something else in a window beside this one
        self.reject.setShortcutContext(Qt.ShortcutContext.WindowShortcut)
        self.show_rejected = self._make("Show rejected runs", "Ctrl+J")
        self.show_rejected.setCheckable(True)
        self.sound = self._make("Sound when a run is done", "Ctrl+B", tip="Once: done; twice: rejected")
        self.sound.setCheckable(True)
        self.wiring = self._make("Check the wiring…", "F7", tip="Half a minute at the antennas: are the wires right?")
        self.quit = self._make("Quit", "Ctrl+Q")
        self.reset_layout = self._make("Reset layout", "Ctrl+0")
        self.in_space = self._make("Track in 3D", "Ctrl+3")
        self.in_space.setCheckable(True)
        self.in_space.setEnabled(False)
        self.show_live = self._make("Back to the live track", "Ctrl+L")
        self.dismiss = self._make("Dismiss messages", "Ctrl+D")
        self.about = self._make("About RadarGUI", "F1")

    def _make(self, words: str, *keys: str, tip: str = "") -> QAction:
        action = QAction(words, self._window)
        action.setShortcuts([QKeySequence(key) for key in keys])
        action.setToolTip(f"{tip or words.rstrip('…')} ({', '.join(keys)})")
        action.setShortcutContext(Qt.ShortcutContext.ApplicationShortcut)
        self._window.addAction(action)
        return action
