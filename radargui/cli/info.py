"""`radargui info`: print what a bug report needs."""

import typer

from radargui.cli.app import Info
from radargui.cli.setup_choice import named_or_default
from radargui.session.about import about_lines


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
