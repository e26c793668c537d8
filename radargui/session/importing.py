"""Import: recordings of other programs as a session."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Unpack

from radargui.files.formats import format_of, source_program
from radargui.files.raw_file import RawLayout
from radargui.files.reading import ChannelMap, read_mapped, read_recording
from radargui.model.block import Block, Gap
from radargui.model.errors import FileError, RadarGuiError
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.session.info import About
from radargui.session.session import Session

PIECE = 1 << 18


@dataclass(frozen=True, slots=True)
class ImportInput:
    """One recording to be: a file, or channels of several files.

    Attributes
    ----------
    files
        The files it comes from.
    channel_map
        Which of their channels are I1, Q1, ...; None: those that are named so.
    rate_hz
        Sample rate, where the file has none.
    raw
        How the files are laid out where they are plain binary.
    """

    files: tuple[Path, ...]
    channel_map: ChannelMap | None = None
    rate_hz: float | None = None
    raw: RawLayout | None = None

    def read(self) -> Recording:
        """Return the recording.

        Raises
        ------
        FileError
            Unreadable, a channel missing, no sample rate.
        UsageError
            The map names files of its own beside `files`.
        """
        if self.channel_map is not None and self.channel_map.has_paths:
            return read_mapped(self.channel_map, rate_hz=self.rate_hz, name=self.files[0].stem, raw=self.raw)
        return read_recording(self.files[0], channels=self.channel_map, rate_hz=self.rate_hz, raw=self.raw)

    @property
    def label(self) -> str:
        """The files, for people."""
        return ", ".join(str(file) for file in self.files)


@dataclass(frozen=True, slots=True)
class ImportedRun:
    """What became of an input: a run file, or why not."""

    source: ImportInput
    path: Path | None = None
    error: RadarGuiError | None = None


class Import:
    """Recordings of other programs written as the runs of a new session.

    The session is made with the first recording that can be read: where none can, none appears. Its runs hold the
    samples as they were (codes stay codes), and where they came from.

    Parameters
    ----------
    parent
        Folder of sessions.
    setup
        Geometry and processing of the session.
    now
        Date and time with offset from UTC.
    about
        As for any session.
    """

    def __init__(self, parent: Path, setup: Setup, *, now: datetime, **about: Unpack[About]) -> None:
        self.parent, self.setup, self.now, self._about = parent, setup, now, about
        self.session: Session | None = None

    def carry_out(
        self, inputs: Sequence[ImportInput], progress: Callable[[float], None] = lambda _: None
    ) -> Iterator[ImportedRun]:
        """Import one input after the other, then close the session; one that fails does not stop the others.

        Parameters
        ----------
        inputs
            What to import.
        progress
            Called with the share done.

        Raises
        ------
        SessionError
            The session cannot be made.
        """
        try:
            for done, one in enumerate(inputs, start=1):
                yield self._imported(one)
                progress(done / len(inputs))
        finally:
            if self.session is not None:
                self.session.close()

    def _imported(self, one: ImportInput) -> ImportedRun:
        try:
            recording = one.read()
            self._want_fit(recording, one)
        except RadarGuiError as error:
            return ImportedRun(one, error=error)
        return self._written(one, recording)

    def _want_fit(self, recording: Recording, one: ImportInput) -> None:
        wanted = self.setup.n_receivers
        if recording.n_receivers != wanted:
            raise FileError(
                f"{one.label} gives {recording.n_receivers} IQ pairs, the setup has {wanted} receivers.",
                remedy="Choose other channels or another setup.",
            )

    def _written(self, one: ImportInput, recording: Recording) -> ImportedRun:
        if self.session is None:
            self.session = Session.create(self.parent, self.setup, now=self.now, **self._about)
        try:
            with self.session.new_run(
                recording.digitisation,
                started_at=recording.started_at,
                trigger_index=recording.trigger_index,
                attributes=_origin(one, self.now),
            ) as writer:
                for block in blocks(recording):
                    writer.write(block)
        except RadarGuiError as error:
            return ImportedRun(one, error=error)
        return ImportedRun(one, writer.path)


def _origin(one: ImportInput, now: datetime) -> Mapping[str, str]:
    entries = one.channel_map.entries if one.channel_map else ()
    origin = {
        "source": "import",
        "imported_from": "; ".join(file.name for file in one.files),
        "imported_format": format_of(one.files[0], one.raw).name,
        "imported_program": ", ".join(dict.fromkeys(filter(None, map(source_program, one.files)))),
        "imported_at": now.isoformat(timespec="seconds"),
    }
    if one.raw is not None:
        origin["imported_layout"] = one.raw.text
    if entries:
        origin["imported_channels"] = ",".join(f"{entry.target}={entry.variable}" for entry in entries)
    return origin


def blocks(recording: Recording) -> Iterator[Block]:
    """Yield a recording as blocks, each with the absolute index of its first sample and the gap before it."""
    first, index = 0, 0
    before: Gap | None = None
    for gap in [*sorted(recording.gaps, key=lambda gap: gap.first_index), None]:
        end = recording.n_samples if gap is None else min(first + gap.first_index - index, recording.n_samples)
        while first < end:
            count = min(PIECE, end - first)
            yield Block(recording.raw[:, first : first + count], index, before)
            first, index, before = first + count, index + count, None
        if gap is not None:
            index, before = gap.first_index + gap.count, gap
