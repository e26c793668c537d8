"""Read and write MATLAB files, v5 and 7.3: real vectors, also inside structures (`src1.Data`).

MATLAB v5 files through scipy, after a look at their claims.

Every array a file announces must be well formed and fit into the bytes that are there. The reading library believes
types and sizes in the headers: damaged ones make it fill memory or crash. A walk over the headers (MAT-File Format,
MathWorks, level 5) refuses such a file first and names the variables worth reading.
"""

import math
import re
import struct
import zlib
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from itertools import islice
from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np

from radargui.files import hdf5, run_layout as layout
from radargui.files.access import Progress, listed, reading, resolved
from radargui.files.run_file import LARGEST_TEXT, ExportFacts, RunStream, facts_of_text
from radargui.files.signals import TIME_NAME, ChannelInfo, Signal, Signals
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.errors import FileError, worded

# all numbers down to the flag of complex ones are those of MathWorks, MAT-File Format, level 5
HEADER_BYTES = 128
_INT8, _INT32, _UINT32, _MATRIX, _COMPRESSED = 1, 5, 6, 14, 15  # types of elements: miINT8, ...
_ITEM_BYTES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8, 16: 1, 17: 2, 18: 4}  # by type
_CELL, _STRUCT, _CHAR = 1, 2, 4  # classes of arrays: mxCELL_CLASS, ...
_NUMERIC = range(6, 16)  # from mxDOUBLE_CLASS to mxUINT64_CLASS
_KNOWN = range(1, 18)  # all classes, and two that it does not name: function handles and opaque objects
_COMPLEX = 0x08  # a flag of an array
_DEEPEST_STRUCTURE = 32
"""Structures within structures; what people nest ends at a few, and recursion must end. Chosen by hand."""
_TAG_BYTES = 8  # type and length before each element, 4 bytes each


def read_values(path: Path, only: str | None = None) -> dict[str, Any]:
    """Return all variables and fields of structures by dotted name, or `only` one; what scipy raises on damage passes.

    Objects, functions and sparse matrices are left out: they are no samples.
    """
    names = [name for name in sound_variables(path) if only in (None, name)]
    # a quarter of a second to load, for those who read such a file
    from scipy.io import loadmat

    content = loadmat(str(path), variable_names=names, simplify_cells=True) if names else {}
    return dict(_leaves("", {name: content[name] for name in names if name in content}))


