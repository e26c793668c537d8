"""What the README shows is true."""

from __future__ import annotations

import re
from pathlib import Path

from typer.main import get_command

from radargui.cli.app import app
from radargui.model.setup import parse_setup

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_setup_it_shows_is_a_valid_one() -> None:
    (block,) = re.findall(r"```toml\n(.*?)```", TEXT, re.DOTALL)
    assert parse_setup(block).n_receivers == 3


def test_it_names_every_command_and_no_other() -> None:
    commands = get_command(app).commands  # type: ignore[attr-defined]
    assert set(re.findall(r"^\| `radargui (\w+)", TEXT, re.MULTILINE)) == set(commands)
    assert set(re.findall(r"(?:^|\\)radargui (\w+)", TEXT, re.MULTILINE)) <= set(commands)


def test_the_folders_it_lists_are_there_and_every_package_is_listed() -> None:
    listing = TEXT.partition("## Where things are")[2].partition("```\n")[2].partition("```")[0]
    listed = re.findall(r"(?:^|\| )\s*([a-z/]+)/ ", listing.replace(":", " "), re.MULTILINE)
    for name in listed:
        assert (ROOT / name).is_dir() or (ROOT / "radargui" / name).is_dir(), name
    packages = {path.parent.name for path in (ROOT / "radargui").glob("*/__init__.py")}
    assert packages - set(listed) == set()
