"""`radargui process`: recordings to tables, one folder an input."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import typer

from radargui.cli.app import Process
from radargui.cli.bar import progress_bar, show_table
from radargui.cli.console import fail, fail_unexpected, one_line
from radargui.cli.setup_choice import COMMAND_LINE, own_setup, positive, processing_changes
from radargui.files.formats import format_of
from radargui.files.raw_file import RawLayout, parse_raw_layout
from radargui.files.reading import ChannelMap, parse_channel_map, read_mapped, read_recording
from radargui.files.run_layout import SUFFIX
from radargui.model.errors import RadarGuiError, SetupError, UsageError
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.rounding import UNKNOWN, quantity
from radargui.model.setup import Setup
from radargui.model.setup_change import changed
from radargui.model.setup_file import read_setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.offline import process
from radargui.report.tables import write_tables


@dataclass(frozen=True, slots=True)
class Input:
    """One input: what it is called, how it is read, where its results go.

    Attributes
    ----------
    name
        Of the result folder.
    read
        Gives the recording.
    own_file
        The file that may bring its own setup.
    folder
        Where the tables go.
    """

    name: str
    read: Callable[[], Recording]
    own_file: Path
    folder: Path


def process_files(options: Process) -> int:
    """Process every input, print a table of them, and return the exit status.

    Whatever is wrong with the command, the setup or the result folders is reported before any work.

    Raises
    ------
    UsageError
        Options that do not go together, equal names, results that are there already.
    SetupError
        The setup or an option instead of it is not allowed.
    """
    raw = None if options.raw is None else parse_raw_layout(options.raw)
    inputs = _inputs(options, raw)
    _refuse_collisions(inputs, force=options.force)
    setups = [_setup_of(one, options, raw) for one in inputs]
    rows, status = [], 0
    for one, setup in zip(inputs, setups, strict=True):
        try:
            rows.append(_row(one, _process(one, setup)))
        except RadarGuiError as error:
            status = max(status, fail(error, one.name))
        except Exception as error:  # noqa: BLE001  one input must not take the others with it
            status = max(status, fail_unexpected(error, one.name))
    if rows:
        show_table(("input", "status", "bounces", "e ± u_e", "results"), rows)
    return status


def _process(one: Input, setup: Setup | RadarGuiError) -> RunResult:
    if isinstance(setup, RadarGuiError):
        raise setup
    with progress_bar(one.name) as report_progress:
        result = process(one.read(), setup, report_progress)
        write_tables(result, one.folder)
    for text in ((result.reason,) if result.status != "ok" else ()) + result.warnings:
        typer.echo(f"{one.name}: {one_line(text)}", err=True)
    return result


def _inputs(options: Process, raw: RawLayout | None) -> list[Input]:
    positive("--rate-hz", options.rate_hz)
    channels = None if options.channels is None else parse_channel_map(options.channels, numbered=raw is not None)
    if channels is not None and channels.has_paths and not options.files:
        if options.name is None:
            raise UsageError("--channels with paths forms one input: it needs --name NAME")
        read = partial(read_mapped, channels, rate_hz=options.rate_hz, name=options.name, raw=raw)
        return [_input(options, options.name, read, channels.paths[0])]
    if not options.files:
        raise UsageError("nothing to process, allowed: FILE..., or --channels with paths")
    if options.name is not None and len(options.files) > 1:
        raise UsageError(f"--name = {options.name!r}, allowed: with one input only; there are {len(options.files)}")
    return [_file_input(options, file, channels, raw) for file in options.files]


def _file_input(options: Process, file: Path, channels: ChannelMap | None, raw: RawLayout | None) -> Input:
    read: Callable[[], Recording]
    if file.suffix.lower() == SUFFIX and channels is None and options.rate_hz is None and raw is None:
        # of an hour only the part with the motion is read
        read = partial(read_for_processing, file)
    else:
        read = partial(read_recording, file, channels=channels, rate_hz=options.rate_hz, raw=raw)
    return _input(options, file.stem if options.name is None else options.name, read, file)


def _input(options: Process, name: str, read: Callable[[], Recording], file: Path) -> Input:
    if Path(name).name != name or name in ("", ".", "..") or any(sign in name for sign in '\\:*?"<>|'):
        raise UsageError(f"{name!r} cannot be the name of a folder", remedy="Give another with --name.")
    return Input(name, read, file, (options.output or file.parent) / name)


def _refuse_collisions(inputs: list[Input], *, force: bool) -> None:
    # a system that takes upper and lower case for the same would write one over the other
    count = Counter(one.name.casefold() for one in inputs)
    equal = [str(one.own_file) for one in inputs if count[one.name.casefold()] > 1]
    if equal:
        raise UsageError(f"Inputs of equal name: {', '.join(equal)}", remedy="Process them one by one, with --name.")
    there = [str(one.folder) for one in inputs if one.folder.exists()]
    if there and not force:
        raise UsageError(f"Results are there already: {', '.join(there)}", remedy="Give --force to write over them.")


def _setup_of(one: Input, options: Process, raw: RawLayout | None) -> Setup | RadarGuiError:
    """Return the setup of an input, or why the input cannot be read.

    Raises
    ------
    UsageError
        There is none.
    SetupError
        It is not valid.
    """
    try:
        format_of(one.own_file, raw)
        setup = read_setup(options.setup) if options.setup else own_setup(one.own_file)
    except RadarGuiError as error:
        if isinstance(error, SetupError | UsageError):
            raise
        return error
    if setup is None:
        raise UsageError(f"{one.own_file} brings no setup", remedy="Give --setup FILE.")
    return changed(setup, processing_changes(options.correction, options.geometry), COMMAND_LINE)


def _row(one: Input, result: RunResult) -> tuple[str, ...]:
    bounces = result.bounces.impacts
    first = next((bounce for bounce in bounces if bounce.valid), None)
    e = quantity(first.e, first.u_stated) if first else UNKNOWN
    return (one.name, result.status.replace("_", " "), str(len(bounces)), e, str(one.folder))
