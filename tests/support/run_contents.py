"""What a run file holds that only tests ask for."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from radargui.files import hdf5, run_layout as layout
from radargui.files.run_file import opened_run, run_stream
from radargui.files.stored_results import read_stored_results
from radargui.model.recording import Marker, Truth


def read_markers(path: Path) -> tuple[Marker, ...]:
    """Return the operator's notes in the order they were made."""
    with run_stream(path) as run:
        return run.facts.markers


def read_run_truth(path: Path) -> Truth | None:
    """Return what really happened in a simulated run; None for a real one."""
    with opened_run(path) as file:
        if layout.TRUTH not in file:
            return None
        names = ("position_m", "path_m", "impact_time_s")
        return Truth(*(np.float64(hdf5.dataset(file[layout.TRUTH], name, path)[...]) for name in names))


def read_summary(path: Path) -> dict[str, object] | None:
    """Return the summary of the present result of a run; None where it was not processed yet."""
    *_, present = (None, *read_stored_results(path))
    return present.summary if present is not None and present.is_present else None
