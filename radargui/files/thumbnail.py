"""The thumbnail of a run: its height against time in a few points, for lists of runs."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.run_header import is_run
from radargui.model.arrays import FloatArray
from radargui.model.decimation import lowest_and_highest
from radargui.model.result import RunResult

BINS = 128
"""As many as the picture in a list has pixels."""
_MARGIN = 0.1
"""Share of the motion shown before and after it. Chosen by hand."""


@dataclass(frozen=True, slots=True)
class Thumbnail:
    """Height against time.

    Attributes
    ----------
    time_s, z_m
        Shape (n,), at most 2 * BINS points; NaN where unknown.
    """

    time_s: FloatArray
    z_m: FloatArray


def put_thumbnail(group: Any, result: RunResult) -> None:
    """Store the thumbnail of a result in its group: lowest and highest z of each bin around the motion."""
    track, segment = result.track, result.segment
    if track is None or not track.time_s.size:
        return
    n = track.time_s.size
    first, last = (segment.first, segment.last) if segment else (0, n)
    margin = round(_MARGIN * (last - first))
    first, last = max(first - margin, 0), min(last + margin, n)
    z, t = track.position_m[2, first:last], track.time_s[first:last]
    size = max(1, -(-z.size // BINS))
    whole = z.size // size * size
    ends = np.stack(lowest_and_highest(z[:whole], size), axis=1)
    if result.paths is not None:
        restarts = result.paths.restarts() - first
        # unknown, so that no line joins two pieces
        ends[restarts[(restarts >= 0) & (restarts < whole)] // size] = np.nan
    places = np.repeat(t[size // 2 : whole : size], 2)
    thumbnail = group.create_group(layout.THUMBNAIL)
    for name, values, unit in (("time_s", places, "s"), ("z_m", ends.ravel(), "m")):
        hdf5.put_text(thumbnail.create_dataset(name, data=values).attrs, "unit", unit)


def read_thumbnail(path: Path) -> Thumbnail | None:
    """Return the thumbnail stored with the results of a run; None where there is none.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        return thumbnail_in(file[layout.RESULTS], path) if layout.RESULTS in file else None


def thumbnail_in(group: Any, path: Path) -> Thumbnail | None:
    """Return the thumbnail in a group of results; None where there is none.

    Raises
    ------
    FileError
        It is damaged.
    """
    if layout.THUMBNAIL not in group:
        return None
    time_s, z_m = (
        np.asarray(hdf5.dataset(group[layout.THUMBNAIL], name, path, (1,))[:], dtype=np.float64)
        for name in ("time_s", "z_m")
    )
    return Thumbnail(time_s, z_m) if time_s.shape == z_m.shape else None
