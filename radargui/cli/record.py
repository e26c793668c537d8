"""`radargui record`: record, process and save drops as a session."""

from datetime import datetime
from functools import partial

import typer
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn

from radargui.cli.app import Record
from radargui.cli.bar import Bar, show_table
from radargui.cli.console import FAILED, fail, one_line
from radargui.cli.setup_choice import COMMAND_LINE, named_or_default, parse_release, positive
from radargui.experiment.awake import kept_awake
from radargui.experiment.event import Event, EventKind, ExperimentState, RecordedRun
from radargui.experiment.series import Experiment
from radargui.files.formats import own_setup_of
from radargui.files.run_card import origin_attributes, origin_of_source, summarise
from radargui.model.calibrated_setup import too_old
from radargui.model.drop import figure_in, gravity_words, restitution_words
from radargui.model.errors import RadarGuiError, SourceError, UsageError
from radargui.model.rounding import plain
from radargui.model.setup import Setup, changed
from radargui.processing.calibration_check import check_calibration
from radargui.session.info import CalibrationRecord, SessionDetails, SessionInfo, about_setup_file, default_data_folder
from radargui.session.session import Session
from radargui.sources.contract import Source
from radargui.sources.factory import make_source, source_kinds

_LIKE = ("operator", "sample", "target")


def record_session(options: Record) -> int:
    """Record runs into a new session, print its folder and a table of the runs, and return the exit status.

    Raises
    ------
    UsageError
        Options that do not go together.
    SetupError
        The setup or an option instead of it is not allowed.
    RadarGuiError
        The session or the source cannot be used.
    """
    like = None if options.like is None else Session.open(options.like, write=False).info
    setup = _setup(options, like)
    # a source that cannot even be made must not leave an empty session behind
    first = _make_source(options, setup, run=0)
    session = Session.create(
        options.output or default_data_folder(),
        setup,
        **_about(options, like) | {"source": origin_of_source(options.source, options.file, setup.daq.device).badge},
        now=datetime.now().astimezone(),
    )
    typer.echo(f"Session: {session.path}")
    if old := too_old(setup, datetime.now().astimezone()):
        typer.echo(f"Warning: {old}.", err=True)
    rows: list[tuple[str, ...]] = []
    with RecordProgress(options.runs) as progress:
        experiment = Experiment(
            setup,
            lambda run: first if run == 0 else _make_source(options, setup, run=run),
            session,
            seconds=options.seconds,
            listener=progress,
            # without real time the live track could not keep up and would mean nothing
            live=not options.fast,
            patient=options.fast,
            # a device that waits for a start signal begins anew with each run
            continuous=setup.daq.start == "now" if options.source == "ni" else options.hands_free,
            attributes=origin_attributes(options.source, options.file, setup.daq.device),
            # a simulation that sleeps loses nothing
            awake=partial(kept_awake, reports=options.source == "ni"),
        )
        error, status = _record(experiment, options.runs, rows)
    if rows:
        show_table(("run", "drop height", "impact speed", "e ± u_e", "g", "status"), rows)
    is_gone = isinstance(error, SourceError) and session.discard_empty()
    session.close()
    if error is not None:
        status = fail(error)
        if is_gone:
            typer.echo(f"Nothing was recorded: {session.path} was taken away again.", err=True)
    return status


def _record(experiment: Experiment, n_runs: int, rows: list[tuple[str, ...]]) -> tuple[RadarGuiError | None, int]:
    """Fill `rows` and return what ended the recording early, and the exit status of what did not.

    Of a run its row is kept, not its samples: there may be a night full of runs.
    """
    status = 0
    try:
        for run in experiment.record(n_runs):
            rows.append(_row(run))
            first = run.result if len(rows) == 1 else None
            if first and first.setup.calibration.content and (check := check_calibration(first)):
                typer.echo(f"Calibration: {check.words}.", err=not check.holds)
            if run.error is not None:
                fail(run.error, run.path.name if run.path else "")
                status = FAILED
            elif run.path is None:
                return RadarGuiError(run.message), FAILED
    except RadarGuiError as error:
        return error, FAILED
    except KeyboardInterrupt:
        kept = f"What was recorded is kept in {experiment.session.path}."
        return RadarGuiError(f"interrupted in run {len(rows) + 1}.", remedy=kept), FAILED
    return None, status


