"""Long recordings: only the stretch around a motion is processed; an hour needs no more memory than a minute."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from radargui.files.reading import read_recording
from radargui.files.run_file import RunStream, read_run, run_stream
from radargui.files.run_layout import PIECE, SUFFIX
from radargui.model.arrays import FloatArray
from radargui.model.errors import FileError
from radargui.model.recording import Excerpt, Recording, as_excerpt
from radargui.signals.long_motion import find_long_motion

LONG_SAMPLES = 1 << 22
"""A recording with more samples a channel (126 s at 33.3 kS/s) is long."""
MAX_SAMPLES = 1 << 19
"""The longest stretch of a long one that is processed (16 s at 33.3 kS/s): moving throughout it takes about 1 GB."""


@dataclass(frozen=True, slots=True)
class LengthLimits:
    """What counts as long, and how much of that is processed, in samples a channel.

    Attributes
    ----------
    long
        More than these are long.
    most
        The longest stretch that is processed.
    piece
        Looked at together.
    """

    long: int = LONG_SAMPLES
    most: int = MAX_SAMPLES
    piece: int = PIECE


LENGTHS = LengthLimits()


def read_for_processing(path: Path, limits: LengthLimits = LENGTHS) -> Recording:
    """Return the recording in a file of any format; of a long run the stretch around its longest motion.

    Parameters
    ----------
    path
        File.
    limits
        What counts as long.

    Raises
    ------
    FileError
        Unreadable, damaged, or of no known format.
    """
    if path.suffix.lower() != SUFFIX:
        return read_recording(path)
    with run_stream(path) as stream:
        facts = stream.facts
        # of a drop of seconds the rest around it is wanted too: noise, hum and zero come from it
        if facts.n_samples <= limits.long:
            return read_run(path)
        pieces = (facts.digitisation.volts(piece) for piece in stream.pieces())
        return _part(stream, *_stretch(pieces, facts.n_samples, facts.digitisation.sample_rate_hz, limits.most))


def read_excerpt(path: Path, excerpt: Excerpt) -> Recording:
    """Return an excerpt of a run file as `read_for_processing` gave it, without looking for the motion again.

    Raises
    ------
    FileError
        Unreadable, damaged, no run file, or not this long.
    """
    with run_stream(path) as stream:
        if not 0 <= excerpt.first_stored < excerpt.last_stored <= excerpt.of_samples == stream.facts.n_samples:
            raise FileError(f"{path}: holds no such excerpt.")
        return _part(stream, excerpt.first_stored, excerpt.last_stored, excerpt.reason)


def shortened(recording: Recording, limits: LengthLimits = LENGTHS) -> Recording:
    """Return a recording as it is; of a long one the stretch around its longest motion."""
    count = recording.n_samples
    if count <= limits.long:
        return recording
    digitisation, time_s = recording.digitisation, recording.file_time_s
    size = limits.piece
    pieces = (digitisation.volts(recording.raw[:, first : first + size]) for first in range(0, count, size))
    first, last, reason = _stretch(pieces, count, digitisation.sample_rate_hz, limits.most)
    time_s = None if time_s is None else time_s[first:last]
    part = replace(recording, raw=recording.raw[:, first:last], file_time_s=time_s)
    return as_excerpt(part, recording.gaps, first, count, reason)


def _part(stream: RunStream, first: int, last: int, reason: str) -> Recording:
    return as_excerpt(stream.recording(first, last), stream.facts.gaps, first, stream.facts.n_samples, reason)


def _stretch(pieces: Iterable[FloatArray], count: int, rate_hz: float, most: int) -> tuple[int, int, str]:
    """Return first and last sample of what is processed of a long recording, and what is said about it."""
    motion = find_long_motion(pieces, rate_hz, most)
    first, last = (0, min(count, most)) if motion is None else (motion.first, motion.last)
    said = f"of {count / rate_hz:.0f} s the {(last - first) / rate_hz:.1f} s "
    if motion is None:
        return first, last, f"{said}at the beginning are shown: nothing moves"
    which = "the motion" if motion.n_motions == 1 else f"the longest of {motion.n_motions} motions"
    return first, last, f"{said}around {which} are processed{', which goes on after them' if motion.cut else ''}"