def _leaves(prefix: str, content: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _leaves(f"{prefix}{name}.", value)
        elif isinstance(value, str | int | float | np.ndarray | np.generic):
            yield f"{prefix}{name}", value


def sound_variables(path: Path) -> list[str]:
    """Return the names of the variables that hold numbers, text, cells or structures of these only.

    Raises
    ------
    ValueError
        Not a v5 file, cut off, or an array is malformed or claims more than the file holds.
    """
    data = memoryview(path.read_bytes())
    if len(data) < HEADER_BYTES:
        raise ValueError("it is too short for a header")
    order = {b"IM": "<", b"MI": ">"}.get(bytes(data[126:128]))
    # with a 0 in front the library would take it for version 4, whose headers nobody has looked at
    if 0 in data[:4] or order is None or struct.unpack(order + "H", data[124:126])[0] >> 8 != 1:
        raise ValueError("it is not of MATLAB version 5 to 7.3")
    names = []
    for kind, content in _elements(data[HEADER_BYTES:], order):
        inside = [(kind, content)] if kind != _COMPRESSED else list(_elements(_inflated(content, order), order))
        if len(inside) != 1 or inside[0][0] != _MATRIX:
            raise ValueError("something else than a variable is in it")
        name, sound = _check_matrix(inside[0][1], order, 0)
        if sound and name:
            names.append(name)
    return names


def _inflated(content: memoryview, order: str) -> memoryview:
    inflate = zlib.decompressobj()
    start = inflate.decompress(content, _TAG_BYTES)
    if len(start) < _TAG_BYTES:
        raise ValueError("a compressed variable is cut off")
    _, count = struct.unpack(order + "II", start)
    if count > hdf5.LARGEST_RATIO * len(content):
        raise ValueError(f"a variable claims {count / 1e9:.3g} GB, far more than the file holds")
    rest = inflate.decompress(inflate.unconsumed_tail, count + 1)
    # One step more reaches the end of the stream and with it the checksum.
    rest += inflate.decompress(inflate.unconsumed_tail, 1)
    if len(rest) != count or not inflate.eof:
        raise ValueError("a compressed variable is cut off or damaged")
    return memoryview(start + rest)


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Give type and content of the elements that follow one another and fill `data`."""
    place = 0
    while place < len(data):
        if place + _TAG_BYTES > len(data):
            raise ValueError("a variable is cut off")
        first, count = struct.unpack_from(order + "II", data, place)
        start = place + _TAG_BYTES
        if first >> 16:
            first, count, start = first & 0xFFFF, first >> 16, place + 4
            place += _TAG_BYTES
            if count > 4:
                raise ValueError("a small element is larger than 4 bytes")
        else:
            place = start + count + (-count % 8 if first != _COMPRESSED else 0)
        if start + count > len(data) or (count % _ITEM_BYTES.get(first, 1)):
            raise ValueError("a variable is cut off")
        if first not in _ITEM_BYTES and first not in (_MATRIX, _COMPRESSED):
            raise ValueError(f"data of an unknown type {first} are in it")
        yield first, data[start : start + count]


def _check_matrix(content: memoryview, order: str, depth: int) -> tuple[str, bool]:
    """Return name and soundness of an array; what is inside a structure or cell is checked as well."""
    if not len(content):
        return "", True
    if depth > _DEEPEST_STRUCTURE:
        raise ValueError("structures are nested too deep")
    parts = list(_elements(content, order))
    if not parts or parts[0][0] != _UINT32 or len(parts[0][1]) != 8:
        raise ValueError("an array has no header")
    flags = struct.unpack_from(order + "I", parts[0][1])[0]
    kind = flags & 0xFF
    if kind not in _KNOWN:
        raise ValueError(f"an array is of the unknown class {kind}")
    if kind not in (_CELL, _STRUCT, _CHAR) and kind not in _NUMERIC:
        return "", False
    if len(parts) < 3 or parts[1][0] != _INT32 or parts[2][0] != _INT8:
        raise ValueError("an array has no size or no name")
    sizes = struct.unpack(f"{order}{len(parts[1][1]) // 4}i", parts[1][1])
    if not 2 <= len(sizes) <= 32 or any(size < 0 for size in sizes):
        raise ValueError("the size of an array is malformed")
    name = bytes(parts[2][1]).decode("latin-1")
    count, inside = math.prod(sizes), parts[3:]
    if kind in _NUMERIC or kind == _CHAR:
        _check_numbers(inside, count, bool((flags >> 8) & _COMPLEX), kind == _CHAR)
        return name, True
    if kind == _STRUCT:
        count *= _n_fields(inside, order)
        inside = inside[2:]
    if len(inside) != count or any(one != _MATRIX for one, _ in inside):
        raise ValueError(f"a cell or structure claims {count:.3g} values and holds {len(inside)}")
    # All are looked at, also behind one that is not sound.
    sound = [_check_matrix(one, order, depth + 1)[1] for _, one in inside]
    return name, all(sound)


def _check_numbers(parts: list[tuple[int, memoryview]], count: int, is_complex: bool, is_text: bool) -> None:
    if len(parts) != 1 + is_complex or any(kind not in _ITEM_BYTES for kind, _ in parts):
        raise ValueError("the numbers of an array are malformed")
    for kind, data in parts:
        # Text in UTF-8 or UTF-16 may take more bytes than it has characters.
        held = len(data) // (1 if is_text else _ITEM_BYTES[kind])
        if count > held or (not is_text and count != held):
            raise ValueError(f"an array claims {count:.3g} values and holds {held}")


def _n_fields(parts: list[tuple[int, memoryview]], order: str) -> int:
    if len(parts) < 2 or parts[0][0] != _INT32 or len(parts[0][1]) != 4 or parts[1][0] != _INT8:
        raise ValueError("a structure has no fields")
    length: int = struct.unpack(order + "i", parts[0][1])[0]
    if length < 1 or len(parts[1][1]) % length:
        raise ValueError("the names of fields are malformed")
    return len(parts[1][1]) // length


WHAT = "a MATLAB file"
RATE_NAMES = ("samplefrequency", "samplerate", "sample_rate_hz", "sample_rate", "samplingrate", "rate_hz", "fs")
"""Variables or fields that hold samples per second, small letters."""
UNIT_NAMES = ("unit", "units")
DATE_NAMES = ("datetime", "date_time", "started_at", "start_time", "starttime", "startdate", "start_date", "timestamp")
"""Variables or fields that hold when the recording began."""
_YEAR_ZERO_DAYS = 366
"""Days by which MATLAB's datenum (day 1: 1 January of the year 0) is ahead of Python's ordinal (1 January of 1)."""
_DATESTR = "%d-%b-%Y %H:%M:%S"
"""What MATLAB's `datestr` writes unless told otherwise."""
_SMALL = 64
"""Values of an array that is read unasked: single numbers and dates stand in such, samples do not."""
_LONGEST_TEXT = 256
"""Characters of a text that is read unasked: a unit or a date is shorter."""
_DEEPEST = 16  # as below
_MOST = 10_000
"""Groups within groups, and arrays in all, that are looked at: damaged files hold loops. Chosen by hand."""
_WRITTEN_BY = re.compile(r"\b(?:written )?by (.+)", re.DOTALL)
"""In the text at the beginning of a file, where other programs than MATLAB name themselves."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable, or a field of a structure, by its dotted name.

    Attributes
    ----------
    name
        Such as `src1.Data`.
    shape
        Without sides of length 1; empty for single values.
    is_real
        Whether it holds real numbers.
    value
        Samples (n,), a number, a text; None where it was not read or is none of these.
    """

    name: str
    shape: tuple[int, ...] = ()
    value: FloatArray | float | str | None = field(default=None, repr=False)
    is_real: bool = False

    @property
    def is_vector(self) -> bool:
        """Whether it can be a channel."""
        return self.is_real and len(self.shape) == 1 and self.shape[0] > 0


def variable_of(name: str, value: Any) -> Variable:
    """Return an array, number or text as a variable."""
    if isinstance(value, str):
        return Variable(name, value=value)
    array = np.squeeze(np.asarray(value))
    if array.ndim == 0:
        single = array.item() if array.dtype.kind in "iufb" else None
        return Variable(name, value=None if single is None else float(single))
    is_real = array.dtype.kind in "iufb"
    # A damaged file may hold signalling NaN; that they are no numbers is said where samples are looked at.
    with np.errstate(invalid="ignore"):
        vector = np.ascontiguousarray(array, dtype=np.float64) if is_real and array.ndim == 1 and array.size else None
    return Variable(name, array.shape, vector, is_real)


def list_mat(path: Path) -> tuple[ChannelInfo, ...]:
    """Return the vectors in a MATLAB file.

    Raises
    ------
    FileError
        Unreadable or no MATLAB file.
    """
    variables = _variables(path, ())
    return tuple(
        ChannelInfo(name, variable.shape[0], _rate(variables, name), _unit(variables, name))
        for name, variable in variables.items()
        if variable.is_vector and name != TIME_NAME
    )


def read_mat(path: Path, names: Sequence[str]) -> Signals:
    """Return vectors of a MATLAB file; a vector `time_s` of the same length gives the file's own time.

    The sample rate is a number named `SampleFrequency`, `Fs` or alike beside a vector, or else at the top; the start a
    `DateTime` or alike there: a datenum, a clock vector or a text.

    Raises
    ------
    FileError
        Unreadable, no MATLAB file, a variable missing or no real vector.
    """
    variables = _variables(path, (*names, TIME_NAME))
    vectors = [name for name, variable in variables.items() if variable.is_vector]
    own = resolved(path, names, list(variables), vectors)
    signals = []
    for name in own:
        variable = variables[name]
        if not isinstance(variable.value, np.ndarray):
            shape = " x ".join(str(size) for size in variable.shape) or "a single value"
            raise worded(FileError, "no_vector", path=path, name=name, shape=shape, vectors=listed(vectors) or "none")
        signals.append(Signal(name, variable.value, unit=_unit(variables, name)))
    rates = {_rate(variables, name) for name in own}
    if len(rates) > 1:
        raise FileError(f"{path}: its vectors have different sample rates.")
    time_s = variables[TIME_NAME].value if TIME_NAME in variables else None
    if not isinstance(time_s, np.ndarray) or time_s.size != signals[0].samples.size:
        time_s = None
    return Signals(tuple(signals), sample_rate_hz=rates.pop(), time_s=time_s, started_at=_started(variables, own[0]))


def _variables(path: Path, wanted: Sequence[str]) -> dict[str, Variable]:
    with reading(path, WHAT):
        if hdf5.is_hdf5(path):
            return _variables_73(path, wanted)
        return {name: variable_of(name, value) for name, value in read_values(path).items()}


def _beside(variables: dict[str, Variable], name: str, keys: Sequence[str]) -> list[Variable]:
    """Return variables of these names beside `name`, then at the top."""
    return [
        variable
        for parent in (name.rpartition(".")[0], "")
        for other, variable in variables.items()
        if other.rpartition(".")[0] == parent and other.rpartition(".")[2].lower() in keys
    ]


def _rate(variables: dict[str, Variable], name: str) -> float | None:
    values = (variable.value for variable in _beside(variables, name, RATE_NAMES))
    return next((rate for rate in values if isinstance(rate, float) and math.isfinite(rate) and rate > 0.0), None)


def _unit(variables: dict[str, Variable], name: str) -> str:
    found = _beside(variables, name, UNIT_NAMES)
    return next((variable.value.strip()[:32] for variable in found if isinstance(variable.value, str)), "")


def _started(variables: dict[str, Variable], name: str) -> str:
    for variable in _beside(variables, name, DATE_NAMES):
        with suppress(ValueError, OverflowError):
            if started := _date(variable.value):
                return started
    return ""


def _date(value: object) -> str:
    """Return ISO 8601, without an offset where the file tells none; empty for what is no date."""
    if isinstance(value, str):
        with suppress(ValueError):
            return datetime.fromisoformat(value.strip()).isoformat()
        return datetime.strptime(value.strip(), _DATESTR).isoformat()  # noqa: DTZ007  the file tells no zone
    if isinstance(value, np.ndarray) and value.shape == (6,):
        year, month, day, hour, minute = (int(part) for part in value[:5])
        start = datetime(year, month, day, hour, minute) + timedelta(seconds=float(value[5]))  # noqa: DTZ001
    elif isinstance(value, float) and math.isfinite(value) and value >= _YEAR_ZERO_DAYS + 1:
        start = datetime.fromordinal(int(value) - _YEAR_ZERO_DAYS) + timedelta(days=value % 1.0)
    else:
        return ""
    # a datenum of our days resolves 10 us
    return start.isoformat(timespec="milliseconds")


def _variables_73(path: Path, wanted: Sequence[str]) -> dict[str, Variable]:
    """Return all variables and fields by dotted name; of long vectors only the wanted ones with their samples.

    Raises
    ------
    FileError
        Damaged, or a wanted vector claims more than the file holds.
    """
    with hdf5.opened(path, WHAT) as file:
        looked_at = islice(_datasets(file, "", 0), _MOST)
        return {name: _variable_73(file, path, name, item, name in wanted) for name, item in looked_at}


def _datasets(group: Any, prefix: str, depth: int) -> Iterator[tuple[str, Any]]:
    for name in group:
        # Beside the variables, MATLAB keeps the content of cells in #refs#; links out of the file are not followed.
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue
        item = group[name]
        if isinstance(item, h5py.Dataset):
            yield f"{prefix}{name}", item
        elif isinstance(item, h5py.Group) and depth < _DEEPEST and "MATLAB_sparse" not in item.attrs:
            yield from _datasets(item, f"{prefix}{name}.", depth + 1)


def _variable_73(file: Any, path: Path, name: str, item: Any, wanted: bool) -> Variable:
    shape = tuple(int(size) for size in item.shape if size != 1)
    if "MATLAB_empty" in item.attrs or item.shape is None or item.ndim > 2 or item.dtype.kind not in "iufb":
        return Variable(name, shape)
    is_text = hdf5.text(item.attrs, "MATLAB_class") == "char"
    read = item.size <= _LONGEST_TEXT and item.dtype == np.uint16 if is_text else wanted or item.size <= _SMALL
    if not read:
        return Variable(name, shape, is_real=not is_text)
    values = hdf5.dataset(file, name.replace(".", "/"), path, (0, 1, 2))[...]
    if is_text:
        return Variable(name, value="".join(chr(code) for code in np.ravel(values, order="F")))
    return variable_of(name, values)


def mat_facts(path: Path) -> ExportFacts | None:
    """Return what the variable `radargui` of a MATLAB file tells; None where it is no export of ours."""
    return facts_of_text(_mat_variable(path, FACTS))


def mat_codes(path: Path, facts: ExportFacts) -> RawArray | None:
    """Return the codes in a MATLAB file, shape (n_channels, n_samples); None where they are not what was exported."""
    codes = _mat_variable(path, CODES)
    shape = (facts.digitisation.n_channels, facts.n_samples)
    if not isinstance(codes, np.ndarray) or codes.dtype != np.int16 or codes.size != shape[0] * shape[1]:
        return None
    return codes.reshape(shape) if codes.ndim == 1 else codes.T if codes.shape == shape[::-1] else None


def _mat_variable(path: Path, name: str) -> Any:
    with reading(path, WHAT):
        if not hdf5.is_hdf5(path):
            return read_values(path, name).get(name)
        with hdf5.opened(path, WHAT) as file:
            if name not in file:
                return None
            found = hdf5.dataset(file, name, path)
            if hdf5.text(found.attrs, "MATLAB_class") != "char":
                return found[...].T
            if found.dtype != np.uint16 or found.size > LARGEST_TEXT:
                return None
            return np.ravel(found[...], order="F").astype("<u2").tobytes().decode("utf-16-le", "replace")


def mat_program(path: Path) -> str:
    """Return the program that the text at the beginning of a MATLAB file names; empty where there is none."""
    with path.open("rb") as file:
        found = _WRITTEN_BY.search(file.read(116).decode("ascii", "replace"))
    return found[1].strip(" .\0")[:80] if found else ""


LARGEST_V5_BYTES = 200_000_000
"""Volts and codes that are written as v5, for which all of them must be in memory."""
FACTS, CODES, SCALING = "radargui", "codes", "scaling"
"""All facts as TOML text; codes (n_samples, n_channels); coefficients c_k of volts, a row a channel."""
_FIT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")
_USER_BLOCK = 512  # bytes before HDF5 begins, the fewest it allows: MATLAB's own header stands there
_HEADER = b"MATLAB 7.3 MAT-file, written by RadarGUI".ljust(116) + b"\0" * 8 + b"\x00\x02IM"
"""As MATLAB 7.3 writes it: 116 characters, 8 bytes for a subsystem, version 0x0200 and the order of bytes."""


def write_mat(run: RunStream, path: Path, report: Progress, largest_v5_bytes: int = LARGEST_V5_BYTES) -> None:
    """Write vectors `I1`, `Q1`, ... in volts (or the unit), `Fs` in Hz, `unit`, and all facts as TOML in `radargui`.

    A run of codes holds them untouched, too: `codes` (n_samples, n_channels, int16) and `scaling` (n_channels,
    n_coefficients), volts = sum over k of scaling(channel, k + 1) code^k.
    """
    facts = run.facts
    n_bytes = facts.n_samples * facts.digitisation.n_channels * 10
    if n_bytes > largest_v5_bytes:
        _write_mat73(run, path, report)
        return
    pieces = list(run.pieces())
    raw = cast("RawArray", np.hstack(pieces) if pieces else np.empty((facts.digitisation.n_channels, 0)))
    volts = facts.digitisation.volts(raw)
    content: dict[str, Any] = dict(zip(_variable_names(facts), volts[:, :, None], strict=True))
    content |= _small_variables(facts)
    if facts.digitisation.scaling is not None:
        content[CODES] = raw.T
        content[SCALING] = layout.padded(facts.digitisation.scaling)
    report(0.5)
    # a quarter of a second to load, for those who write such a file
    from scipy.io import savemat

    savemat(path, content, do_compression=True, appendmat=False, long_field_names=True)
    report(1.0)


def _write_mat73(run: RunStream, path: Path, report: Progress) -> None:
    """Write the variables that `write_mat` names; arrays lie in the file with their sides exchanged, as MATLAB does."""
    facts = run.facts
    names, n_samples = _variable_names(facts), facts.n_samples
    scaling = facts.digitisation.scaling
    with h5py.File(path, "w", userblock_size=_USER_BLOCK) as file:
        for name, value in _small_variables(facts).items():
            _put_text(file, name, value) if isinstance(value, str) else _put(file, name, data=np.array([[value]]))
        chunk = min(layout.chunk_length(facts.digitisation.sample_rate_hz), max(n_samples, 1))
        chunks: dict[str, Any] = {"chunks": (1, chunk), **hdf5.COMPRESSION}
        volts = [_put(file, name, shape=(1, n_samples), dtype=np.float64, **chunks) for name in names]
        codes = None
        if scaling is not None:
            codes = _put(file, CODES, shape=(len(names), n_samples), dtype=np.int16, **chunks)
            _put(file, SCALING, data=layout.padded(scaling).T)
        done = 0
        for piece in run.pieces(report):
            end = done + piece.shape[1]
            for dataset, row in zip(volts, facts.digitisation.volts(piece), strict=True):
                dataset[0, done:end] = row
            if codes is not None:
                codes[:, done:end] = piece
            done = end
    with path.open("rb+") as raw:
        raw.write(_HEADER)


def _put(file: Any, name: str, **options: Any) -> Any:
    dataset = file.create_dataset(name, **options)
    dataset.attrs["MATLAB_class"] = np.bytes_("int16" if dataset.dtype == np.int16 else "double")
    return dataset


def _put_text(file: Any, name: str, text: str) -> None:
    codes = np.frombuffer(text.encode("utf-16-le", "replace"), dtype="<u2")
    # what is empty is kept as its size
    dataset = file.create_dataset(name, data=codes[:, None] if text else np.zeros(2, dtype=np.uint64))
    if not text:
        dataset.attrs["MATLAB_empty"] = np.uint8(1)
    dataset.attrs["MATLAB_class"] = np.bytes_("char")
    dataset.attrs["MATLAB_int_decode"] = np.int32(2)


def _variable_names(facts: ExportFacts) -> tuple[str, ...]:
    """Return the names of the channels, ch1, ch2, ... where one cannot be that of a variable."""
    names = facts.digitisation.channel_names
    taken = {*_small_variables(facts), CODES, SCALING}
    if all(_FIT.fullmatch(name) and name not in taken for name in names):
        return names
    return tuple(f"ch{place}" for place in range(1, len(names) + 1))


def _small_variables(facts: ExportFacts) -> dict[str, Any]:
    """Return the variables that hold single values and texts."""
    known = facts.digitisation
    # left out, not NaN, where it is not known: a script that asks for it shall fail, not compute with nothing
    skew = {} if known.channel_skew_s is None else {"channel_skew_s": known.channel_skew_s}
    return {"Fs": known.sample_rate_hz, "unit": known.unit, **skew, "started_at": facts.started_at, FACTS: facts.text()}
