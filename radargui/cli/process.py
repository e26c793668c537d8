"""The command process: compute tables of track and bounces from recordings of any format.

The command import: make a session from recordings of other programs.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import typer

from radargui.cli.app import Import, Process
from radargui.cli.bar import progress_bar, show_table
from radargui.cli.console import FAILED, fail, fail_unexpected, one_line
from radargui.cli.setup_choice import COMMAND_LINE, positive, processing_changes
from radargui.experiment.importing import ImportOrder, common_setup, guess_of, import_recordings, remember_map
from radargui.files.access import make_folder
from radargui.files.formats import format_of, own_setup_of
from radargui.files.raw_file import parse_raw_layout
from radargui.files.reading import ChannelMap, ImportInput, parse_channel_map
from radargui.model.errors import RadarGuiError, SetupError, UsageError
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.rounding import UNKNOWN, quantity
from radargui.model.setup import Setup, changed, read_setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import process
from radargui.report.tables import write_tables
from radargui.session.info import default_data_folder
from radargui.system.cores import on_cores

Input = tuple[ImportInput, Path]
"""What is read, and the folder that its tables go to, which has its name."""


Compute = Callable[[Recording, Setup, Callable[[float], None]], RunResult]
"""Turns a recording into its result, and tells the share done."""


def process_files(options: Process, compute: Compute = process) -> int:
    """Process every input, print a table of them, and return the exit status.

    Whatever is wrong with the command, the setup or the result folders is reported before any work.

    Parameters
    ----------
    options
        Of the command.
    compute
        Makes the result of each recording.

    Raises
    ------
    UsageError
        Options that do not go together, equal names, results that are there already.
    SetupError
        The setup or an option instead of it is not allowed.
    """
    inputs = _inputs(options)
    _refuse_collisions(inputs, force=options.force)
    setups = [_setup_of(source, options) for source, _ in inputs]
    rows, status = [], 0
    with on_cores():
        for (source, folder), setup in zip(inputs, setups, strict=True):
            try:
                rows.append(_row(folder, _process(source, folder, setup, compute)))
            except RadarGuiError as error:
                status = max(status, fail(error, folder.name))
            except Exception as error:  # noqa: BLE001  one input must not take the others with it
                status = max(status, fail_unexpected(error, folder.name))
    if rows:
        show_table(("input", "status", "bounces", "e ± u_e", "results"), rows)
    return status


def _process(source: ImportInput, folder: Path, setup: Setup | RadarGuiError, compute: Compute) -> RunResult:
    if isinstance(setup, RadarGuiError):
        raise setup
    _want_room(folder)
    # of an hour only the part with the motion is read
    is_plain = source.channel_map is None and source.rate_hz is None and source.raw is None
    with progress_bar(folder.name) as report_progress:
        recording = read_for_processing(source.files[0]) if is_plain else source.read()
        result = compute(recording, setup, report_progress)
        write_tables(result, folder)
    for text in ((result.reason,) if result.status != "ok" else ()) + result.warnings:
        typer.echo(f"{folder.name}: {one_line(text)}", err=True)
    return result


def _want_room(folder: Path) -> None:
    """Refuse, with a FileError, a folder of results that cannot be made: computing them takes a while."""
    if folder.is_dir():
        return
    make_folder(folder)
    # the tables make it again: one without them would be taken for results
    folder.rmdir()


def sources_of(options: Process | Import) -> list[ImportInput]:
    """Return the inputs of a command: one from several files, or one from each; raises UsageError where none is."""
    positive("--rate-hz", options.rate_hz)
    raw = None if options.raw is None else parse_raw_layout(options.raw)
    channels = None if options.channels is None else parse_channel_map(options.channels, numbered=raw is not None)
    if channels is not None and channels.has_paths:
        if options.files:
            raise UsageError("--channels names files of its own: give no FILE with it")
        return [ImportInput(channels.paths, channels, options.rate_hz, raw)]
    if not options.files:
        what = type(options).__name__.lower()
        raise UsageError(f"nothing to {what}, allowed: FILE..., or --channels with paths")
    return [ImportInput((file,), channels, options.rate_hz, raw) for file in options.files]


def _inputs(options: Process) -> list[Input]:
    sources, name = sources_of(options), options.name
    channels = sources[0].channel_map
    if channels is not None and channels.has_paths and name is None:
        raise UsageError("--channels with paths forms one input: it needs --name NAME")
    if name is not None and len(sources) > 1:
        raise UsageError(f"--name = {name!r}, allowed: with one input only; there are {len(sources)}")
    return [_input(options, one.files[0].stem if name is None else name, one) for one in sources]


def _input(options: Process, name: str, source: ImportInput) -> Input:
    if Path(name).name != name or name in ("", ".", "..") or any(sign in name for sign in '\\:*?"<>|'):
        raise UsageError(f"{name!r} cannot be the name of a folder", remedy="Give another with --name.")
    return replace(source, name=name), (options.output or source.files[0].parent) / name


def _refuse_collisions(inputs: list[Input], *, force: bool) -> None:
    # a system that takes upper and lower case for the same would write one over the other
    count = Counter(folder.name.casefold() for _, folder in inputs)
    equal = [str(source.files[0]) for source, folder in inputs if count[folder.name.casefold()] > 1]
    if equal:
        raise UsageError(f"Inputs of equal name: {', '.join(equal)}", remedy="Process them one by one, with --name.")
    # a folder given as an input is refused as one, not for what is in it
    by_itself = [folder for source, folder in inputs if folder in source.files]
    if own := [str(folder) for folder in by_itself if folder.is_file()]:
        raise UsageError(f"The results of {', '.join(own)} would be a folder of that name", remedy="Give --name.")
    there = [str(folder) for _, folder in inputs if folder.exists() and folder not in by_itself]
    if there and not force:
        raise UsageError(f"Results are there already: {', '.join(there)}", remedy="Give --force to write over them.")


def _setup_of(source: ImportInput, options: Process) -> Setup | RadarGuiError:
    """Return the setup of an input by its first file, or why that cannot be read.

    Raises
    ------
    UsageError
        There is none.
    SetupError
        It is not valid.
    """
    file = source.files[0]
    try:
        format_of(file, source.raw)
        setup = read_setup(options.setup) if options.setup else None if source.raw else own_setup_of(file)
    except RadarGuiError as error:
        if isinstance(error, SetupError | UsageError):
            raise
        return error
    if setup is None:
        raise UsageError(f"{file} brings no setup", remedy="Give --setup FILE.")
    return changed(setup, processing_changes(options.correction, options.geometry, options.drop), COMMAND_LINE)


def _row(folder: Path, result: RunResult) -> tuple[str, ...]:
    bounces = result.bounces.impacts
    first = next((bounce for bounce in bounces if bounce.valid), None)
    e = quantity(first.e, first.u_stated) if first else UNKNOWN
    return (folder.name, result.status.replace("_", " "), str(len(bounces)), e, str(folder))


def import_files(options: Import) -> int:
    """Write the recordings as a new session, print its folder and what became of each, and return the exit status.

    Raises
    ------
    UsageError
        Options that do not go together, or no setup.
    SetupError
        The setup is not valid.
    SessionError
        The session cannot be made.
    """
    status, inputs = _imports(options)
    if not inputs:
        return status
    setup = read_setup(options.setup) if options.setup else common_setup([one.files[0] for one in inputs])
    if setup is None:
        raise UsageError(f"{inputs[0].label} brings no setup", remedy="Give --setup FILE.")
    folder = options.output or default_data_folder()
    words = {"operator": options.operator, "notes": options.notes}
    order = ImportOrder(lambda: inputs, setup, options.setup, folder, process=False, **words)
    with progress_bar("import") as report:
        imported = import_recordings(order, report)
    for run in imported.runs:
        if run.error is not None:
            status = fail(run.error, run.source.label) and FAILED
    if imported.session is not None:
        typer.echo(f"Session: {imported.session}")
    for run in imported.runs:
        if run.path is not None:
            typer.echo(f"{run.path.name}: {run.source.label}")
    return status


def _imports(options: Import) -> tuple[int, list[ImportInput]]:
    status, inputs = 0, []
    for one in sources_of(options):
        try:
            inputs.append(replace(one, channel_map=_map_of(one)))
        except RadarGuiError as error:
            status = fail(error, one.label) and FAILED
    return status, inputs


def _map_of(source: ImportInput) -> ChannelMap | None:
    """Return the map of an input: chosen and from now on remembered, else remembered or guessed, which is said."""
    file, chosen = source.files[0], source.channel_map
    if chosen is not None:
        # one that names its files is for these alone
        if not chosen.has_paths:
            remember_map(file, chosen, source.raw)
        return chosen
    guess = guess_of(file, source.raw)
    if guess is None:
        return None
    if guess.channel_map is not None and guess.basis != "names":
        said = ",".join(f"{entry.target}={entry.variable}" for entry in guess.channel_map.entries)
        guessed = "guessed from the order, correct it with --channels"
        why = "as chosen before" if guess.basis == "remembered" else guessed
        typer.echo(f"{file.name}: {said} ({why})", err=True)
    return guess.channel_map
