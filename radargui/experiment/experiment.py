"""Arm, record, process and save runs; the window and the command line both call this."""

from collections.abc import Iterator
from pathlib import Path

from radargui.experiment.event import ExperimentState, Listener, RecordedRun, with_place
from radargui.experiment.series import AcquisitionSeries, RunOrder
from radargui.model.errors import RadarGuiError
from radargui.session.session import BY_OPERATOR

__all__ = ["Experiment", "Listener"]


class Experiment(RunOrder):
    """Runs recorded one after the other into one session; parameters and attributes as of `RunOrder`.

    `record` does the work in the caller's thread, where the listener is called too; `finish`, `cancel` and the
    properties may be used from any thread. Runs are processed in order, in a process of their own, or a thread
    where the source is patient.
    """

    @property
    def state(self) -> ExperimentState:
        """Where the experiment is."""
        return self.publisher.state

    def record(self, n_runs: int) -> Iterator[RecordedRun]:
        """Record runs and yield each when it is processed, in order; the next one is armed meanwhile.

        Those that were set aside come too and do not count. The last one has no file where nothing moved any more; one
        whose processing alone failed has an `error`.

        Raises
        ------
        RadarGuiError
            The source or the disk failed; what was recorded until then is kept, the error says where.
        """
        if n_runs < 1 or self.is_cancelled:
            return
        yield from self._series(1, n_runs) if self.continuous else self._series(n_runs, 1)

    def reject(self, run: Path, reason: str = BY_OPERATOR) -> None:
        """Set a run aside (kept, hidden, reversible); a series that goes on records another one in its place.

        Raises
        ------
        SessionError
            No such run, or the session cannot be written.
        """
        known = run.name in self.session.rejected
        self.session.reject(run, reason)
        acquisition = self.acquisition
        if not known and acquisition is not None and acquisition.recorder is not None:
            acquisition.recorder.want_another()

    def _series(self, n_acquisitions: int, n_runs: int) -> Iterator[RecordedRun]:
        """Record runs, so many from each source; each is processed while the next one is armed."""
        try:
            series = AcquisitionSeries(self, n_acquisitions, n_runs)
        except RadarGuiError as error:
            self.publisher.enter(ExperimentState.FAILED, str(error), error=error)
            raise
        yield from series.runs()
        if series.failure is not None:
            failure = with_place(series.failure, series.failed_file)
            self.publisher.enter(ExperimentState.FAILED, str(failure), error=failure)
            raise failure
