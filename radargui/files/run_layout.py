"""Names and types of a run file, which writer and reader share; the header is written before any sample."""

import math
from collections.abc import Iterator, Mapping
from itertools import product, zip_longest
from pathlib import Path
from typing import Any, Required, TypedDict

import h5py
import numpy as np
from numpy.typing import DTypeLike

from radargui import __version__
from radargui.files import hdf5
from radargui.model.arrays import FloatArray, pieces
from radargui.model.errors import FileError, worded
from radargui.model.recording import Digitisation

FORMAT = "radargui-run"
FORMAT_VERSION = 1
"""Of run files as this version writes them; what a newer one wrote is refused."""
RESULTS_VERSION = 2
"""Of the results in them: those of another number are computed again."""
SUFFIX = ".h5"

RAW = "raw"
GAPS = "gaps"
MARKERS = "markers"
TRUTH = "truth"
RESULTS = "results"
EARLIER = "earlier_results"
OVERVIEW = "overview"
THUMBNAIL = "thumbnail"
NO_TRIGGER = -1  # in place of a sample's index, which is never below zero

CHUNK_S = 0.5
"""What a crash may cost, and how often the disk is written to."""
LARGEST_CHUNK = 1 << 18
"""Samples of one channel: 0.5 to 2 MB, in memory once a channel while they are compressed. Chosen by hand."""
PIECE = 1 << 18
"""Samples of each channel that are read at a time."""

REASON_BYTES = 80  # in UTF-8, a line; rows of a table are of one length, more is cut (chosen by hand)
GAP_TYPE = np.dtype([("first_index", "<i8"), ("count", "<i8"), ("reason", h5py.string_dtype("utf-8", REASON_BYTES))])
MARKER_BYTES = 1000  # in UTF-8, a note of an operator; the same
MARKER_TYPE = np.dtype([("index", "<i8"), ("text", h5py.string_dtype("utf-8", MARKER_BYTES))])


def chunk_length(sample_rate_hz: float) -> int:
    """Return how many samples of one channel make a chunk: about half a second."""
    return int(min(max(1.0, round(CHUNK_S * sample_rate_hz)), LARGEST_CHUNK))


def fitted(text: str, n_bytes: int) -> bytes:
    """Return a text as UTF-8 of at most `n_bytes` bytes, cut between characters."""
    return text.replace("\0", " ").encode("utf-8", "replace")[:n_bytes].decode("utf-8", "ignore").encode("utf-8")


Attribute = str | float | int


class Header(TypedDict, total=False):
    """What is known of a run when its file is made.

    Attributes
    ----------
    started_at
        ISO 8601 date and time of the first sample.
    trigger_index
        Index of the trigger, counted from the first sample written, lost samples included; None where there is none.
    setup_toml
        The setup as TOML text.
    attributes
        Further facts kept with the file (seed, source, ...).
    """

    started_at: Required[str]
    trigger_index: int | None
    setup_toml: str
    attributes: Mapping[str, Attribute]


def write_header(file: Any, digitisation: Digitisation, header: Header) -> None:
    """Make the empty datasets and all attributes of a new run file."""
    n_channels, trigger_index = digitisation.n_channels, header.get("trigger_index")
    dtype = np.float64 if digitisation.scaling is None else np.int16
    raw = make_raw(file, (n_channels, 0), dtype, (1, chunk_length(digitisation.sample_rate_hz)))
    for name, kind, units in (
        (GAPS, GAP_TYPE, ("sample", "sample", "text")),
        (MARKERS, MARKER_TYPE, ("sample", "text")),
    ):
        table = file.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(16,), dtype=kind, **hdf5.COMPRESSION)
        hdf5.put_all(table.attrs, {"units": units})
    own: dict[str, Any] = {"format": FORMAT, "format_version": FORMAT_VERSION, "version": __version__}
    own |= {"setup": header.get("setup_toml", ""), "complete": False}
    hdf5.put_all(file.attrs, {**header.get("attributes", {}), **own})
    described = {
        "sample_rate_hz": float(digitisation.sample_rate_hz),
        "unit": digitisation.unit,
        "stored_unit": stored_unit(digitisation),
        "channel_names": digitisation.channel_names,
        "channel_skew_s": digitisation.channel_skew_s,
        "device": digitisation.device,
        "started_at": header["started_at"],
        "trigger_index": NO_TRIGGER if trigger_index is None else int(trigger_index),
        "trigger_time_s": math.nan if trigger_index is None else trigger_index / digitisation.sample_rate_hz,
        "scaling": None if digitisation.scaling is None else padded(digitisation.scaling),
    }
    # On the samples and on the file: whoever looks at either finds them.
    for place in (file, raw):
        hdf5.put_all(place.attrs, described)
        hdf5.seal(place.attrs)


