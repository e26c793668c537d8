"""`radargui compare`: results of runs side by side, stored ones or such with other settings."""

import typer

from radargui.cli.app import Compare
from radargui.cli.bar import progress_bar, show_table
from radargui.cli.console import FAILED, fail
from radargui.cli.setup_choice import processing_changes
from radargui.experiment.batch.task import find_runs
from radargui.experiment.compare import ComparedFigure, Comparison, compare_stored, reprocess_runs
from radargui.experiment.reprocess import Outcome, each_run
from radargui.model.errors import UsageError
from radargui.model.rounding import UNKNOWN, alone, quantity
from radargui.model.setup_file import read_setup
from radargui.restitution.series import statistics_of


def compare_runs(options: Compare) -> int:
    """Print the old and the new result of each run, what was set differently, and return the exit status.

    Where nothing else is set, the stored results are compared.

    Raises
    ------
    UsageError
        Options that do not go together.
    SetupError
        The setup or an option instead of it is not allowed.
    """
    wanted = processing_changes(options.correction, options.geometry)
    if options.keep and not (wanted or options.setup):
        raise UsageError("--keep, allowed: together with --setup, --correction or --geometry")
    setup = read_setup(options.setup) if options.setup else None
    found = find_runs(options.paths)
    status = max(map(fail, found.errors), default=0)
    runs = [one.path for one in found.runs]
    with progress_bar("compare") as report:
        outcomes: list[Outcome[Comparison | None]]
        if setup is not None or wanted:
            outcomes = [*reprocess_runs(runs, setup, wanted, keep=options.keep, progress=report)]
        else:
            outcomes = [*each_run(runs, lambda run, _report: compare_stored(run), report)]
    for outcome in outcomes:
        if outcome.error is not None:
            status = fail(outcome.error, str(outcome.run)) and FAILED
        elif outcome.value is None:
            typer.echo(f"{outcome.run}: no result before the present one")
    _show([outcome.value for outcome in outcomes if outcome.value is not None])
    return status


def _show(compared: list[Comparison]) -> None:
    if not compared:
        return
    header = ("run", "e before", "e after", "difference", "g before", "g after", "status before", "status after")
    show_table(header, [_row(one) for one in compared])
    pairs = [(e.before, e.after) for one in compared if (e := _figure(one, "e")).difference is not None]
    if len(pairs) > 1:
        before, after = (statistics_of(side) for side in zip(*pairs, strict=True))
        change = statistics_of(e.difference for one in compared if (e := _figure(one, "e")))
        typer.echo(
            f"mean e of {len(pairs)} runs: {before.words()} before, {after.words()} after, "
            f"{alone(change.mean, after.standard_error, signed=True)}"
        )
    shown = None
    for one in compared:
        settings = [f"{each.key}: {_value(each.before)} -> {_value(each.after)}" for each in one.settings]
        if settings != shown:
            typer.echo(f"set differently ({one.run.name}): " + ("; ".join(settings) or "nothing"))
        shown = settings


def _row(one: Comparison) -> tuple[str, ...]:
    e, g = _figure(one, "e"), _figure(one, "g_m_s2")
    return (
        f"{one.run.parent.name}/{one.run.stem}",
        quantity(e.before, e.u_before),
        quantity(e.after, e.u_after),
        alone(e.difference, e.u_difference, signed=True),
        quantity(g.before, g.u_before),
        quantity(g.after, g.u_after),
        *(str(side.summary.get("status", UNKNOWN)).replace("_", " ") for side in (one.before, one.after)),
    )


def _figure(one: Comparison, name: str) -> ComparedFigure:
    return next(figure for figure in one.figures if figure.name == name)


def _value(value: object) -> str:
    return "left out" if value is None else str(value)
