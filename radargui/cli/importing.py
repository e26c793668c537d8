"""The command import: make a session from recordings of other programs."""

from dataclasses import replace

import typer

from radargui.cli.app import Import
from radargui.cli.bar import progress_bar
from radargui.cli.console import FAILED, fail
from radargui.cli.process import sources_of
from radargui.experiment.importing import ImportOrder, common_setup, guess_of, import_recordings, remember_map
from radargui.files.reading import ChannelMap, ImportInput
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.setup import read_setup
from radargui.session.info import default_data_folder


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
