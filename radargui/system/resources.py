"""Locate the shipped files, beside the checkout, inside the installed package or in a frozen program."""

import sys
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import platformdirs

DEFAULT_SETUP = "default.toml"
LOG_FORMAT = "%(asctime)s %(levelname)s %(name)s: %(message)s"
"""Of a line of the log."""


def resources_folder() -> Path:
    """Return the folder of shipped resources."""
    package = Path(__file__).resolve().parent.parent
    frozen = getattr(sys, "_MEIPASS", None)
    candidates = [package / "resources", package.parent / "resources"]
    if frozen:
        candidates.insert(0, Path(frozen) / "resources")
    return next((folder for folder in candidates if (folder / "setups").is_dir()), candidates[-1])


def shipped_setups() -> tuple[Path, ...]:
    """Return the ready setup files, by name."""
    return tuple(sorted((resources_folder() / "setups").glob("*.toml")))


def default_setup_path() -> Path:
    """Return the setup that commands use when none is named."""
    return resources_folder() / "setups" / DEFAULT_SETUP


def log_path() -> Path:
    """Return the log file's path."""
    return platformdirs.user_log_path("radargui", appauthor=False) / "radargui.log"


def help_page(shipped: Path | None = None, checkout: Path | None = None) -> Path:
    """Return the first page of the help: built, else the text that it is built from; there may be neither.

    Parameters
    ----------
    shipped, checkout
        Folders with the help that came with the program, and of the source; None: those of this program.
    """
    shipped, checkout = shipped or resources_folder() / "help", checkout or Path(__file__).resolve().parents[2]
    pages = [folder / "index.html" for folder in (shipped, checkout / "build" / "help")]
    texts = [folder / "tutorial.md" for folder in (shipped, checkout / "docs")]
    return next((page for page in (*pages, *texts) if page.is_file()), texts[-1])


@cache
def resource_table(name: str) -> dict[str, Any]:
    """Return a shipped table, never changed: of the window its words, colours or actions, of NI-DAQmx its errors."""
    return tomllib.loads((resources_folder() / f"{name}.toml").read_text(encoding="utf-8"))
