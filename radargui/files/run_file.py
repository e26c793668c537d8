"""Read run files: as a recording, or piece by piece with the table of facts that exports carry."""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from pydantic import TypeAdapter

from radargui import __version__
from radargui.files import hdf5, run_layout as layout
from radargui.files.access import Progress, silent
from radargui.model.arrays import RawArray
from radargui.model.errors import FileError
from radargui.model.recording import LARGEST_INDEX, Digitisation, Gap, Marker, Recording, are_possible
from radargui.model.setup import Setup, load_toml, parse_setup

FORMAT = "radargui-export"
FORMAT_VERSION = 1
"""Of the table as this version writes it."""
LARGEST_TEXT = 2_000_000
"""Longest table that is read, in characters."""
_MAX_COEFFICIENTS = 16
"""Of a scaling polynomial: NI's have 4 at most, and what is far longer is damage."""


@dataclass(frozen=True, slots=True)
class ExportFacts:
    """All that is known of a run but its samples.

    Attributes
    ----------
    name
        Stem of the run file.
    digitisation
        Channels, rate, scale, skew, unit, device.
    n_samples
        Stored samples of each channel, lost ones not counted.
    gaps, trigger_index, started_at
        As in `Recording`.
    markers
        The operator's notes at samples.
    setup_toml
        The setup as TOML text; empty where the run holds none.
    session
        Facts of the session by name (name, operator, notes, ...); empty for a run alone.
    """

    name: str
    digitisation: Digitisation
    n_samples: int
    gaps: tuple[Gap, ...] = ()
    trigger_index: int | None = None
    started_at: str = ""
    markers: tuple[Marker, ...] = ()
    setup_toml: str = field(default="", repr=False)
    session: Mapping[str, str] = field(default_factory=dict)

    def started_utc(self) -> datetime | None:
        """Return when the first sample was taken, in UTC without a zone as formats want it; None where unknown."""
        with suppress(ValueError):
            return datetime.fromisoformat(self.started_at).astimezone(UTC).replace(tzinfo=None)
        return None

    def table(self) -> dict[str, Any]:
        """Return the facts as plain values that TOML and JSON can hold; what is not known is left out."""
        # value = sum c_k code^k with the rows of `scaling`
        table: dict[str, Any] = {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "radargui_version": __version__,
            "name": self.name,
            **asdict(self.digitisation),
            "n_samples": self.n_samples,
            "started_at": self.started_at,
            "trigger_index": self.trigger_index,
            # The long text goes last, but before the tables: in TOML a key behind a table would belong to it.
            "setup": self.setup_toml or None,
            "gaps": [asdict(gap) for gap in self.gaps],
            "markers": [asdict(marker) for marker in self.markers],
            "session": dict(self.session) or None,
        }
        return {key: value for key, value in table.items() if value is not None}

    def text(self) -> str:
        """Return the facts as a TOML text."""
        table = {key: value for key, value in self.table().items() if value != []}
        if self.setup_toml:
            table["setup"] = tomlkit.string(self.setup_toml, multiline=True)
        return tomlkit.dumps(table)


def facts_of_text(text: object) -> ExportFacts | None:
    """Return the facts that a TOML text tells; None where it is no text, none of ours or damaged."""
    if isinstance(text, str) and len(text) <= LARGEST_TEXT and FORMAT in text:
        with suppress(ValueError):
            return facts_of_table(load_toml(text))
    return None


_FACTS = TypeAdapter(ExportFacts)


def facts_of_table(table: Any) -> ExportFacts | None:
    """Return the facts that plain values tell; None where they are none of ours or contradict themselves."""
    if not isinstance(table, dict) or table.get("format") != FORMAT or table.get("format_version") != FORMAT_VERSION:
        return None
    try:
        # As JSON: there a strict check takes a list for a tuple and a table for a dataclass, but no text for a number.
        text = json.dumps({**table, "digitisation": table, "setup_toml": table.get("setup", "")}, allow_nan=False)
        facts = _FACTS.validate_json(text, strict=True)
    except (TypeError, ValueError, RecursionError):
        return None
    known = facts.digitisation
    scaling = known.scaling or ((0.0,),) * known.n_channels
    indices = [facts.n_samples, facts.trigger_index or 0, *(marker.index for marker in facts.markers)]
    is_sound = (
        0 < known.n_channels == len(set(known.channel_names)) == len(scaling)
        and all(1 <= len(row) <= _MAX_COEFFICIENTS for row in scaling)
        and known.sample_rate_hz > 0.0
        and all(0 <= index < LARGEST_INDEX for index in indices)
        and are_possible(facts.gaps)
    )
    # cut: what stands in the header of a run and in lists must not be a book
    known = replace(known, unit=known.unit[:32])
    return replace(facts, digitisation=known, started_at=facts.started_at[:64]) if is_sound else None


def commented(text: str) -> str:
    """Return a text with `# ` before each line, as a CSV file carries it."""
    return "".join(f"# {line}\n" if line else "#\n" for line in text.split("\n"))


def uncommented(lines: Sequence[str]) -> str:
    """Return the text that `commented` was given."""
    return "\n".join(line.rstrip("\r\n").removeprefix("#").removeprefix(" ") for line in lines)


