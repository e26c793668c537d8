"""What files to be imported say of themselves: their channels, which of them is which, rate, own setup."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from radargui.files.channel_guess import Basis
from radargui.files.channel_map import ChannelEntry, ChannelMap, list_channels
from radargui.files.formats import RUN, format_of
from radargui.files.signals import ChannelInfo
from radargui.model.digitisation import iq_names
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.setup import Setup
from radargui.session.importing import ImportInput, own_setup_of
from radargui.session.map_memory import MapMemory


@dataclass(frozen=True, slots=True)
class FilesLook:
    """What was found in the files.

    Attributes
    ----------
    files
        In the order they were chosen.
    together
        Whether they are one run; else each is one, and `infos` is what the first one holds.
    infos
        Channels to choose from; where the files are one run, each named with its file.
    origin
        File and variable of each channel, by its name in `infos`.
    names
        Names guessed as I1, Q1, ...; empty where nothing can be guessed.
    basis
        What the guess rests on.
    setup
        The setup that the first file brings with it; None where it brings none.
    """

    files: tuple[Path, ...]
    together: bool
    infos: tuple[ChannelInfo, ...]
    origin: Mapping[str, tuple[Path, str]]
    names: tuple[str, ...]
    basis: Basis
    setup: Setup | None

    @property
    def rate_hz(self) -> float | None:
        """The rate that the files tell; None where they do not."""
        return next((info.sample_rate_hz for info in self.infos if info.sample_rate_hz), None)


def look_into(files: Sequence[Path], *, together: bool) -> FilesLook:
    """Read what the files say, not their samples.

    Raises
    ------
    FileError
        One of them cannot be read.
    """
    together = together and len(files) > 1
    origin: dict[str, tuple[Path, str]] = {}
    infos: list[ChannelInfo] = []
    for file in files if together else files[:1]:
        for info in list_channels(file):
            name = f"{file.name}: {info.name}" if together else info.name
            if name not in origin:
                origin[name] = (file, info.name)
                infos.append(replace(info, name=name))
    guess = MapMemory().guess(infos)
    names = tuple(entry.variable for entry in guess.channel_map.entries) if guess.channel_map else ()
    return FilesLook(tuple(files), together, tuple(infos), origin, names, guess.basis, _own_setup(files[0]))


def inputs_of(look: FilesLook, names: Sequence[str], rate_hz: float | None) -> tuple[ImportInput, ...]:
    """Return what to import where the operator chose `names` as I1, Q1, ...; the choice is remembered.

    Raises
    ------
    UsageError
        A channel is chosen twice.
    FileError
        One of the files cannot be read.
    """
    if len(set(names)) != len(names):
        twice = sorted({name for name in names if list(names).count(name) > 1})
        raise UsageError(f"chosen twice: {', '.join(twice)}", remedy="Choose another channel for one of them.")
    targets = iq_names(len(names) // 2)
    chosen = ChannelMap(tuple(map(ChannelEntry, targets, names)))
    memory = MapMemory()
    memory.remember(look.infos, chosen)
    if look.together:
        entries = (
            ChannelEntry(target, look.origin[name][1], look.origin[name][0])
            for target, name in zip(targets, names, strict=True)
        )
        whole = ChannelMap(tuple(entries))
        return (ImportInput(whole.paths, whole, rate_hz),)
    return tuple(ImportInput((file,), _map_of(file, chosen, memory), rate_hz) for file in look.files)


def _map_of(file: Path, chosen: ChannelMap, memory: MapMemory) -> ChannelMap | None:
    """Return the map chosen for the first file, or what corresponds to it where the names differ."""
    if format_of(file) is RUN and all(entry.target == entry.variable for entry in chosen.entries):
        return None
    infos = list_channels(file)
    present = {info.name for info in infos}
    return chosen if all(entry.variable in present for entry in chosen.entries) else memory.guess(infos).channel_map


def _own_setup(file: Path) -> Setup | None:
    try:
        return own_setup_of(file)
    except RadarGuiError:
        return None
