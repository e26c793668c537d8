"""The commands with their options; what each does is loaded when it is called."""

import multiprocessing
import os
import sys
from dataclasses import dataclass
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import Annotated, Any, Literal, dataclass_transform

import typer
from typer import Argument, Option

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

SetupFile = Annotated[Path | None, Option("--setup", metavar="FILE", help="Setup file (TOML).")]
Layout = Annotated[
    str | None,
    Option(
        metavar="LAYOUT",
        help="Plain binary: dtype=u2le,channels=5,header=8,rate=31250,scale=8.06e-4,offset=0,skip=300 (type of a "
        "number: i, u or f with its bytes, le or be; numbers a sample; bytes before the first; samples a second; "
        "volts = offset + scale x number; samples left out at the start). Columns count from 0: --channels I1=0,Q1=4.",
    ),
]
Rate = Annotated[float | None, Option(metavar="R", help="Samples per second where the file has no rate.")]
Paths = Annotated[list[Path], Argument(metavar="PATH...", help="Sessions, runs, or folders of them at any depth.")]
Correction = Annotated[str | None, Option(help="Instead of the setup's: joint, adaptive, published, ellipse, none.")]
Geometry = Annotated[str | None, Option(help="Instead of the setup's: exact, plane.")]
Output = Annotated[Path | None, Option(metavar="DIR", help="Folder that results go below.")]


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
        bool, Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> int:
    """Record a particle-tracking radar, watch it live, and measure the restitution of a falling sphere."""
    return open_window() if context.invoked_subcommand is None else 0


@dataclass_transform(frozen_default=True)
class Command:
    """A command: the fields of a class are its options, and what it says of itself is the help.

    `does` is the module below `radargui.cli`, loaded when it is called, and the function in it that takes the options
    and returns the exit status.
    """

    def __init_subclass__(cls, does: str) -> None:
        module, _, function = does.partition(".")
        options_of = dataclass(frozen=True)(cls)

        def run(**options: Any) -> int:
            return int(getattr(import_module(f"radargui.cli.{module}"), function)(options_of(**options)))

        # the library reads what it parses from the signature
        vars(run)["__signature__"] = signature(options_of)
        app.command(cls.__name__.lower(), help=cls.__doc__)(run)


class Record(Command, does="record.record_session"):
    """Record drops, process them and save them as a session."""

    source: Annotated[Literal["simulated", "ni", "replay"], Option(help="Where samples come from.")] = "simulated"
    file: Annotated[Path | None, Option(metavar="FILE", help="Recording that `--source replay` plays.")] = None
    setup: SetupFile = None
    runs: Annotated[int, Option(min=1, help="How many drops to record.")] = 1
    seconds: Annotated[
        float | None, Option(help="Record this long without waiting for motion, instead of one drop a run.")
    ] = None
    release: Annotated[
        str | None, Option(metavar="X,Y,Z", help="Where the sphere's centre hangs before it falls, in m.")
    ] = None
    output: Output = None
    seed: Annotated[int | None, Option(help="Seed of the simulated source.")] = None
    fast: Annotated[bool, Option("--fast", help="Do not keep real time (simulated, replay).")] = False
    hands_free: Annotated[
        bool,
        Option("--hands-free", help="Go on from drop to drop without a pause, as with a device (simulated, replay)."),
    ] = False
    operator: Annotated[str, Option(metavar="NAME", help="Who records.")] = ""
    sample: Annotated[str, Option(metavar="TEXT", help="What is measured: material, make, surface.")] = ""
    target: Annotated[str, Option(metavar="TEXT", help="What it falls on, or moves in.")] = ""
    notes: Annotated[str, Option(metavar="TEXT", help="What else is worth knowing.")] = ""
    like: Annotated[
        Path | None, Option(metavar="SESSION", help="Set up as in this session: setup, operator, sample, target.")
    ] = None


class Process(Command, does="process.process_files"):
    """Turn recordings into tables of track and bounces."""

    files: Annotated[
        list[Path] | None, Argument(metavar="[FILE...]", help="RadarGUI runs, CSV, MATLAB, TDMS, SigMF; plain binary.")
    ] = None
    channels: Annotated[
        str | None,
        Option(
            metavar="I1=PATH:VAR,Q1=...", help="Which column or variable is which channel; PATH where files differ."
        ),
    ] = None
    rate_hz: Rate = None
    name: Annotated[str | None, Option(metavar="NAME", help="Name of the result folder.")] = None
    setup: SetupFile = None
    output: Output = None
    correction: Correction = None
    geometry: Geometry = None
    force: Annotated[bool, Option("--force", help="Write over results that are there.")] = False
    raw: Layout = None


class Report(Command, does="written.report_sessions"):
    """Write PDF, HTML, CSV and JSON of sessions."""

    sessions: Annotated[list[Path], Argument(metavar="SESSION...", help="Session folders.")]
    output: Output = None