def _about(options: Record, like: SessionInfo | None) -> SessionDetails:
    """Return what is known of the session: as the options say it, else as of the one that it is like."""
    operator, sample, target = (getattr(options, key) or getattr(like, key, "") for key in _LIKE)
    about: SessionDetails = {"operator": operator, "sample": sample, "target": target, "notes": options.notes}
    if options.setup is not None:
        return {**about, **about_setup_file(options.setup)}
    if like is not None:
        return {**about, "calibration": like.calibration, "setup_name": like.setup_name}
    return {**about, "calibration": CalibrationRecord(origin="shipped default setup")}


def _setup(options: Record, like: SessionInfo | None) -> Setup:
    positive("--seconds", options.seconds)
    if options.source not in (kinds := source_kinds()):
        wrong = f"--source = {options.source!r} is not one of {', '.join(kinds)}"
        raise UsageError(wrong, remedy="See radargui record --help.")
    if (options.source == "replay") != (options.file is not None):
        raise UsageError("--source replay and --file FILE go together, allowed: both or neither")
    if options.seed is not None and options.source != "simulated":
        raise UsageError(f"--seed = {options.seed}, allowed: only with --source simulated")
    if options.fast and options.source not in ("simulated", "replay"):
        raise UsageError("--fast, allowed: only with --source simulated or replay; a device keeps its own time")
    if like is not None and options.setup is not None:
        raise UsageError("--like and --setup, allowed: one of them")
    setup = like.setup if like else own_setup_of(options.file) if options.file and options.setup is None else None
    if setup is None and options.file is not None and options.setup is None and options.file.is_file():
        # the antennas of the shipped setup are not those of this recording
        raise UsageError(f"{options.file} brings no setup", remedy="Give --setup FILE.")
    changes = {"tracer.release_position_m": parse_release(options.release), "simulation.seed": options.seed}
    return changed(setup or named_or_default(options.setup), changes, COMMAND_LINE)


def _make_source(options: Record, setup: Setup, run: int) -> Source:
    repeat = options.hands_free and options.source == "simulated"
    return make_source(options.source, setup, run=run, realtime=not options.fast, repeat=repeat, file=options.file)


def _row(run: RecordedRun) -> tuple[str, ...]:
    name = run.path.stem if run.path else f"run {run.number}"
    if run.result:
        status = run.result.status.replace("_", " ")
    elif run.path:
        status = f"set aside: {run.set_aside}" if run.set_aside else "not processed"
    else:
        status = "not recorded"
    summary = summarise(run.result) if run.result else None
    return (
        name,
        plain(figure_in(summary, "drop_height_m"), 4, "m"),
        plain(figure_in(summary, "impact_speed_m_s"), 4, "m/s"),
        restitution_words(summary),
        gravity_words(summary, "m/s²"),
        status,
    )


_WITH_RESULT = (ExperimentState.RECORDING, ExperimentState.SETTLING, ExperimentState.PROCESSING)
"""In which what stands beside it is of the run under way: live, then preliminary."""


class RecordProgress(Bar):
    """The listener of an experiment.

    Parameters
    ----------
    n_runs
        How many runs are asked for.
    """

    def __init__(self, n_runs: int) -> None:
        super().__init__(TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
        self._n_runs = n_runs
        self._health = ""
        self._so_far = ""

    def __call__(self, event: Event) -> None:
        """Show what happened."""
        if event.kind is EventKind.HEALTH:
            self._health = event.message
        if event.kind is EventKind.WARNING:
            self.say(f"run {event.number}: warning: {one_line(event.message)}", err=True)
        elif event.kind in (EventKind.BOUNCE, EventKind.PRELIMINARY):
            self._so_far = event.message
        elif event.kind is EventKind.RUN:
            self._so_far = ""
            self.say(f"run {event.number}: {_outcome(event.run) or self._health}")
        elif event.kind is not EventKind.RECORDED:
            self._show(event)

    def _show(self, event: Event) -> None:
        # of a run that is processed while the next one is armed nothing is said: the next one is what to watch
        if event.kind is EventKind.PROGRESS and event.state is not ExperimentState.PROCESSING:
            return
        text = f"run {event.number} of {self._n_runs}: {event.state.value}"
        if event.state in (ExperimentState.ARMED, ExperimentState.RECORDING) and self._health:
            text += f", {self._health}"
        if event.state in _WITH_RESULT and self._so_far:
            text += f", {self._so_far}"
        total = 1.0 if event.state is ExperimentState.PROCESSING else None
        self.update(self.shown, description=text, total=total, completed=event.fraction or 0.0)


def _outcome(run: RecordedRun | None) -> str:
    """Return what to say of a run: why it is set aside, else the health of its recording."""
    if run is None:
        return ""
    return one_line(run.message) if run.set_aside else run.health_line
