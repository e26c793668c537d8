"""Long recordings: only the stretch around a motion is processed; an hour needs no more memory than a minute."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from radargui.conditioning.long_motion import LongMotion, find_long_motion
from radargui.files.run_file import RunStream, read_run, run_stream
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.block import Gap
from radargui.model.digitisation import Digitisation
from radargui.model.errors import FileError
from radargui.model.recording import Excerpt, Recording

LONG_SAMPLES = 1 << 22
"""A recording with more samples a channel (126 s at 33.3 kS/s) is long."""
MOST_SAMPLES = 1 << 19
"""The longest stretch of a long one that is processed (16 s at 33.3 kS/s): moving throughout it takes about 1 GB."""
_PIECE = 1 << 18
"""Samples a channel read at once: 2 MB each as float64."""


def read_for_processing(path: Path) -> Recording:
    """Return the recording in a run file; of a long one the stretch around its longest motion.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with run_stream(path) as stream:
        facts = stream.facts
        if facts.n_samples <= LONG_SAMPLES:
            return read_run(path)
        motion = find_long_motion(
            (facts.digitisation.volts(piece) for piece in stream.pieces()),
            facts.digitisation.sample_rate_hz,
            MOST_SAMPLES,
        )
        first, last = _span(motion, facts.n_samples)
        return _part(stream, first, last, _reason(last - first, facts.n_samples, facts.digitisation, motion))


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


def read_again(path: Path, recording: Recording) -> Recording:
    """Return a recording with the samples that its run file holds, all of them or those of its excerpt.

    Parameters
    ----------
    path
        Run file.
    recording
        As `read_for_processing` gave it; its samples may have been left out.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    excerpt = recording.excerpt
    if excerpt is None:
        return read_run(path)
    with run_stream(path) as stream:
        return replace(recording, raw=stream.part(excerpt.first_stored, excerpt.last_stored))


def shortened(recording: Recording) -> Recording:
    """Return a recording as it is; of a long one the stretch around its longest motion."""
    count = recording.n_samples
    if count <= LONG_SAMPLES:
        return recording
    motion = find_long_motion(
        _pieces(recording.raw, recording.digitisation), recording.digitisation.sample_rate_hz, MOST_SAMPLES
    )
    first, last = _span(motion, count)
    part = replace(
        recording,
        raw=recording.raw[:, first:last],
        file_time_s=None if recording.file_time_s is None else recording.file_time_s[first:last],
    )
    return _placed(part, recording.gaps, first, count, _reason(last - first, count, recording.digitisation, motion))


def _part(stream: RunStream, first: int, last: int, reason: str) -> Recording:
    facts = stream.facts
    part = Recording(
        name=facts.name,
        raw=stream.part(first, last),
        digitisation=facts.digitisation,
        trigger_index=facts.trigger_index,
        started_at=facts.started_at,
    )
    return _placed(part, facts.gaps, first, facts.n_samples, reason)


def _pieces(raw: RawArray, digitisation: Digitisation) -> Iterator[FloatArray]:
    for first in range(0, raw.shape[1], _PIECE):
        yield digitisation.volts(raw[:, first : first + _PIECE])


def _span(motion: LongMotion | None, count: int) -> tuple[int, int]:
    return (0, min(count, MOST_SAMPLES)) if motion is None else (motion.first, motion.last)


def _placed(part: Recording, gaps: Sequence[Gap], first: int, count: int, reason: str) -> Recording:
    """Return a part that begins at stored sample `first` with its gaps and its place in the whole."""
    inside: list[Gap] = []
    before = 0
    for gap in sorted(gaps, key=lambda gap: gap.first_index):
        stored = gap.first_index - before - sum(one.count for one in inside)
        if stored <= first:
            before += gap.count
        elif stored < first + part.n_samples:
            inside.append(gap)
    first_index = first + before
    return replace(
        part,
        gaps=tuple(replace(gap, first_index=gap.first_index - first_index) for gap in inside),
        excerpt=Excerpt(first, first + part.n_samples, first_index, count, reason),
    )


def _reason(part: int, whole: int, digitisation: Digitisation, motion: LongMotion | None) -> str:
    rate_hz = digitisation.sample_rate_hz
    said = f"of {whole / rate_hz:.0f} s the {part / rate_hz:.1f} s "
    if motion is None:
        return said + "at the beginning are shown: nothing moves"
    if motion.n_motions == 1:
        said += "around the motion are processed"
    else:
        said += f"around the longest of {motion.n_motions} motions are processed"
    return said + (", which goes on after them" if motion.cut else "")