def make_raw(file: Any, shape: tuple[int, int], dtype: DTypeLike, chunks: tuple[int, int]) -> Any:
    """Make the dataset of the samples, shape (n_channels, n_samples), that can grow, and return it."""
    return file.create_dataset(
        RAW, shape=shape, maxshape=(shape[0], None), dtype=dtype, chunks=chunks, **hdf5.COMPRESSION
    )


def stored_unit(digitisation: Digitisation) -> str:
    """Return the unit of the samples as they are stored."""
    return digitisation.unit if digitisation.scaling is None else "code"


def write_end(file: Any, count: int, crcs: list[int], *, complete: bool) -> None:
    """Set what is known only at the end: the number of samples and the checksum of each channel."""
    file.attrs["n_samples"] = count
    file.attrs["crc32"] = np.array(crcs, dtype=np.uint32)
    file.attrs["complete"] = complete
    hdf5.seal(file.attrs)


def read_digitisation(raw: Any, path: Path) -> Digitisation:
    """Return how the samples of a run file were digitised.

    Raises
    ------
    FileError
        An attribute is missing or does not fit the samples.
    """
    attributes = raw.attrs
    rate_hz = hdf5.number(attributes, "sample_rate_hz")
    if rate_hz is None or not math.isfinite(rate_hz) or rate_hz <= 0.0:
        raise FileError(f"{path}: its sample_rate_hz is not a rate.")
    names = tuple(hdf5.decoded(name) for name in np.atleast_1d(attributes.get("channel_names", [])))
    if len(names) != raw.shape[0] or len(set(names)) != len(names):
        raise FileError(f"{path}: {len(names)} channel names for {raw.shape[0]} channels.")
    skew_s = hdf5.number(attributes, "channel_skew_s")
    return Digitisation(
        channel_names=names,
        sample_rate_hz=rate_hz,
        scaling=_scaling(raw, path),
        channel_skew_s=skew_s if skew_s is not None and math.isfinite(skew_s) else None,
        unit=hdf5.text(attributes, "unit") or "V",
        device=hdf5.text(attributes, "device"),
    )


def read_trigger(attributes: Any) -> int | None:
    """Return the index of the trigger, None where there is none."""
    index = hdf5.number(attributes, "trigger_index")
    return None if index is None or not math.isfinite(index) or index < 0 else int(index)


def _scaling(raw: Any, path: Path) -> tuple[tuple[float, ...], ...] | None:
    if raw.dtype == np.float64:
        return None
    if raw.dtype != np.int16:
        raise FileError(f"{path}: its samples are {raw.dtype}, not int16 codes or float64 volts.")
    table = np.asarray(raw.attrs.get("scaling", []), dtype=np.float64)
    if table.ndim != 2 or table.shape[0] != raw.shape[0] or table.shape[1] < 1 or not np.isfinite(table).all():
        raise FileError(f"{path}: the scaling of its codes is missing or does not fit its channels.")
    return tuple(map(_trimmed, table.tolist()))


def padded(scaling: tuple[tuple[float, ...], ...]) -> FloatArray:
    """Return the coefficients of each channel in a row, the missing ones 0, shape (n_channels, most coefficients)."""
    return np.array(list(zip_longest(*scaling, fillvalue=0.0)), dtype=np.float64).T


def _trimmed(row: list[float]) -> tuple[float, ...]:
    # as padded: a line keeps its slope of 0
    while len(row) > 2 and row[-1] == 0.0:
        row.pop()
    return tuple(row)


def whole_samples(raw: Any) -> int:
    """Return how many samples lie before the first chunk that a crash kept from the disk."""
    n_channels, count = raw.shape
    if raw.chunks is None:
        return int(count)
    length = raw.chunks[1]
    if raw.id.get_num_chunks() == n_channels * -(-count // length):
        return int(count)
    for first, channel in product(range(0, count, length), range(n_channels)):
        if raw.id.get_chunk_info_by_coord((channel, first)).byte_offset is None:
            return first
    return int(count)


def sample_count(file: Any) -> int:
    """Return how many samples of each channel an open run file holds, also where a crash stopped it."""
    return int(file[RAW].shape[1]) if "crc32" in file.attrs else whole_samples(file[RAW])


def stored_pieces(raw: Any, count: int) -> Iterator[slice]:
    """Yield slices that cover the first `count` samples in whole chunks of the file: each is inflated once only."""
    return pieces(count, max(PIECE // raw.chunks[1], 1) * raw.chunks[1] if raw.chunks else PIECE)


def is_run(file: Any) -> bool:
    """Return whether an opened HDF5 file is a run file of this program.

    Raises
    ------
    FileError
        It is one of a newer version.
    """
    version, is_ours = hdf5.number(file.attrs, "format_version"), hdf5.text(file.attrs, "format") == FORMAT
    if is_ours and version is not None and version > FORMAT_VERSION:
        facts = {"format": f"{version:g}", "this": "this one", "known": FORMAT_VERSION}
        raise worded(FileError, "newer_version", path=file.filename, **facts)
    return is_ours or isinstance(file.get(RAW), h5py.Dataset)
