"""Whether the tables in a folder are those that would be made again."""

from __future__ import annotations

import json
from pathlib import Path

from radargui import __version__
from radargui.model.setup import Setup
from radargui.report.plain_values import json_bytes

LARGEST_BYTES = 10_000_000


def tables_are_current(folder: Path, setup: Setup) -> bool:
    """Return whether the tables in a folder were made by this version with this setup; result.json comes last."""
    path = folder / "result.json"
    try:
        if path.stat().st_size > LARGEST_BYTES:
            return False
        document = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return False
    wanted = json.loads(json_bytes({"setup": setup, "version": __version__}))
    return isinstance(document, dict) and all(document.get(key) == value for key, value in wanted.items())
