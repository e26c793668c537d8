"""What happens with runs: listed when recorded, shown when chosen, processed again, reported, exported."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QFileDialog

from radargui.acquisition.run_plan import Ending
from radargui.experiment.compare import OverlaidMethod, compute_methods, overlaid
from radargui.experiment.event import RecordedRun
from radargui.experiment.reporting import report_session, setup_of
from radargui.files.overview import read_overview
from radargui.files.run_card import RunCard, summarise
from radargui.gui.background import Task
from radargui.gui.control.state import RunWord
from radargui.gui.layout import ticking
from radargui.gui.runs.figures_view import ReportPreview
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.runs.run_model import RunEntry, entry_of_recorded, with_record
from radargui.gui.runs.run_panel import SCREEN_COLUMNS, RunPanel
from radargui.gui.runs.thumbnails import entry_of, thumbnail_of
from radargui.gui.services import Services
from radargui.gui.track.track_panel import TrackPanel
from radargui.model.errors import CancelledError
from radargui.model.result import RunResult
from radargui.model.words import sentence
from radargui.processing.process import STOPPED
from radargui.processing.result_of_run import result_of_run
from radargui.session.info import REPORT_FOLDER
from radargui.session.session import Session

if TYPE_CHECKING:
    from radargui.report.report import WrittenReport

COMPUTING = "By the adaptive correction: the joint one is being computed …"
_LATE_MS = 400
"""After which what an earlier run gave is taken away while another one is read (chosen by hand): most are there sooner,
and need not flicker."""
_KEPT = 3
"""Results held in memory; others are read again when chosen."""


class RunController:
    """Joins the run list, the run panel, the track and the work behind them."""

    def __init__(self, runs: RunListPanel, run: RunPanel, track: TrackPanel, services: Services) -> None:
        self.runs, self._run, self._track = runs, run, track
        self._work, self._jobs, self._board = services.work, services.jobs, services.board
        self._window = services.parent
        self._session: Session | None = None
        self._kept: dict[Path, RunResult] = {}
        self._wanted: Path | None = None
        self._reading: Task | None = None
        self.report_preview = ReportPreview(services, self.report)
        runs.model.altered.connect(self.report_preview.refresh)
        self._late = ticking(self._window, _LATE_MS, run.forget, once=True)
        runs.run_chosen.connect(self._choose)
        runs.not_opened.connect(lambda what: self._board.post("warning", f"No program here shows {what}"))
        run.methods_asked.connect(self._overlay)

    def show_session(self, session: Session | None, chosen: Path | None = None) -> None:
        """List the runs of a session, read in the background, and choose one of them."""
        there = self.runs.model.entries
        if session is not self._session:
            there = []
            self._run.clear()
            self._track.clear()
        self._late.stop()
        self._session, self._wanted = session, None
        self.report_preview.show_session(session)
        self._kept.clear()
        self.runs.show_session(session.path if session else None, there)
        if session is None:
            return

        def named(known: list[RunEntry]) -> None:
            # of a new one nothing is there yet, and what is chosen meanwhile stays so
            if session is self._session and known:
                # a run that was recorded meanwhile is not among those that were found
                entries = {one.path: one for one in (*known, *self.runs.model.entries)}
                self.runs.show_session(session.path, list(entries.values()))
                self.runs.choose_again(chosen)

        def work() -> tuple[list[RunEntry], Path | None]:
            # what is being recorded comes into the list once it is on the disk
            paths = [path for path in session.run_paths(with_rejected=True) if not session.records(path)]
            rejected, noted = session.rejected, session.info.notes_of
            known = [RunEntry(path, rejected=rejected.get(path.name), note=noted(path.name)) for path in paths]
            self._jobs.post(named, known)
            report = session.path / REPORT_FOLDER / "report.html"
            return [with_record(entry_of(path)) for path in paths], report if report.is_file() else None

        def listed(found: tuple[list[RunEntry], Path | None]) -> None:
            for entry in found[0]:
                self.runs.put(entry)
            if found[1] is not None:
                self.runs.show_report(found[1])

        self._jobs.start("the list of runs", work, listed, wanted=lambda: session is self._session)

    def take(self, recorded: RecordedRun, card: RunCard) -> None:
        """List a run that is on the disk, whose result is still to come."""
        if recorded.path is not None:
            self.runs.put(entry_of_recorded(recorded, recorded.path, card))

    def add(self, recorded: RecordedRun) -> None:
        """List and show a run that was just recorded; its final result without taking the eye off something else."""
        if recorded.error is not None:
            self._board.post_error(recorded.error)
        if recorded.path is None:
            if recorded.ending is not Ending.STOPPED:
                self._board.post("warning", recorded.message)
            return
        # what is behind another run's result never takes the eye off that
        result = recorded.result
        follows = recorded.path in self._kept or self.runs.model.is_overtaken(recorded.path)
        noted = self._session.info.notes_of(recorded.path.name) if self._session else None
        entry = replace(entry_of_recorded(recorded, recorded.path), note=noted)
        # what is set aside stays out of the way, also of the key that rejects the chosen run
        self.runs.put(entry, select=not recorded.set_aside and not follows)
        if result is None:
            self._has_no_result(recorded.path)
            return
        self._keep(recorded.path, result)
        path = recorded.path
        self._jobs.start(
            "the picture of a run",
            partial(thumbnail_of, path),
            lambda picture: self.runs.change(path, thumbnail=picture),
        )
        if not follows:
            self._show(recorded.path, result)
            self._glance(recorded.path)
        elif recorded.path == self._wanted:
            self._show(recorded.path, result, with_track=self._track.result is not None)

    def renew(self) -> None:
        """Look anew at the runs that had no result: theirs may have been computed while others are recorded."""
        session, known = self._session, self.runs.model.entries
        paths = [one.path for one in known if one.word is RunWord.NOT_COMPUTED and not one.waits]

        def show(entries: list[RunEntry]) -> None:
            for entry in entries:
                self.runs.put(entry)

        self._jobs.start(
            "results", lambda: [entry_of(path) for path in paths], show, wanted=lambda: session is self._session
        )

    def _has_no_result(self, path: Path) -> None:
        """Show a run that was left for later without the preliminary figures that stood there: they are not kept."""
        self._kept.pop(path, None)
        entry = self.runs.model.entry_of(path)
        if entry is not None and path == self._wanted and self._run.result is not None:
            self._run.forget("Not computed yet: click the run in the list.")
            self._run.say(entry.title, "not computed yet")
            self._track.clear()

    def report(self) -> None:
        """Make the report of the session in the background."""
        session = self._session
        if session is None or not self.runs.counting:
            self._board.post("warning", "There is no run to report: record one, or open a session.")
            return
        self.runs.show_report(busy=True)

        def written(report: WrittenReport) -> None:
            self.runs.show_report(report.html)
            self._board.post("info", f"Report written: {report.html.parent}")

        def failed(error: BaseException) -> None:
            self.runs.show_report()
            self._board.post_error(error)

        def work(task: Task) -> WrittenReport:
            return report_session(session, task.report)

        self._work.start("the report", work, written, failed, self.runs.show_report)

    def preview(self) -> None:
        """Show the report's first page as it would be now, and follow the runs."""
        self.report_preview.come_up()
        self.report_preview.show_session(self._session)

    def ask_export(self) -> None:
        """Let the operator choose where the tables go."""
        entry = self.runs.table.chosen
        if entry is None:
            self._board.post("warning", "No run is chosen: choose one in the list of runs.")
        elif name := QFileDialog.getExistingDirectory(self._window, "Export tables to", str(entry.path.parent)):
            self.export(Path(name))

    def export(self, folder: Path) -> None:
        """Write the tables of the chosen run to a new folder in `folder`."""
        entry = self.runs.table.chosen
        if entry is None:
            return
        known = self._kept.get(entry.path)
        if known is not None and _is_being_computed(known):
            known = None

        def work(task: Task) -> Path:
            from radargui.report.tables import write_tables

            target = _free_folder(folder, entry.name)
            write_tables(known or _result_of(entry.path, task.report), target)
            return target

        self._work.start("the export", work, lambda made: self._board.post("info", f"Tables written: {made}"))

    def _overlay(self, methods: tuple[str, ...]) -> None:
        """Compute the run that is shown by other methods, in the background, and lay them over it."""
        path, result, view = self._wanted, self._run.result, self._run.tabs.page("methods")
        if path is None or result is None:
            return
        own = result.quality.method if result.quality else ""

        def add(one: OverlaidMethod) -> None:
            if self._run.result is result:
                view.add(one)

        def work(task: Task) -> None:
            self._jobs.post(add, overlaid(result, result, own, SCREEN_COLUMNS))
            for one in compute_methods(path, result, methods, SCREEN_COLUMNS, task.report):
                self._jobs.post(add, one)

        def ended(error: BaseException | None = None) -> None:
            view.show_busy(busy=False)
            if error is not None:
                self._board.post_error(error)

        view.show_busy(busy=True)
        self._work.start(f"computing {path.stem} by {', '.join(methods)}", work, lambda _done: ended(), ended, ended)

    def _choose(self, entry: RunEntry) -> None:
        self._wanted = path = entry.path
        if self._reading is not None:
            self._reading.cancel()
        self._glance(path)
        if path in self._kept:
            self._show(path, self._kept[path])
            return
        self._run.say(entry.title)
        self._late.start()
        self._reading = task = self._work.quiet()
        self._jobs.start(
            "reading the run",
            lambda: _result_of(path, task.report, self._publisher(path)),
            lambda result: self._loaded(path, result),
            lambda error: None if isinstance(error, CancelledError) else self._not_shown(entry, error),
        )

    def _publisher(self, path: Path) -> Callable[[RunResult], None]:
        """Return what shows a preliminary result, to be called by the work."""

        def show(result: RunResult) -> None:
            if path == self._wanted:
                self._show(path, result)

        return lambda result: self._jobs.post(show, result)

    def _loaded(self, path: Path, result: RunResult) -> None:
        self._keep(path, result)
        self.runs.put(RunEntry(path, result.recording.started_at, summarise(result)))
        if path == self._wanted:
            self._show(path, result)

    def _glance(self, path: Path) -> None:
        """Show all samples at a glance: that takes a moment also where processing takes long."""
        self._jobs.start(
            "the overview of the run",
            partial(read_overview, path),
            lambda overview: self._run.show_overview(overview, in_front=path not in self._kept),
            # what is wrong with the file is reported by the reading of the run
            lambda _error: self._run.samples.clear(),
            lambda: path == self._wanted,
        )

    def _show(self, path: Path, result: RunResult, *, with_track: bool = True) -> None:
        self._wanted = path
        self._late.stop()
        entry = self.runs.model.entry_of(path)
        note = COMPUTING if _is_being_computed(result) else sentence(STOPPED.text) if result.preliminary else ""
        name = entry.title if entry else path.stem
        self._run.show_result(result, name, (note, *((entry.agreement, entry.health) if entry else ())))
        if with_track:
            self._track.show_result(result, name)

    def _keep(self, path: Path, result: RunResult) -> None:
        self._kept.pop(path, None)
        self._kept[path] = result
        for oldest in list(self._kept)[:-_KEPT]:
            del self._kept[oldest]

    def _not_shown(self, entry: RunEntry, error: BaseException) -> None:
        if entry.path == self._wanted:
            self._late.stop()
            self._run.forget("This run cannot be shown.")
            self._run.say(entry.title, "cannot be shown")
        self._board.post_error(error)


def _is_being_computed(result: RunResult) -> bool:
    return result.preliminary and STOPPED not in result.findings


def _result_of(
    path: Path, progress: Callable[[float], None], on_preliminary: Callable[[RunResult], None] | None = None
) -> RunResult:
    return result_of_run(path, setup_of(path), progress, on_preliminary)


def _free_folder(parent: Path, name: str) -> Path:
    numbered = (parent / f"{name}-{number}" for number in count(2))
    return next(folder for folder in chain([parent / name], numbered) if not folder.exists())
