"""`radargui wiring`: find swapped channels, inverted Q and dead inputs within a guided half minute."""

import typer

from radargui.cli.app import Wiring
from radargui.cli.console import fail
from radargui.cli.setup_choice import named_or_default
from radargui.experiment.wiring import WiringGuide
from radargui.files.access import want_room_for
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.setup import Setup, write_setup
from radargui.processing.wiring import WiringReport
from radargui.sources.contract import Source
from radargui.sources.factory import at_once, make_source


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
