"""Puts the help into the wheel: its pages where they were built before, else the texts that they are built from."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PLACE = "radargui/resources/help"
SHOWN = (".md", ".png", ".svg", ".ipynb", ".json", ".toml")
"""What the texts are made of; the programs that make them stay behind."""


class HelpHook(BuildHookInterface[Any]):
    """Named in pyproject.toml."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the files, except where nothing is copied: a checkout has them in docs/.

        Building the pages takes Sphinx and all that RadarGUI itself needs; who installs from a checkout gets the texts.
        """
        if version == "editable":
            return
        root = Path(self.root)
        built, texts = root / "build" / "help", root / "docs"
        if built.is_dir():
            build_data["force_include"][str(built)] = PLACE
            return
        for path in sorted(texts.rglob("*")):
            if path.suffix in SHOWN:
                build_data["force_include"][str(path)] = f"{PLACE}/{path.relative_to(texts).as_posix()}"