class Export(Command, does="written.export_runs"):
    """Write runs as CSV, MATLAB, NI TDMS or SigMF, with settings and units."""

    path: Annotated[Path, Argument(metavar="SESSION|RUN", help="Session folder or run file.")]
    format_name: Annotated[
        Literal["csv", "mat", "tdms", "sigmf"], Option("--format", help="What to write.", show_default=False)
    ]
    output: Output = None
    force: Annotated[bool, Option("--force", help="Write over files that are there.")] = False


class Import(Command, does="importing.import_files"):
    """Take recordings of other programs as a new session."""

    files: Annotated[
        list[Path] | None,
        Argument(metavar="[FILE...]", help="CSV, MATLAB, TDMS, SigMF, plain binary: each becomes a run."),
    ] = None
    channels: Annotated[
        str | None,
        Option(
            metavar="I1=VAR,Q1=...",
            help="Which column or variable is which channel; remembered for files with the same names.",
        ),
    ] = None
    rate_hz: Rate = None
    setup: SetupFile = None
    output: Output = None
    operator: Annotated[str, Option(metavar="NAME", help="Who recorded it.")] = ""
    notes: Annotated[str, Option(metavar="TEXT", help="What is worth knowing.")] = ""
    raw: Layout = None


class Batch(Command, does="batch.run_batch"):
    """Process many runs again, on all cores or on a cluster; goes on where it was interrupted."""

    paths: Paths
    workers: Annotated[int | None, Option(min=1, help="Processes; left out: one a core.")] = None
    scheduler: Annotated[str | None, Option(metavar="tcp://HOST:PORT", help="Work on this Dask cluster instead.")] = (
        None
    )
    setup: SetupFile = None
    correction: Correction = None
    geometry: Geometry = None
    output: Annotated[
        Path | None,
        Option(metavar="DIR", help="Write tables below this folder; the runs themselves are left as they are."),
    ] = None
    force: Annotated[bool, Option("--force", help="Also runs whose results are up to date.")] = False


class Compare(Command, does="compare.compare_runs"):
    """Show old and new results side by side: with other settings, else those stored before the present ones."""

    paths: Paths
    setup: SetupFile = None
    correction: Correction = None
    geometry: Geometry = None
    keep: Annotated[bool, Option("--keep", help="Store the new results; the old figures stay beside.")] = False


class Sessions(Command, does="sessions.list_sessions"):
    """Find sessions by day, operator, sample, setup, coefficient and words."""

    folder: Annotated[
        Path | None, Argument(metavar="[FOLDER]", help="Sessions below it; left out: your data folder.")
    ] = None
    since: Annotated[str | None, Option(metavar="DAY", help="First day, like 2026-11-20.")] = None
    until: Annotated[str | None, Option(metavar="DAY", help="Last day.")] = None
    operator: Annotated[str, Option(metavar="NAME", help="A part of the name.")] = ""
    sample: Annotated[str, Option(metavar="TEXT", help="A part of what sample or target say.")] = ""
    setup: Annotated[
        str, Option(metavar="NAME|FILE", help="A part of the setup's name, or a setup file with the same antennas.")
    ] = ""
    e: Annotated[str | None, Option("--e", metavar="LOW:HIGH", help="A first bounce with e in this range.")] = None
    text: Annotated[str, Option(metavar="WORDS", help="Words in notes, journal and markers.")] = ""
    runs: Annotated[bool, Option("--runs", help="Show each run.")] = False


class Recover(Command, does="sessions.recover_runs"):
    """Finish and process runs that a crash left unfinished."""

    path: Annotated[
        Path | None, Argument(metavar="[PATH]", help="Folder, session or run; left out: your data folder.")
    ] = None
    only_list: Annotated[bool, Option("--list", help="Show them, change nothing.")] = False


class Devices(Command, does="devices.list_devices"):
    """List the NI devices that can be reached."""

    remote: Annotated[
        str | None, Option(metavar="HOST:PORT", help="NI gRPC device server instead of this computer.")
    ] = None
    certificate: Annotated[
        str | None, Option(metavar="FILE", help="Certificate (PEM) of a device server with encryption (TLS).")
    ] = None
    setup: Annotated[
        Path | None, Option(metavar="FILE", help="Try this setup on its device and show what it does.")
    ] = None


class Wiring(Command, does="wiring.check_wiring"):
    """Find swapped channels, inverted Q and dead inputs in a guided half minute at the antennas."""

    source: Annotated[
        Literal["ni", "simulated"], Option(help="The device, or a simulated operator to see how it goes.")
    ] = "ni"
    setup: SetupFile = None
    output: Annotated[Path | None, Option(metavar="FILE", help="Write the setup with the proposed settings.")] = None
    fast: Annotated[bool, Option("--fast", help="Do not keep real time (simulated).")] = False


class Info(Command, does="info.show_info"):
    """Show versions, driver, OpenGL and paths: what a bug report needs."""
