"""The file whose samples are played back, and what its recording was set up with."""

import re
from functools import partial
from pathlib import Path

from radargui.gui.background import Jobs
from radargui.gui.layout import Group, PathField, PlainLabel, button
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import called
from radargui.model.setup import MEASURING, Setup

FILTER = "Recordings (*.h5 *.csv *.mat *.tdms *.sigmf-meta *.sigmf-data *.sigmf);;All files (*)"
_MOST_NAMED = 4


def _setup_in(path: Path) -> Setup | None:
    from radargui.experiment.importing import first_own_setup

    return first_own_setup([path])


class ReplayForm(Group):
    """The file whose samples are played back in real time; it says where the setup is not that of the recording."""

    def __init__(self, model: SetupModel, jobs: Jobs, path: Path | None = None) -> None:
        super().__init__("Replay")
        self._model, self._jobs = model, jobs
        self._own: Setup | None = None
        self._file = PathField("File to replay", path, FILTER)
        self._file.line.setPlaceholderText("recording to play back")
        self._file.line.setObjectName("replay.file")
        self.fault = self._file.fault
        self.row("File", self._file, fault=self.fault)
        self.whole(PlainLabel("Runs of RadarGUI, CSV, MATLAB, TDMS and SigMF files with channels I1, Q1, …"))
        self.other = PlainLabel()
        self.take_own = button("Use the recording's setup", self._take)
        for part in (self.other, self.take_own):
            self.whole(part)
        self._file.line.textChanged.connect(self._look)
        model.changed.connect(self._compare)
        self._look()

    @property
    def path(self) -> Path | None:
        """The chosen file."""
        return self._file.path

    def choose(self, path: Path) -> None:
        """Take a file."""
        self._file.line.setText(str(path))

    def _look(self) -> None:
        self._found(None)
        path = self.path
        # a name that is being typed is no file yet
        if path is not None and path.suffix:
            what = "the setup of the recording"
            self._jobs.start(what, partial(_setup_in, path), self._found, self._unknown, lambda: path == self.path)

    def _unknown(self, _error: BaseException) -> None:
        # what is wrong with the file is said when it is played
        self._found(None)

    def _found(self, setup: Setup | None) -> None:
        self._own = setup
        self._compare()

    def _compare(self) -> None:
        keys = [] if self._own is None else self._model.unlike(self._own)
        keys = [key for key in keys if re.split(r"[.\[]", key)[0] in MEASURING]
        named = ", ".join(map(called, keys[:_MOST_NAMED])) + (" …" if len(keys) > _MOST_NAMED else ".")
        self.other.setText(f"This recording was made with another setup, and is computed with the one here: {named}")
        self.take_own.setToolTip("Takes the place of the values here; Undo all changes brings back those of the file")
        for part in (self.other, self.take_own):
            part.setVisible(bool(keys))
        # what was edited and stands in no file would be lost
        self.take_own.setEnabled(not self._model.unsaved)

    def _take(self) -> None:
        if self._own is not None:
            self._model.replace(self._own)
