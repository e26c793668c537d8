"""The commands with their options; the module that does a command's work is loaded when it is called.

Make a command from a class of options; the docstring of the class is its help.
"""

import multiprocessing
import re
from copy import copy
from dataclasses import dataclass
from importlib import import_module
from inspect import Parameter, Signature, cleandoc, signature
from pathlib import Path
from typing import Annotated, Any, Literal, dataclass_transform, get_args, get_origin

import typer
from typer import Argument, Option

from radargui import __version__
from radargui.cli.console import guarded

app = typer.Typer(
    name="radargui",
    help="Record a particle-tracking radar, watch it live, and measure the restitution of a falling sphere.",
    epilog="Without a command the window opens.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
_FIELD = re.compile(r"^(\w+)(?: : (.+))?\n((?: {4}.+\n?)+)", re.MULTILINE)


def described(options: type) -> tuple[str, Signature]:
    """Return a command's help and its signature, each option with its help and what stands for its value."""
    text, _, fields = cleandoc(options.__doc__ or "").partition("\n\nAttributes\n----------\n")
    said = {name: (shown, " ".join(words.split())) for name, shown, words in _FIELD.findall(fields)}
    declared = signature(options)
    parameters = [_with_help(one, *said.get(one.name, ("", ""))) for one in declared.parameters.values()]
    return text, declared.replace(parameters=parameters)


def _with_help(field: Parameter, shown: str, words: str) -> Parameter:
    """Return a field as the library reads it, with its help and what stands for its value; a flag has no --no-."""
    kind, *given = get_args(field.annotation) if get_origin(field.annotation) is Annotated else (field.annotation,)
    option = copy(given[0]) if given else Option(f"--{field.name.replace('_', '-')}")
    option.help, option.metavar = words or option.help, shown or option.metavar
    # a file that cannot be read is told by who reads it: of several the others are taken all the same
    option.readable = False
    annotated: Any = Annotated
    return field.replace(annotation=annotated[kind, option])


@dataclass_transform(frozen_default=True)
class Command:
    """A command: the fields of a class are its options, and what it says of itself and of them is the help.

    `does` is the module below `radargui.cli`, loaded when it is called, and the function in it that takes the options
    and returns the exit status.
    """

    def __init_subclass__(cls, does: str) -> None:
        module, _, function = does.partition(".")
        options_of = dataclass(frozen=True)(cls)

        def run(**options: Any) -> int:
            return int(getattr(import_module(f"radargui.cli.{module}"), function)(options_of(**options)))

        text, declared = described(options_of)
        # the library reads what it parses from the signature
        vars(run)["__signature__"] = declared
        app.command(cls.__name__.lower(), help=text)(run)


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
Correction = Annotated[
    str | None, Option(help="Instead of the setup's: joint, flights, adaptive, published, ellipse, none, a plug-in.")
]
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


@app.callback(invoke_without_command=True)
def window(
    context: typer.Context,
    version: Annotated[
        bool, Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
    opened: Annotated[
        str, Option("--open", metavar="PATH", help="The window with this setup file, session or run.")
    ] = "",
) -> int:
    """Record a particle-tracking radar, watch it live, and measure the restitution of a falling sphere."""
    if context.invoked_subcommand is not None:
        return 0
    from radargui.cli.window import open_window

    return open_window(Path(opened) if opened else None)


class Record(Command, does="record.record_session"):
    """Record drops, process them and save them as a session.

    Attributes
    ----------
    source : KIND
        Where samples come from: simulated, ni, replay, or the name of a plug-in.
    file : FILE
        Recording that `--source replay` plays.
    runs
        How many drops to record.
    seconds
        Record this long without waiting for motion, instead of one drop a run.
    release : X,Y,Z
        Where the sphere's centre hangs before it falls, in m.
    seed
        Seed of the simulated source.
    fast
        Do not keep real time (simulated, replay).
    hands_free
        Go on from drop to drop without a pause, as with a device (simulated, replay).
    operator : NAME
        Who records.
    sample : TEXT
        What is measured: material, make, surface.
    target : TEXT
        What it falls on, or moves in.
    notes : TEXT
        What else is worth knowing.
    like : SESSION
        Set up as in this session: setup, operator, sample, target.
    """

    source: str = "simulated"
    file: Path | None = None
    setup: SetupFile = None
    runs: Annotated[int, Option(min=1)] = 1
    seconds: float | None = None
    release: str | None = None
    output: Output = None
    seed: int | None = None
    fast: bool = False
    hands_free: bool = False
    operator: str = ""
    sample: str = ""
    target: str = ""
    notes: str = ""
    like: Path | None = None


class Process(Command, does="process.process_files"):
    """Turn recordings into tables of track and bounces.

    Attributes
    ----------
    files : [FILE...]
        RadarGUI runs, CSV, MATLAB, TDMS, SigMF; plain binary.
    channels : I1=PATH:VAR,Q1=...
        Which column or variable is which channel; PATH where files differ.
    name : NAME
        Name of the result folder.
    drop : N
        Which of several drops in one record, from 1, instead of the setup's.
    force
        Write over results that are there.
    """

    files: Annotated[list[Path] | None, Argument()] = None
    channels: str | None = None
    rate_hz: Rate = None
    name: str | None = None
    setup: SetupFile = None
    output: Output = None
    correction: Correction = None
    geometry: Geometry = None
    drop: int | None = None
    force: bool = False
    raw: Layout = None


class Report(Command, does="written.report_sessions"):
    """Write PDF, HTML, CSV and JSON of sessions; with `--output` several are also reported together as a series.

    Attributes
    ----------
    sessions : SESSION...
        Session folders: other heights, samples, days.
    paper
        Of the PDF.
    details
        Several pages a run, with all figures, instead of one.
    model
        How e shall depend on the impact speed: constant, power, johnson (v^(-1/4)), viscoelastic, or a law of a
        plug-in; left out: all are compared.
    """

    sessions: Annotated[list[Path], Argument()]
    output: Output = None
    paper: Literal["a4", "letter"] = "a4"
    details: bool = False
    model: Annotated[str | None, Option("--law")] = None


class Figures(Command, does="written.draw_figures"):
    """Write every figure of a session alone, as PDF, SVG and PNG, for a paper.

    Attributes
    ----------
    session : SESSION
        Session folder.
    width : LENGTH
        Of a column of the journal, like 86mm, 3.4in or 8.6cm.
    """

    session: Annotated[Path, Argument()]
    width: str = "86mm"
    output: Output = None


class Export(Command, does="written.export_runs"):
    """Write runs as CSV, MATLAB, NI TDMS or SigMF, with settings and units.

    Attributes
    ----------
    path : SESSION|RUN
        Session folder or run file.
    format_name
        What to write.
    force
        Write over files that are there.
    """

    path: Annotated[Path, Argument()]
    format_name: Annotated[Literal["csv", "mat", "tdms", "sigmf"], Option("--format", show_default=False)]
    output: Output = None
    force: bool = False


class Import(Command, does="process.import_files"):
    """Take recordings of other programs as a new session.

    Attributes
    ----------
    files : [FILE...]
        CSV, MATLAB, TDMS, SigMF, plain binary: each becomes a run.
    channels : I1=VAR,Q1=...
        Which column or variable is which channel; remembered for files with the same names.
    operator : NAME
        Who recorded it.
    notes : TEXT
        What is worth knowing.
    """

    files: Annotated[list[Path] | None, Argument()] = None
    channels: str | None = None
    rate_hz: Rate = None
    setup: SetupFile = None
    output: Output = None
    operator: str = ""
    notes: str = ""
    raw: Layout = None


class Batch(Command, does="batch.run_batch"):
    """Process many runs again, on all cores or on a cluster; goes on where it was interrupted.

    Attributes
    ----------
    workers
        Processes; left out: one a core.
    scheduler : tcp://HOST:PORT
        Work on this Dask cluster instead.
    output
        Write tables below this folder; the runs themselves are left as they are.
    force
        Also runs whose results are up to date.
    """

    paths: Paths
    workers: Annotated[int | None, Option(min=1)] = None
    scheduler: str | None = None
    setup: SetupFile = None
    correction: Correction = None
    geometry: Geometry = None
    output: Output = None
    force: bool = False


class Compare(Command, does="batch.compare_runs"):
    """Show old and new results side by side: with other settings, else those stored before the present ones.

    Attributes
    ----------
    keep
        Store the new results; the old figures stay beside.
    """

    paths: Paths
    setup: SetupFile = None
    correction: Correction = None
    geometry: Geometry = None
    keep: bool = False


class Sessions(Command, does="sessions.list_sessions"):
    """Find sessions by day, operator, sample, setup, coefficient and words.

    Attributes
    ----------
    folder : [FOLDER]
        Sessions below it; left out: your data folder.
    since : DAY
        First day, like 2026-11-20.
    until : DAY
        Last day.
    operator : NAME
        A part of the name.
    sample : TEXT
        A part of what sample or target say.
    setup : NAME|FILE
        A part of the setup's name, or a setup file with the same antennas.
    e : LOW:HIGH
        A first bounce with e in this range.
    text : WORDS
        Words in notes, journal and markers.
    runs
        Show each run.
    """

    folder: Annotated[Path | None, Argument()] = None
    since: str | None = None
    until: str | None = None
    operator: str = ""
    sample: str = ""
    setup: str = ""
    e: str | None = None
    text: str = ""
    runs: bool = False


class Recover(Command, does="sessions.recover_runs"):
    """Finish and process runs that a crash left unfinished.

    Attributes
    ----------
    path : [PATH]
        Folder, session or run; left out: your data folder.
    only_list
        Show them, change nothing.
    """

    path: Annotated[Path | None, Argument()] = None
    only_list: Annotated[bool, Option("--list")] = False


class Devices(Command, does="devices.list_devices"):
    """List the NI devices that can be reached.

    Attributes
    ----------
    remote : HOST:PORT
        NI gRPC device server instead of this computer.
    certificate : FILE
        Certificate (PEM) of a device server with encryption (TLS).
    setup
        Try this setup on its device and show what it does.
    """

    remote: str | None = None
    certificate: str | None = None
    setup: SetupFile = None


class Wiring(Command, does="devices.check_wiring"):
    """Find swapped channels, inverted Q and dead inputs in a guided half minute at the antennas.

    Attributes
    ----------
    source
        The device, or a simulated operator to see how it goes.
    output : FILE
        Write the setup with the proposed settings.
    fast
        Do not keep real time (simulated).
    """

    source: Literal["ni", "simulated"] = "ni"
    setup: SetupFile = None
    output: Path | None = None
    fast: bool = False


class Calibrate(Command, does="calibrate.calibrate_antennas"):
    """Find where the antennas are from known motions of the tracer, or from drops.

    Attributes
    ----------
    files : [FILE...]
        Recordings; a session stands for its runs.
    known : PATH|fall
        What is known of the motion: a path file (TOML, see resources/paths), a table time_s,x_m,y_m,z_m (CSV), or fall;
        once for all FILEs, or once for each in their order.
    output : FILE
        Write the whole setup with the values found here, and the calibration beside it.
    free : tilt,azimuth,...
        What is found: tilt, azimuth, distance, transmitter (its place), release, gravity (its direction),
        polarization; left out:
        tilt, azimuth, distance, release.
    clock
        Instead of the path file's: shared where its times are the recording's.
    operator : NAME
        Who calibrates.
    check : RUN
        Only tell by one drop whether the setup still holds.
    force
        Write over files that are there.
    """

    files: Annotated[list[Path] | None, Argument()] = None
    known: Annotated[list[str] | None, Option("--known")] = None
    setup: SetupFile = None
    output: Path | None = None
    free: str | None = None
    clock: Literal["free", "shared"] | None = None
    operator: str = ""
    check: Path | None = None
    force: bool = False


class Info(Command, does="devices.show_info"):
    """Show versions, driver, OpenGL and paths: what a bug report needs; with --setup which calibration it refers to."""

    setup: SetupFile = None
