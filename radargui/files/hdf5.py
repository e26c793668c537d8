"""Open, store, append and read HDF5 files in small steps, without trusting what their headers claim."""

import math
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from radargui.files.access import reading
from radargui.model.arrays import RawArray
from radargui.model.errors import FileError, worded

COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
"""0.70 to 0.80 of the size for about 1 % of a core; any HDF5 library reads it."""
_SLACK_BYTES = 65_536
"""May be claimed by a file that stores nothing: a chunk never filled takes no room. Chosen by hand."""
LARGEST_RATIO = 1100
"""Deflate makes data at most about 1032 times smaller; a header that claims more is wrong."""


@contextmanager
def opened(path: Path, what: str = "an HDF5 file", check: Callable[[Any], bool] | None = None) -> Iterator[Any]:
    """Open for reading; whatever the library says about a damaged file becomes a FileError.

    Parameters
    ----------
    path
        File to open.
    what
        The kind of file, for people.
    check
        Says whether the content is of that kind.

    Raises
    ------
    FileError
        No such file, not HDF5, not of that kind, damaged, or in use by a recording.
    """
    with reading(path, what), h5py.File(path, "r", locking="best-effort") as file:
        if check is not None and not check(file):
            raise FileError(f"{path} is HDF5, but not {what}.")
        yield file


def is_hdf5(path: Path) -> bool:
    """Return whether a file starts (after a user block, as MATLAB's) as HDF5 does."""
    with suppress(OSError, RuntimeError, ValueError):
        return bool(h5py.is_hdf5(path))
    return False


def store(group: Any, name: str, values: NDArray[Any], chunk: int, *, unit: str) -> None:
    """Store an array (n,) or (rows, n) in compressed chunks of one row, with the unit of its values."""
    options: dict[str, Any] = {}
    if values.size:
        options = {"chunks": (*(1,) * (values.ndim - 1), min(chunk, values.shape[-1])), **COMPRESSION}
    put_text(group.create_dataset(name, data=values, **options).attrs, "unit", unit)


def append_row(dataset: Any, row: tuple[Any, ...]) -> None:
    """Append one row to a table."""
    count = dataset.shape[0]
    dataset.resize(count + 1, axis=0)
    dataset[count] = np.array(row, dtype=dataset.dtype)


def dataset(group: Any, name: str, path: Path, n_dimensions: tuple[int, ...] = (1, 2)) -> Any:
    """Return a dataset that is really there and as large as the file can hold.

    Raises
    ------
    FileError
        Missing, no dataset, of another number of dimensions, kept in another file, or claiming more than is there.
    """
    found = group.get(name) if name in group else None
    if not isinstance(found, h5py.Dataset):
        raise FileError(f"{path}: holds no {name}.", reasons=("it is not the file it seems to be",))
    if found.ndim not in n_dimensions or len(found.chunks or found.shape) != found.ndim:
        raise FileError(f"{path}: {name} has {found.ndim} dimensions.")
    if found.external or found.is_virtual or found.file != group.file:
        raise FileError(f"{path}: {name} is kept in another file, which is not read.")
    present = min(found.id.get_storage_size(), path.stat().st_size)
    # The library takes memory for whole chunks, however few samples are asked for.
    claimed = max(found.nbytes, math.prod(found.chunks or (0,)) * found.dtype.itemsize)
    if claimed > LARGEST_RATIO * (present + _SLACK_BYTES):
        raise worded(FileError, "claims_too_much", path=path, name=name, claimed_gb=claimed / 1e9)
    return found


def put_text(attributes: Any, key: str, text: str) -> None:
    """Set an attribute to a text of fixed length.

    Text of variable length lies in a heap without checksum: one damaged byte there makes the library loop for ever.
    """
    data = text.replace("\0", " ").encode("utf-8", "replace")
    attributes.create(key, data, dtype=h5py.string_dtype("utf-8", max(len(data), 1)))


def put_all(attributes: Any, values: Mapping[str, Any]) -> None:
    """Set attributes: texts, and tuples of texts, with fixed length; what is None is left out."""
    for key, value in values.items():
        if isinstance(value, str):
            put_text(attributes, key, value)
        elif isinstance(value, tuple):
            data = [text.encode("utf-8", "replace") for text in value]
            attributes.create(key, data, dtype=h5py.string_dtype("utf-8", max(1, *map(len, data))))
        elif value is not None:
            attributes[key] = value


def copy_attributes(source: Any, target: Any) -> None:
    """Copy all attributes of one object to another, texts with fixed length."""
    put_all(
        target.attrs,
        {key: decoded(value) if isinstance(value, bytes) else value for key, value in source.attrs.items()},
    )


def text(attributes: Any, key: str) -> str:
    """Return an attribute as text, empty where it is missing or no text."""
    value = attributes.get(key, "")
    return decoded(value) if isinstance(value, bytes | str) else ""


def decoded(value: Any) -> str:
    """Return a text of a table or a list, which the library gives as bytes where its length is fixed."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def number(attributes: Any, key: str) -> float | None:
    """Return an attribute as a number, None where it is missing or no single number."""
    value = np.asarray(attributes.get(key))
    if value.size != 1 or value.dtype.kind not in "iufb":
        return None
    return float(value.reshape(-1)[0])


SEAL = "attributes_crc32"


def seal(attributes: Any) -> None:
    """Store the checksum of all attributes of one object among them."""
    attributes[SEAL] = np.uint32(_crc(attributes))


def is_sound(attributes: Any) -> bool:
    """Return whether attributes are as they were sealed; those without a seal are taken as they are."""
    return SEAL not in attributes or int(attributes[SEAL]) == _crc(attributes)


def rows_crc(samples: RawArray, before: list[int]) -> list[int]:
    """Return the checksum of each channel, carried on from `before`."""
    return [zlib.crc32(np.ascontiguousarray(row).data, crc) for row, crc in zip(samples, before, strict=True)]


def _crc(attributes: Any) -> int:
    crc = 0
    for key in sorted(attributes):
        if key != SEAL:
            value = np.asarray(attributes[key])
            content = str(value.tolist()).encode() if value.dtype.kind == "O" else value.tobytes()
            crc = zlib.crc32(key.encode("utf-8", "replace") + b"=" + content, crc)
    return crc
