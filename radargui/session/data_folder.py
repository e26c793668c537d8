"""The data folder of the user: where sessions go when nobody says otherwise."""

from __future__ import annotations

from pathlib import Path

import platformdirs


def default_data_folder() -> Path:
    """Return the folder RadarGUI in the user's documents; it may not be there yet."""
    return Path(platformdirs.user_documents_dir()) / "RadarGUI"