def read_run(path: Path) -> Recording:
    """Return the recording in a run file, also where it was never closed (see `run_is_complete`).

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with run_stream(path) as run:
        recording = run.recording(0, run.facts.n_samples)
        run.want_untouched(hdf5.rows_crc(recording.raw, [0] * len(recording.raw)))
        return recording


def run_is_complete(path: Path) -> bool:
    """Return whether a run file was closed in order; False after a crash or a failure.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with opened_run(path) as file:
        return _complete(file)


def read_run_setup(path: Path) -> Setup | None:
    """Return the setup that a run was recorded with; None where it holds none.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    SetupError
        The setup in it is not valid for this version.
    """
    with opened_run(path) as file:
        toml = hdf5.text(file.attrs, "setup")
    return parse_setup(toml, f"setup in {path}") if toml.strip() else None


def markers_in(file: Any, path: Path) -> tuple[Marker, ...]:
    """Return the notes in an opened run file; FileError where they are damaged."""
    rows = _rows(file, layout.MARKERS, path)
    return tuple(Marker(int(row["index"]), hdf5.decoded(row["text"])) for row in rows)


def _rows(file: Any, table: str, path: Path) -> Any:
    """Return the rows of a table; none where the file has no such table."""
    return hdf5.dataset(file, table, path, (1,))[:] if table in file else ()


@contextmanager
def opened_run(path: Path) -> Iterator[Any]:
    """Open a run file whose header is sound.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        # Where a crash stopped the recording, it may have come between the header and its checksum.
        if _complete(file) and not (hdf5.is_sound(file.attrs) and hdf5.is_sound(file[layout.RAW].attrs)):
            raise FileError(f"{path}: its header is damaged.", remedy="Take the file from a backup.")
        yield file


def _complete(file: Any) -> bool:
    return bool(hdf5.number(file.attrs, "complete"))


def read_gaps(file: Any, path: Path) -> tuple[Gap, ...]:
    """Return the gap records of an opened run file.

    Raises
    ------
    FileError
        They are damaged.
    """
    rows = _rows(file, layout.GAPS, path)
    gaps = tuple(Gap(int(row["first_index"]), int(row["count"]), hdf5.decoded(row["reason"])) for row in rows)
    if not are_possible(gaps):
        raise FileError(f"{path}: its gap records are damaged.")
    return gaps


@dataclass(frozen=True, slots=True)
class RunStream:
    """The samples of an opened run file in pieces, with all that is known of them; see `run_stream`."""

    _file: Any
    path: Path
    facts: ExportFacts

    def pieces(self, report: Progress = silent) -> Iterator[RawArray]:
        """Yield the stored samples in order, untouched, shape (n_channels, at most PIECE), checked at the end.

        Parameters
        ----------
        report
            Called with the share done after each piece.

        Raises
        ------
        FileError
            A piece cannot be read, or the whole does not have the checksum that was stored with it.
        """
        raw, count = self._file[layout.RAW], self.facts.n_samples
        crcs = [0] * raw.shape[0]
        for place in layout.stored_pieces(raw, count):
            piece = self.part(place.start, place.stop)
            crcs = hdf5.rows_crc(piece, crcs)
            yield piece
            report(place.stop / count)
        self.want_untouched(crcs)

    def want_untouched(self, crcs: list[int]) -> None:
        """Refuse, with a FileError, samples that do not have the checksums that were stored with them."""
        known, count = self._file.attrs, self.facts.n_samples
        stored = (hdf5.number(known, "n_samples"), np.ravel(known.get("crc32", ())).tolist())
        if "crc32" in known and stored != (count, crcs):
            raise FileError(f"{self.path}: its samples are damaged.", remedy="Take the file from a backup.")

    def recording(self, first: int, last: int) -> Recording:
        """Return the stored samples first:last as a recording, with the gaps and the trigger of the whole.

        Raises
        ------
        FileError
            They cannot be read.
        """
        known, raw = self.facts, self.part(first, last)
        start = known.started_at
        return Recording(known.name, raw, known.digitisation, known.gaps, None, known.trigger_index, start)

    def part(self, first: int, last: int) -> RawArray:
        """Return the stored samples first:last, untouched.

        Raises
        ------
        FileError
            They cannot be read.
        """
        try:
            return np.asarray(self._file[layout.RAW][:, first:last])
        except (OSError, RuntimeError, ValueError) as error:
            raise FileError(f"{self.path}: its samples are damaged.") from error


@contextmanager
def run_stream(path: Path, session: Mapping[str, str] | None = None) -> Iterator[RunStream]:
    """Open a run file for reading piece by piece.

    Parameters
    ----------
    path
        Run file, also one that was never closed.
    session
        Facts of its session that shall travel with it.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with opened_run(path) as file:
        raw = hdf5.dataset(file, layout.RAW, path, (2,))
        facts = ExportFacts(
            name=path.stem,
            digitisation=layout.read_digitisation(raw, path),
            n_samples=layout.sample_count(file),
            gaps=read_gaps(file, path),
            trigger_index=layout.read_trigger(raw.attrs),
            started_at=hdf5.text(raw.attrs, "started_at"),
            markers=markers_in(file, path),
            setup_toml=hdf5.text(file.attrs, "setup"),
            session=dict(session or {}),
        )
        yield RunStream(file, path, facts)
