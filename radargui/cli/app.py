"""The commands with their options; what each does is loaded when it is called."""

import multiprocessing
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import typer

from radargui import __version__
from radargui.cli.console import guarded
from radargui.model.errors import RadarGuiError

app = typer.Typer(
    name="radargui",
    help="Record a particle-tracking radar, watch it live, and measure the restitution of a falling sphere.",
    epilog="Without a command the window opens.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

SetupOption = Annotated[Path | None, typer.Option("--setup", metavar="FILE", help="Setup file (TOML).")]
RawOption = Annotated[
    str | None,
    typer.Option(
        "--raw",
        metavar="LAYOUT",
        help="Plain binary: dtype=u2le,channels=5,header=8,rate=31250,scale=8.06e-4,offset=0,skip=300 (type of a "
        "number: i, u or f with its bytes, le or be; numbers a sample; bytes before the first; samples a second; "
        "volts = offset + scale x number; samples left out at the start). Columns count from 0: --channels I1=0,Q1=4.",
    ),
]
RateOption = Annotated[
    float | None, typer.Option("--rate-hz", metavar="R", help="Samples per second where the file has no rate.")
]
PathsArgument = Annotated[
    list[Path], typer.Argument(metavar="PATH...", help="Sessions, runs, or folders of them at any depth.")
]
CorrectionOption = Annotated[
    str | None, typer.Option("--correction", help="Instead of the setup's: joint, adaptive, published, ellipse, none.")
]
GeometryOption = Annotated[str | None, typer.Option("--geometry", help="Instead of the setup's: exact, plane.")]
OutputOption = Annotated[Path | None, typer.Option("--output", metavar="DIR", help="Folder that results go below.")]


def main() -> None:
    """Run the command line and end with its exit status: 0, 1 something failed, 2 wrong usage or bad setup."""
    # a frozen program starts its worker processes by starting itself
    multiprocessing.freeze_support()
    raise SystemExit(guarded(app))


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"radargui {__version__}")
        raise typer.Exit


def open_window() -> int:
    """Open the window and return the exit status when it is closed.

    Raises
    ------
    RadarGuiError
        There is no display.
    """
    headless = sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if headless and "QT_QPA_PLATFORM" not in os.environ:
        raise RadarGuiError(
            "There is no display for the window (DISPLAY and WAYLAND_DISPLAY are unset).",
            remedy="The commands work without one: see radargui --help.",
        )
    from radargui.gui.app import run_window

    return run_window()


@app.callback(invoke_without_command=True)
def window(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> int:
    """Record a particle-tracking radar, watch it live, and measure the restitution of a falling sphere."""
    if context.invoked_subcommand is not None:
        return 0
    return open_window()


@app.command()
def record(
    source: Annotated[
        Literal["simulated", "ni", "replay"], typer.Option(help="Where samples come from.")
    ] = "simulated",
    file: Annotated[Path | None, typer.Option(metavar="FILE", help="Recording that `--source replay` plays.")] = None,
    setup: SetupOption = None,
    runs: Annotated[int, typer.Option(min=1, help="How many drops to record.")] = 1,
    seconds: Annotated[
        float | None, typer.Option(help="Record this long without waiting for motion, instead of one drop a run.")
    ] = None,
    release: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Where the sphere's centre hangs before it falls, in m.")
    ] = None,
    output: OutputOption = None,
    seed: Annotated[int | None, typer.Option(help="Seed of the simulated source.")] = None,
    fast: Annotated[bool, typer.Option("--fast", help="Do not keep real time (simulated, replay).")] = False,
    hands_free: Annotated[
        bool,
        typer.Option(
            "--hands-free", help="Go on from drop to drop without a pause, as with a device (simulated, replay)."
        ),
    ] = False,
    operator: Annotated[str, typer.Option(metavar="NAME", help="Who records.")] = "",
    sample: Annotated[str, typer.Option(metavar="TEXT", help="What is measured: material, make, surface.")] = "",
    target: Annotated[str, typer.Option(metavar="TEXT", help="What it falls on, or moves in.")] = "",
    notes: Annotated[str, typer.Option(metavar="TEXT", help="What else is worth knowing.")] = "",
    like: Annotated[
        Path | None, typer.Option(metavar="SESSION", help="Set up as in this session: setup, operator, sample, target.")
    ] = None,
) -> int:
    """Record drops, process them and save them as a session."""
    from radargui.cli.record import RecordOptions, record_session

    options = RecordOptions(source, file, setup, runs, seconds, release, output, seed, fast, hands_free)
    return record_session(replace(options, operator=operator, sample=sample, target=target, notes=notes, like=like))


