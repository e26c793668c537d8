"""The layout of a run file: names and types that writer and reader share."""

import h5py
import numpy as np

FORMAT = "radargui-run"
FORMAT_VERSION = 1
RESULTS_VERSION = 2
SUFFIX = ".h5"

RAW = "raw"
GAPS = "gaps"
MARKERS = "markers"
TRUTH = "truth"
RESULTS = "results"
EARLIER = "earlier_results"
OVERVIEW = "overview"
THUMBNAIL = "thumbnail"
NO_TRIGGER = -1

CHUNK_S = 0.5
"""What a crash may cost, and how often the disk is written to."""
LARGEST_CHUNK = 1 << 18
"""Samples of one channel: 0.5 to 2 MB, in memory once a channel while they are compressed. Chosen by hand."""
COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
"""0.70 to 0.80 of the size for about 1 % of a core; any HDF5 library reads it."""

REASON_BYTES = 80
GAP_TYPE = np.dtype(
    [("first_index", "<i8"), ("count", "<i8"), ("reason", h5py.string_dtype("utf-8", REASON_BYTES))],
)
MARKER_BYTES = 1000
MARKER_TYPE = np.dtype([("index", "<i8"), ("text", h5py.string_dtype("utf-8", MARKER_BYTES))])


def chunk_length(sample_rate_hz: float) -> int:
    """Return how many samples of one channel make a chunk: about half a second."""
    return int(min(max(1.0, round(CHUNK_S * sample_rate_hz)), LARGEST_CHUNK))


def fitted(text: str, n_bytes: int) -> bytes:
    """Return a text as UTF-8 of at most `n_bytes` bytes, cut between characters."""
    return text.replace("\0", " ").encode("utf-8", "replace")[:n_bytes].decode("utf-8", "ignore").encode("utf-8")
