"""`radargui import`: recordings of other programs as a session."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import typer

from radargui.cli.console import progress_bar
from radargui.cli.guard import FAILED, fail
from radargui.cli.setup_choice import positive
from radargui.files.channel_map import ChannelMap, list_channels, parse_channel_map
from radargui.files.formats import RUN, format_of
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.setup import Setup
from radargui.model.setup_file import read_setup
from radargui.session.data_folder import default_data_folder
from radargui.session.importing import Import, ImportInput, own_setup_of
from radargui.session.info import calibration_of_file
from radargui.session.map_memory import MapMemory


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """What the command line asked for; None where nothing was said."""

    files: tuple[Path, ...] = ()
    channels: str | None = None
    rate_hz: float | None = None
    setup: Path | None = None
    output: Path | None = None
    operator: str = ""
    notes: str = ""


def import_files(options: ImportOptions) -> int:
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
    positive("--rate-hz", options.rate_hz)
    status, inputs = _inputs(options)
    if not inputs:
        return status
    setup = read_setup(options.setup) if options.setup else _own_setup(inputs)
    work = Import(
        options.output or default_data_folder(),
        setup,
        now=datetime.now().astimezone(),
        operator=options.operator,
        notes=options.notes,
        calibration=calibration_of_file(options.setup) if options.setup else None,
        setup_name=options.setup.stem if options.setup else "",
    )
    lines = []
    with progress_bar("import") as tell:
        for run in work.carry_out(inputs, tell):
            if run.error is not None:
                status = fail(run.error, run.source.told) and FAILED
            elif run.path is not None:
                lines.append(f"{run.path.name}: {run.source.told}")
    if work.session is not None:
        typer.echo(f"Session: {work.session.path}")
    for line in lines:
        typer.echo(line)
    return status


def _inputs(options: ImportOptions) -> tuple[int, list[ImportInput]]:
    chosen = parse_channel_map(options.channels) if options.channels else None
    if chosen is not None and chosen.has_paths:
        if options.files:
            raise UsageError("--channels names files of its own: give no FILE with it")
        return 0, [ImportInput(chosen.paths, chosen, options.rate_hz)]
    if not options.files:
        raise UsageError("nothing to import, allowed: FILE..., or --channels with paths")
    status, inputs = 0, []
    for file in options.files:
        try:
            inputs.append(ImportInput((file,), _map_of(file, chosen), options.rate_hz))
        except RadarGuiError as error:
            status = fail(error, str(file)) and FAILED
    return status, inputs


def _map_of(file: Path, chosen: ChannelMap | None) -> ChannelMap | None:
    """Return the map of a file: chosen and from now on remembered, else remembered or guessed, which is told."""
    if format_of(file) is RUN and chosen is None:
        return None
    infos = list_channels(file)
    memory = MapMemory()
    if chosen is not None:
        memory.remember(infos, chosen)
        return chosen
    guess = memory.guess(infos)
    if guess.channel_map is not None and guess.basis != "names":
        told = ",".join(f"{entry.target}={entry.variable}" for entry in guess.channel_map.entries)
        why = (
            "as chosen before" if guess.basis == "remembered" else "guessed from the order, correct it with --channels"
        )
        typer.echo(f"{file.name}: {told} ({why})", err=True)
    return guess.channel_map


def _own_setup(inputs: list[ImportInput]) -> Setup:
    for one in inputs:
        try:
            setup = own_setup_of(one.files[0])
        except RadarGuiError:
            continue
        if setup is not None:
            return setup
    raise UsageError(f"{inputs[0].told} brings no setup", remedy="Give --setup FILE.")