@app.command()
def process(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[FILE...]", help="RadarGUI runs, CSV, MATLAB, TDMS, SigMF; plain binary."),
    ] = None,
    channels: Annotated[
        str | None,
        typer.Option(
            metavar="I1=PATH:VAR,Q1=...", help="Which column or variable is which channel; PATH: where files differ."
        ),
    ] = None,
    rate_hz: RateOption = None,
    name: Annotated[str | None, typer.Option(metavar="NAME", help="Name of the result folder.")] = None,
    setup: SetupOption = None,
    output: OutputOption = None,
    correction: CorrectionOption = None,
    geometry: GeometryOption = None,
    force: Annotated[bool, typer.Option("--force", help="Write over results that are there.")] = False,
    raw: RawOption = None,
) -> int:
    """Turn recordings into tables of track and bounces."""
    from radargui.cli.process import ProcessOptions, process_files

    return process_files(
        ProcessOptions(tuple(files or ()), channels, rate_hz, name, setup, output, correction, geometry, force, raw)
    )


@app.command()
def report(
    sessions: Annotated[list[Path], typer.Argument(metavar="SESSION...", help="Session folders.")],
    output: OutputOption = None,
) -> int:
    """Write PDF, HTML, CSV and JSON of sessions."""
    from radargui.cli.written import report_sessions

    return report_sessions(tuple(sessions), output)


@app.command()
def export(
    path: Annotated[Path, typer.Argument(metavar="SESSION|RUN", help="Session folder or run file.")],
    format_name: Annotated[
        Literal["csv", "mat", "tdms", "sigmf"], typer.Option("--format", help="What to write.", show_default=False)
    ],
    output: OutputOption = None,
    force: Annotated[bool, typer.Option("--force", help="Write over files that are there.")] = False,
) -> int:
    """Write runs as CSV, MATLAB, NI TDMS or SigMF, with settings and units."""
    from radargui.cli.written import export_runs

    return export_runs(path, format_name, output, force=force)


@app.command("import")
def import_(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[FILE...]", help="CSV, MATLAB, TDMS, SigMF, plain binary: each becomes a run."),
    ] = None,
    channels: Annotated[
        str | None,
        typer.Option(
            metavar="I1=VAR,Q1=...",
            help="Which column or variable is which channel; remembered for files with the same names.",
        ),
    ] = None,
    rate_hz: RateOption = None,
    setup: SetupOption = None,
    output: OutputOption = None,
    operator: Annotated[str, typer.Option(metavar="NAME", help="Who recorded it.")] = "",
    notes: Annotated[str, typer.Option(metavar="TEXT", help="What is worth knowing.")] = "",
    raw: RawOption = None,
) -> int:
    """Take recordings of other programs as a new session."""
    from radargui.cli.importing import import_files

    return import_files(files or (), channels, rate_hz, setup, output, raw, operator=operator, notes=notes)


@app.command()
def batch(
    paths: PathsArgument,
    workers: Annotated[int | None, typer.Option(min=1, help="Processes; left out: one a core.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="tcp://HOST:PORT", help="Work on this Dask cluster instead.")
    ] = None,
    setup: SetupOption = None,
    correction: CorrectionOption = None,
    geometry: GeometryOption = None,
    output: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Write tables below this folder; the runs themselves are left as they are."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Also runs whose results are up to date.")] = False,
) -> int:
    """Process many runs again, on all cores or on a cluster; goes on where it was interrupted."""
    from radargui.cli.batch import BatchOptions, run_batch

    return run_batch(BatchOptions(tuple(paths), workers, scheduler, setup, correction, geometry, output, force))


