"""Any file that is read, as one recording."""

import re
from collections.abc import Sequence
from pathlib import Path

from radargui.files.assemble import SAME_RATE, assemble
from radargui.files.channel_map import ChannelMap, read_mapped
from radargui.files.formats import RUN, format_of, list_channels
from radargui.files.raw_file import RawLayout
from radargui.files.refusal import listed
from radargui.files.run_file import read_run
from radargui.files.signals import ChannelInfo
from radargui.model.digitisation import iq_names
from radargui.model.errors import FileError
from radargui.model.recording import Recording

__all__ = ["list_channels", "read_recording"]

_CANONICAL = re.compile(r"[IQ]\d+")


def read_recording(
    path: Path,
    *,
    channels: ChannelMap | None = None,
    rate_hz: float | None = None,
    any_names: bool = False,
    raw: RawLayout | None = None,
) -> Recording:
    """Return the recording in a file: RadarGUI run, CSV, MATLAB, TDMS or SigMF by its suffix, else plain binary.

    Parameters
    ----------
    path
        The file; its stem becomes the recording's name.
    channels
        Which of its columns or variables are I1, Q1, ...; None: those that are named so.
    rate_hz
        Sample rate, where the file has none.
    any_names
        Take all channels under the names they have, whatever these are.
    raw
        How a plain binary file is laid out.

    Raises
    ------
    FileError
        Unreadable, no I and Q in it, no sample rate.
    UsageError
        The map names files of its own, or a layout is given for a file that has its own.
    """
    kind = format_of(path, raw)
    if channels is not None:
        return read_mapped(channels, file=path, rate_hz=rate_hz, raw=raw)
    if kind is RUN:
        return _run(path, rate_hz)
    infos = kind.list(path)
    names = [info.name for info in infos] if any_names else canonical_names(infos, path)
    if not names:
        raise FileError(f"{path} holds no samples.")
    return assemble([kind.read(path, names)], names, name=path.stem, where=str(path), rate_hz=rate_hz)


def canonical_names(infos: Sequence[ChannelInfo], path: Path) -> list[str]:
    """Return the channels of a file that are named I1, Q1, ... in canonical order.

    Raises
    ------
    FileError
        None is named so, or a pair is incomplete.
    """
    names = [info.name for info in infos]
    present = {name for name in names if _CANONICAL.fullmatch(name)}
    if not present:
        raise FileError(
            f"{path} holds no channels named I1, Q1, ...; it holds {listed(names) or 'no channel'}.",
            remedy=f"Say which is which: {_example(names)}" if len(names) > 1 else "",
        )
    wanted = iq_names(len(present) // 2)
    if set(wanted) != present:
        raise FileError(
            f"{path}: its channels {listed(sorted(present))} are not complete pairs I1, Q1, I2, ...",
            remedy=f"Say which is which: {_example(names)}",
        )
    return list(wanted)


def _example(names: Sequence[str]) -> str:
    text = f"--channels I1={names[0]},Q1={names[1]}" if len(names) > 1 else "--channels I1=...,Q1=..."
    return f'--channels "{text.removeprefix("--channels ")}"' if " " in "".join(names[:2]) else text


def _run(path: Path, rate_hz: float | None) -> Recording:
    recording = read_run(path)
    own_hz = recording.digitisation.sample_rate_hz
    if rate_hz is not None and abs(rate_hz - own_hz) > SAME_RATE * own_hz:
        raise FileError(
            f"{path} was recorded at {own_hz:.6g} Hz, --rate-hz says {rate_hz:.6g} Hz.", remedy="Leave --rate-hz out."
        )
    return recording
