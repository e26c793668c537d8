"""`radargui devices`: list the NI devices that can be reached, and what one of them does with a setup.

`radargui info`: print what a bug report needs. `radargui wiring`: find swapped channels, inverted Q and dead inputs
within a guided half minute.
"""

from collections.abc import Callable, Sequence

import typer

from radargui.cli.app import Devices, Info, Wiring
from radargui.cli.bar import show_table
from radargui.cli.console import fail
from radargui.cli.setup_choice import named_or_default
from radargui.experiment.wiring import WiringGuide
from radargui.files.access import want_room_for
from radargui.model.errors import DeviceError, RadarGuiError, UsageError
from radargui.model.setup import Setup, read_setup, write_setup
from radargui.processing.wiring import WiringReport
from radargui.session.about import about_lines
from radargui.sources.contract import Source
from radargui.sources.factory import at_once, make_source
from radargui.sources.ni.discovery import NiDevice, driver_version, find_devices, no_device
from radargui.sources.ni.driver import split_address
from radargui.sources.ni.source import check_setup


def list_devices(options: Devices, find: Callable[[str | None, str | None], Sequence[NiDevice]] = find_devices) -> int:
    """Print one line a device, and what the device of a setup does with it; return the exit status.

    Parameters
    ----------
    options
        Of the command.
    find
        Returns the devices that a device server, or this computer, has.

    Raises
    ------
    UsageError
        A certificate without a device server, or what is no address of one.
    SetupError
        The setup cannot be used.
    DeviceError
        The driver is missing, the device server cannot be reached, or the device cannot do what the setup says.
    """
    chosen = None if options.setup is None else read_setup(options.setup)
    remote, certificate = options.remote, options.certificate
    if chosen is not None:
        remote, certificate = remote or chosen.daq.remote, certificate or chosen.daq.remote_certificate
    if certificate is not None and remote is None:
        raise UsageError(f"--certificate {certificate}, allowed: with --remote HOST:PORT")
    if options.remote is not None:
        _want_address(options.remote)
    found = find(remote, certificate)
    place = remote or "this computer"
    if not found:
        typer.echo(str(no_device(place, driver_version(remote, certificate) or "")))
    else:
        header = ("name", "product", "serial number", "analog inputs", "fastest", "ranges", "sampling", "triggers")
        show_table(header, [_row(device) for device in found])
    if chosen is not None:
        _try(chosen, remote, certificate)
    return 0


def _want_address(remote: str) -> None:
    try:
        split_address(remote)
    except DeviceError as error:
        raise UsageError(f"--remote: {error.message}", remedy=error.remedy) from None


def _try(setup: Setup, remote: str | None, certificate: str | None) -> None:
    daq = setup.daq.model_copy(update={"remote": remote, "remote_certificate": certificate})
    check = check_setup(setup.model_copy(update={"daq": daq}))
    typer.echo(f"\nThe setup on {check.device.title}:")
    for what, how in check.lines:
        typer.echo(f"  {what:15} {how}")


def _row(device: NiDevice) -> tuple[str, ...]:
    rate = device.max_rate_multi_hz or device.max_rate_single_hz
    notes = [note for note, true in (("simulated", device.simulated), ("not connected", not device.connected)) if true]
    return (
        device.name,
        " ".join([device.product_type or "unknown", *(f"({note})" for note in notes)]),
        device.serial_number or "-",
        str(len(device.channels)),
        f"{rate / 1000:g} kS/s {'each' if device.simultaneous else 'in all'}" if rate else "-",
        _ranges(device.ranges_v),
        "simultaneous" if device.simultaneous else "multiplexed",
        _triggers(device),
    )


def _ranges(ranges_v: tuple[tuple[float, float], ...]) -> str:
    both = [f"{high:g}" for low, high in ranges_v if low == -high]
    others = [f"{low:g} to {high:g} V" for low, high in ranges_v if low != -high]
    return ", ".join([*([f"±{' '.join(both)} V"] if both else []), *others]) or "-"


def _triggers(device: NiDevice) -> str:
    lines = device.trigger_lines
    shown = lines if len(lines) <= 4 else (f"{lines[0]}..{lines[-1].lstrip('PFIRTSXig_')}",)
    kinds = [
        *shown,
        *(["analog"] if device.analog_trigger else []),
        *(["pre-trigger"] if device.reference_trigger else []),
    ]
    return " ".join(kinds) or "-"


def show_info(options: Info) -> int:
    """Print one fact a line and return the exit status.

    Raises
    ------
    SetupError
        The setup file cannot be used.
    """
    for line in about_lines(named_or_default(options.setup)):
        typer.echo(line)
    return 0


def check_wiring(options: Wiring) -> int:
    """Guide the operator through the check, print what was found, and return the exit status: 0 where all is right.

    Raises
    ------
    UsageError
        Options that do not go together.
    SetupError
        The setup cannot be used or written.
    FileError
        The setup to write cannot be written there.
    SourceError
        The device failed.
    """
    if options.fast and options.source == "ni":
        raise UsageError("--fast, allowed: only with --source simulated; a device keeps its own time")
    chosen = named_or_default(options.setup)
    if options.output is not None:
        want_room_for(options.output)
    report = guided(_source(options, chosen), chosen)
    for finding in report.findings:
        typer.echo(f"{'ok  ' if finding.kind == 'good' else 'BAD '} {finding}")
    for line in report.settings():
        typer.echo(f"proposed: {line}")
    if report.corrects and options.output is not None:
        write_setup(report.corrected(chosen), options.output)
        typer.echo(f"Setup with the proposed settings: {options.output}")
    if report.is_good:
        typer.echo("The wiring is right.")
        return 0
    wrong = sum(finding.kind != "good" for finding in report.findings)
    remedy = "Correct it, or take the settings proposed (--output FILE writes them), and check again."
    return fail(RadarGuiError(f"the wiring is not right: {wrong} finding{'s'[: wrong > 1]}.", remedy=remedy))


def guided(source: Source, setup: Setup) -> WiringReport:
    """Read a source while the operator is shown what to do; return what was found.

    Raises
    ------
    SourceError
        The source failed, or ended before the check did.
    """
    try:
        guide = WiringGuide(setup, source.open())
        source.start()
        announced = 0
        while not guide.is_done:
            announced = _announce(guide, announced)
            block = source.read()
            if block is None:
                raise RadarGuiError("The samples ended before the wiring check did.", remedy="Check again.")
            guide.push(block)
    finally:
        source.stop()
        source.close()
    return guide.report()


def _announce(guide: WiringGuide, announced: int) -> int:
    """Print what comes next, once; return the number of the step announced."""
    state = guide.state()
    if state.step is None or state.number == announced:
        return announced
    step = state.step
    ready_s, measured_s = step.start_s - step.announce_s, step.end_s - step.start_s
    typer.echo(f"{state.number} of {state.total}: in {ready_s:g} s, for {measured_s:g} s: {step.instruction}")
    return state.number


def _source(options: Wiring, setup: Setup) -> Source:
    if options.source == "simulated":
        from radargui.sources.simulated.model import WiringScene

        return WiringScene(setup, realtime=not options.fast)
    return make_source("ni", at_once(setup))