@app.command()
def compare(
    paths: PathsArgument,
    setup: SetupOption = None,
    correction: CorrectionOption = None,
    geometry: GeometryOption = None,
    keep: Annotated[bool, typer.Option("--keep", help="Store the new results; the old figures stay beside.")] = False,
) -> int:
    """Show old and new results side by side: with other settings, else those stored before the present ones."""
    from radargui.cli.compare import compare_runs

    return compare_runs(paths, setup, correction, geometry, keep=keep)


@app.command()
def sessions(
    folder: Annotated[
        Path | None, typer.Argument(metavar="[FOLDER]", help="Sessions below it; left out: your data folder.")
    ] = None,
    since: Annotated[str | None, typer.Option(metavar="DAY", help="First day, like 2026-11-20.")] = None,
    until: Annotated[str | None, typer.Option(metavar="DAY", help="Last day.")] = None,
    operator: Annotated[str, typer.Option(metavar="NAME", help="A part of the name.")] = "",
    sample: Annotated[str, typer.Option(metavar="TEXT", help="A part of what sample or target say.")] = "",
    setup: Annotated[
        str,
        typer.Option(metavar="NAME|FILE", help="A part of the setup's name, or a setup file with the same antennas."),
    ] = "",
    e: Annotated[
        str | None, typer.Option("--e", metavar="LOW:HIGH", help="A first bounce with e in this range.")
    ] = None,
    text: Annotated[str, typer.Option(metavar="WORDS", help="Words in notes, journal and markers.")] = "",
    runs: Annotated[bool, typer.Option("--runs", help="Show each run.")] = False,
) -> int:
    """Find sessions by day, operator, sample, setup, coefficient and words."""
    from radargui.cli.sessions import asked, list_sessions

    query = asked(since, until, setup, e, operator=operator, sample=sample, text=text)
    return list_sessions(folder, query, runs=runs)


@app.command()
def recover(
    path: Annotated[
        Path | None, typer.Argument(metavar="[PATH]", help="Folder, session or run; left out: your data folder.")
    ] = None,
    only_list: Annotated[bool, typer.Option("--list", help="Show them, change nothing.")] = False,
) -> int:
    """Finish and process runs that a crash left unfinished."""
    from radargui.cli.recover import recover_runs

    return recover_runs(path, only_list=only_list)


@app.command()
def devices(
    remote: Annotated[
        str | None, typer.Option(metavar="HOST:PORT", help="NI gRPC device server instead of this computer.")
    ] = None,
    certificate: Annotated[
        str | None, typer.Option(metavar="FILE", help="Certificate (PEM) of a device server with encryption (TLS).")
    ] = None,
    setup: Annotated[
        Path | None, typer.Option("--setup", metavar="FILE", help="Try this setup on its device and show what it does.")
    ] = None,
) -> int:
    """List the NI devices that can be reached."""
    from radargui.cli.devices import list_devices

    return list_devices(remote, certificate, setup)


@app.command()
def wiring(
    source: Annotated[
        Literal["ni", "simulated"], typer.Option(help="The device, or a simulated operator to see how it goes.")
    ] = "ni",
    setup: SetupOption = None,
    output: Annotated[
        Path | None, typer.Option("--output", metavar="FILE", help="Write the setup with the proposed settings.")
    ] = None,
    fast: Annotated[bool, typer.Option("--fast", help="Do not keep real time (simulated).")] = False,
) -> int:
    """Find swapped channels, inverted Q and dead inputs in a guided half minute at the antennas."""
    from radargui.cli.wiring import check_wiring

    return check_wiring(source, setup, output, fast=fast)


@app.command()
def info() -> int:
    """Show versions, driver, OpenGL and paths: what a bug report needs."""
    from radargui.cli.info import show_info

    return show_info()
