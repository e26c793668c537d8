"""Puts the help into the wheel where it was built before; without it F1 shows the texts it is built from."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class HelpHook(BuildHookInterface[Any]):
    """Named in pyproject.toml."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the folder, except where nothing is copied."""
        built = Path(self.root) / "build" / "help"
        if version != "editable" and built.is_dir():
            build_data["force_include"][str(built)] = "radargui/resources/help"
