"""The command line; a headless command loads no Qt."""

import gc

MAX_NEW = 50_000
"""Objects made until those without a reader are looked for: what is loaded at the start stays, and looking through it
again and again is 4 % of a short command (measured on `process` of a run of 10 s)."""


def main() -> None:
    """Run the command line and end with its exit status: 0, 1 something failed, 2 wrong usage or bad setup."""
    gc.set_threshold(MAX_NEW)
    from radargui.cli.app import main as command_line

    command_line()
