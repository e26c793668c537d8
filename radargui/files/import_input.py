"""What one recording of an import is read from."""

from dataclasses import dataclass
from pathlib import Path

from radargui.files.raw_file import RawLayout
from radargui.files.reading import ChannelMap, read_mapped, read_recording
from radargui.model.recording import Recording


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
    name
        Of a recording that comes from several files; None: the stem of the first.
    """

    files: tuple[Path, ...]
    channel_map: ChannelMap | None = None
    rate_hz: float | None = None
    raw: RawLayout | None = None
    name: str | None = None

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
            name = self.name or self.files[0].stem
            return read_mapped(self.channel_map, rate_hz=self.rate_hz, name=name, raw=self.raw)
        return read_recording(self.files[0], channels=self.channel_map, rate_hz=self.rate_hz, raw=self.raw)

    @property
    def label(self) -> str:
        """The files, for people."""
        return ", ".join(str(file) for file in self.files)
