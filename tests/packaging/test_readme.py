"""What the README shows is true."""

from __future__ import annotations

import re
from pathlib import Path

from typer.main import get_command

from radargui.cli.app import app

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def test_it_names_every_command_and_no_other() -> None:
    commands = get_command(app).commands  # type: ignore[attr-defined]
    assert set(re.findall(r"^\| `radargui (\w+)", TEXT, re.MULTILINE)) == set(commands)
    assert set(re.findall(r"(?:^|\\)radargui (\w+)", TEXT, re.MULTILINE)) <= set(commands)


def test_a_newcomer_reads_no_more_than_he_needs() -> None:
    assert len(TEXT.splitlines()) < 130
    assert "docs/images/window.png" in TEXT
    assert "py packaging\\dev.py run" in TEXT
