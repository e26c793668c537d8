"""Decide which channels of which files are I1, Q1, I2, ..., and read them into one recording."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from radargui.files.access import listed
from radargui.files.csv_file import is_time_name
from radargui.files.formats import RUN, SUFFIXES, format_of
from radargui.files.raw_file import RawLayout
from radargui.files.run_file import read_run
from radargui.files.signals import SAME_RATE, ChannelInfo, Signals, assemble
from radargui.model.errors import FileError, UsageError, worded
from radargui.model.radar import MAX_RECEIVERS
from radargui.model.recording import Recording, iq_names

_ENTRY = re.compile(r"\s*([IQ])(\d{1,99})\s*=", re.IGNORECASE)
_SUFFIX = "|".join(re.escape(suffix) for suffix in sorted(SUFFIXES, key=len, reverse=True))
_WITH_SUFFIX = re.compile(rf"(.*?(?:{_SUFFIX})):(.*)", re.IGNORECASE | re.DOTALL)
_NUMBERED = re.compile(r"(.+):\s*(\d+)", re.DOTALL)
_FORM = "Write I1=NAME,Q1=NAME,... or I1=PATH:NAME,Q1=PATH:NAME,..."


@dataclass(frozen=True, slots=True)
class ChannelEntry:
    """One channel of a map.

    Attributes
    ----------
    target
        I1, Q1, ...
    variable
        Name in the file.
    path
        File; None: the input file.
    """

    target: str
    variable: str
    path: Path | None = None


@dataclass(frozen=True, slots=True)
class ChannelMap:
    """Complete pairs I1, Q1, ... in canonical order."""

    entries: tuple[ChannelEntry, ...]

    @property
    def has_paths(self) -> bool:
        """Whether the map itself names the files."""
        return any(entry.path is not None for entry in self.entries)

    @property
    def paths(self) -> tuple[Path, ...]:
        """The files it names, each once, in order."""
        return tuple(dict.fromkeys(entry.path for entry in self.entries if entry.path is not None))


def parse_channel_map(text: str, *, numbered: bool = False) -> ChannelMap:
    r"""Return the map that a text such as `I1=a.mat:src1.Data,Q1=b.mat:src1.Data` or `I1=x,Q1=y` describes.

    A path ends with the suffix of a format that is read, and a colon follows: so `C:\data\a.mat:x` is understood, and
    a name may hold colons. Where channels are `numbered`, as in plain binary, a path may end as it likes. Commas inside
    a path or name are part of it unless `I` or `Q`, a number and `=` follow.

    Raises
    ------
    UsageError
        Not of this form, a channel twice, a pair incomplete.
    """
    starts = [match for match in _ENTRY.finditer(text) if match.start() == 0 or text[match.start() - 1] == ","]
    if not starts or starts[0].start() != 0:
        raise UsageError(f"--channels {text!r} is not a channel map.", remedy=_FORM)
    entries: dict[str, ChannelEntry] = {}
    for match, after in zip(starts, [*starts[1:], None], strict=True):
        value = text[match.end() : after.start() - 1 if after else len(text)].strip()
        target = f"{match[1].upper()}{int(match[2])}"
        if target in entries:
            raise UsageError(f"--channels names {target} twice.", remedy=_FORM)
        entries[target] = _entry(target, value, numbered=numbered)
    return _complete(entries)


def _entry(target: str, value: str, *, numbered: bool) -> ChannelEntry:
    match = (_NUMBERED if numbered else _WITH_SUFFIX).fullmatch(value)
    path, variable = (match[1].strip(), match[2].strip()) if match else ("", value)
    if value.lower().endswith(SUFFIXES):
        raise UsageError(f"--channels: {target}={value} names a file, but nothing in it.", remedy=_FORM)
    if not variable:
        raise UsageError(f"--channels: {target}={value} names no column or variable.", remedy=_FORM)
    return ChannelEntry(target, variable, Path(path) if path else None)


def _complete(entries: dict[str, ChannelEntry]) -> ChannelMap:
    count = max(int(target[1:]) for target in entries)
    if count > MAX_RECEIVERS:
        raise UsageError(f"--channels names receiver {count}; there can be 1 to {MAX_RECEIVERS}.", remedy=_FORM)
    wanted = iq_names(count)
    missing = [target for target in wanted if target not in entries]
    if missing or len(entries) != len(wanted):
        lacking = ", ".join(missing) or "receivers counted from 1"
        raise worded(UsageError, "incomplete_map", lacking=lacking, form=_FORM)
    ordered = tuple(entries[target] for target in wanted)
    if len({(entry.path, entry.variable) for entry in ordered}) != len(ordered):
        raise UsageError("--channels gives the same column or variable to two channels.", remedy=_FORM)
    if len({entry.path is not None for entry in ordered}) > 1:
        raise UsageError("--channels names a path for some channels and none for others.", remedy=_FORM)
    return ChannelMap(ordered)


def read_mapped(
    channel_map: ChannelMap, *, name: str, rate_hz: float | None = None, raw: RawLayout | None = None
) -> Recording:
    """Return the recording that a map describes which names the files.

    Parameters
    ----------
    channel_map
        Which columns or variables of which files.
    name
        Name of the recording.
    rate_hz
        Sample rate where the files have none.
    raw
        How the files are laid out where they are plain binary.

    Raises
    ------
    UsageError
        A layout is given for a file that has its own.
    FileError
        Unreadable, a channel missing, channels that do not fit together.
    """
    # One part a channel, so that the order is the map's, whatever file each comes from.
    parts: dict[str, Signals] = {}
    for path in channel_map.paths:
        some = [entry for entry in channel_map.entries if entry.path == path]
        part = format_of(path, raw).read(path, [entry.variable for entry in some])
        parts |= {one.target: replace(part, signals=(own,)) for one, own in zip(some, part.signals, strict=True)}
    targets = [entry.target for entry in channel_map.entries]
    where = ", ".join(map(str, channel_map.paths))
    return assemble([parts[target] for target in targets], targets, name=name, where=where, rate_hz=rate_hz)


_CANONICAL = re.compile(r"[IQ]\d+")


def read_recording(
    path: Path,
    *,
    channels: ChannelMap | None = None,
    rate_hz: float | None = None,
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
        if channels.has_paths:
            raise UsageError(f"--channels names files of its own: {path} cannot be read with it.", remedy=_FORM)
        own = ChannelMap(tuple(replace(entry, path=path) for entry in channels.entries))
        return read_mapped(own, name=path.stem, rate_hz=rate_hz, raw=raw)
    if kind is RUN:
        return _run(path, rate_hz)
    names = canonical_names(kind.list(path), path)
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
        shown = listed(sorted(present))
        raise worded(FileError, "incomplete_pairs", path=path, names=shown, example=_example(names))
    return list(wanted)


def _example(names: Sequence[str]) -> str:
    text = f"--channels I1={names[0]},Q1={names[1]}" if len(names) > 1 else "--channels I1=...,Q1=..."
    return f'--channels "{text.removeprefix("--channels ")}"' if " " in "".join(names[:2]) else text


def _run(path: Path, rate_hz: float | None) -> Recording:
    recording = read_run(path)
    own_hz = recording.digitisation.sample_rate_hz
    if rate_hz is not None and abs(rate_hz - own_hz) > SAME_RATE * own_hz:
        raise worded(FileError, "other_rate", path=path, own_hz=own_hz, rate_hz=rate_hz)
    return recording


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


Basis = Literal["names", "order", "remembered", "nothing"]

_PARTS = {"i": "I", "inphase": "I", "in-phase": "I", "re": "I", "real": "I"}
_PARTS |= {"q": "Q", "quadrature": "Q", "quad": "Q", "im": "Q", "imag": "Q", "imaginary": "Q"}
_TOKEN = re.compile(r"in-phase|[a-z]+|\d+", re.IGNORECASE)
_LAST_NUMBER = re.compile(r"(\d+)(?=\D*$)")


@dataclass(frozen=True, slots=True)
class ChannelGuess:
    """Which channel is which, for the user to confirm.

    Attributes
    ----------
    channel_map
        None where nothing can be guessed.
    basis
        names: the names say it; order: only their order does, look at it; remembered: as the user chose before.
    """

    channel_map: ChannelMap | None
    basis: Basis


def guess_channel_map(infos: Sequence[ChannelInfo]) -> ChannelGuess:
    """Return the likely channel map of a file: from names that tell I, Q and a number, else from the order.

    Names such as I1, i_1, ch2_Q, rx0/I, I and Q tell it. Otherwise channels are taken in pairs in the order of the
    number at the end of their names (Voltage, Voltage_0, Voltage_1, ...; ai0, ai1, ...), which only the user can
    confirm. Times and channels of another length than most are left out.

    Parameters
    ----------
    infos
        What `list_channels` gives.
    """
    names = [info.name for info in _alike(infos)]
    if by_name := _from_names(names):
        return guess_of_variables(by_name, "names")
    ordered = sorted(names, key=_number_at_end) if _differ_in_number(names) else names
    usable = min(len(ordered) // 2, MAX_RECEIVERS) * 2
    return guess_of_variables(ordered[:usable], "order") if usable else ChannelGuess(None, "nothing")


def guess_of_variables(variables: Sequence[str], basis: Basis) -> ChannelGuess:
    """Return the map that takes `variables` as I1, Q1, ... in this order."""
    return ChannelGuess(ChannelMap(tuple(map(ChannelEntry, iq_names(len(variables) // 2), variables))), basis)


def pattern_of(infos: Sequence[ChannelInfo]) -> tuple[str, ...]:
    """Return what files of one kind have in common: their names, without groups and structures where that is enough."""
    names = [info.name for info in infos]
    short = [re.split(r"[/.]", name)[-1] for name in names]
    return tuple(short if len(set(short)) == len(short) else names)


def _alike(infos: Sequence[ChannelInfo]) -> list[ChannelInfo]:
    samples = [info for info in infos if info.count > 0 and not is_time_name(info.name.strip().rpartition(".")[2])]
    if not samples:
        return []
    # the commonest length, of two as common the longer
    lengths = Counter(info.count for info in samples)
    most = max(lengths, key=lambda length: (lengths[length], length))
    return [info for info in samples if info.count == most]


def _from_names(names: Sequence[str]) -> list[str]:
    """Return names as I1, Q1, I2, ...; empty where they do not tell it without doubt."""
    found: dict[tuple[int, str], str] = {}
    for name in names:
        place = _receiver_and_part(name)
        if place is None:
            continue
        if place in found:
            return []
        found[place] = name
    numbers = sorted({number for number, _ in found})
    wanted = [(number, part) for number in numbers for part in "IQ"]
    return [found[one] for one in wanted] if len(numbers) <= MAX_RECEIVERS and found.keys() >= set(wanted) else []


def _receiver_and_part(name: str) -> tuple[int, str] | None:
    """Return the number (0 where there is none) and I or Q that a name tells; None where it does not."""
    tokens = [token.lower() for token in _TOKEN.findall(name)]
    parts = [_PARTS[token] for token in tokens if token in _PARTS]
    numbers = [int(token[-15:]) for token in tokens if token.isascii() and token.isdigit()]
    if len(parts) != 1:
        return None
    return (numbers[-1] if numbers else 0, parts[0])


def _differ_in_number(names: Sequence[str]) -> bool:
    """Return whether names are the same but for the number at their end, which one of them may lack."""
    stems = {re.sub(r"[_ ]+$", "", _LAST_NUMBER.sub("", name)) for name in names}
    return len(stems) == 1


def _number_at_end(name: str) -> int:
    match = _LAST_NUMBER.search(name)
    return int(match[1][-15:]) if match else -1
