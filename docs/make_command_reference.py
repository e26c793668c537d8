"""Write commands.md: every command with its options as the program itself tells them.

python docs/make_command_reference.py
"""

from __future__ import annotations

from pathlib import Path

from typer.main import get_command
from typer.testing import CliRunner

from radargui.cli.app import app

HEAD = """# Commands

Written by `docs/make_command_reference.py` from the program's own help. Without a command the window opens. No other
command needs a display or loads Qt. Exit status: 0 done, 1 something failed, 2 wrong usage or bad setup; an error is
one line on stderr.
"""


def reference() -> str:
    """Return the reference as Markdown."""
    commands = get_command(app).commands  # type: ignore[attr-defined]
    return HEAD + "".join(f"\n## {name}\n\n```text\n{_help(name)}\n```\n" for name in commands)


def _help(name: str) -> str:
    shown = CliRunner().invoke(app, [name, "--help"], prog_name="radargui", terminal_width=100).stdout
    return "\n".join(line.rstrip() for line in shown.strip().splitlines())


if __name__ == "__main__":
    (Path(__file__).parent / "commands.md").write_text(reference(), encoding="utf-8", newline="\n")
