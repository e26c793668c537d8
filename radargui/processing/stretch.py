"""The stretch of a recording without a gap around the motion: phase cannot be followed across lost samples."""

from __future__ import annotations

import itertools

import numpy as np

from radargui.model.recording import Recording


def stretches(recording: Recording) -> tuple[slice, ...]:
    """Return the runs of stored samples between which nothing was lost."""
    index = recording.index()
    breaks = np.flatnonzero(np.diff(index) > 1) + 1
    edges = [0, *breaks.tolist(), recording.n_samples]
    return tuple(slice(begin, end) for begin, end in itertools.pairwise(edges) if end > begin)
