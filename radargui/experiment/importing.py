"""Import files: what they say of themselves, which channel is which, and the session made of them.

Remember which channels the user chose as I1, Q1, ..., for each pattern of channel names.
"""

import json
import logging
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

import platformdirs
from pydantic import AfterValidator, BaseModel, Field

from radargui.experiment.reprocess import process_run
from radargui.files.access import Progress, each_run, silent, write_whole
from radargui.files.formats import RUN, format_of, list_channels, own_setup_of, session_facts_of
from radargui.files.raw_file import RawLayout
from radargui.files.reading import (
    Basis,
    ChannelEntry,
    ChannelGuess,
    ChannelMap,
    ImportInput,
    guess_channel_map,
    guess_of_variables,
    pattern_of,
)
from radargui.files.signals import ChannelInfo
from radargui.model.errors import FileError, RadarGuiError, UsageError, worded
from radargui.model.radar import MAX_RECEIVERS
from radargui.model.recording import iq_names
from radargui.model.result import RunResult
from radargui.model.setup import MEASURING, Setup
from radargui.session.info import SessionDetails, about_setup_file
from radargui.session.transfer import ImportedRun, SessionImport, session_facts

FILE_NAME = "channel-maps.json"
SCHEMA = 1
"""Of the file as this version writes it."""
MAX_PATTERNS = 200
"""Remembered; the oldest are forgotten first. Chosen by hand: a laboratory names its channels in a few ways."""
LARGEST_CHARACTERS = 5_000_000
"""Read of the file: far more than as many patterns take, only damage is longer. Chosen by hand."""
_log = logging.getLogger(__name__)


def _different(places: list[int]) -> list[int]:
    if len(places) % 2 or len(set(places)) != len(places):
        raise ValueError("allowed: a different channel for each I and Q")
    return places


_DIFFERENT = AfterValidator(_different)
_Places = Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=2, max_length=2 * MAX_RECEIVERS), _DIFFERENT]


class _KnownMaps(BaseModel):
    """What the file holds: by pattern of names, the places of I1, Q1, ... among them."""

    schema_version: Literal[1] = Field(alias="schema")
    maps: dict[str, _Places]


class MapMemory:
    """Channel maps by pattern of names, in a small file; a damaged one is set aside and never stops anything.

    Parameters
    ----------
    path
        The file; None: the user's own.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path or platformdirs.user_config_path("radargui", appauthor=False) / FILE_NAME

    def guess(self, infos: Sequence[ChannelInfo]) -> ChannelGuess:
        """Return the map that was chosen for these names before, else a guess from them."""
        places = self._read().get(_key(infos))
        if places is None or max(places) >= len(infos):
            return guess_channel_map(infos)
        return guess_of_variables([infos[place].name for place in places], "remembered")

    def remember(self, infos: Sequence[ChannelInfo], chosen: ChannelMap) -> None:
        """Keep a map for files with these names; where the folder cannot be written it is forgotten."""
        names = [info.name for info in infos]
        variables = [entry.variable for entry in chosen.entries]
        if chosen.has_paths or any(variable not in names for variable in variables):
            return
        maps = self._read()
        key = _key(infos)
        # The newest last: the oldest are forgotten first.
        maps.pop(key, None)
        maps[key] = [names.index(variable) for variable in variables]
        self._write(dict(list(maps.items())[-MAX_PATTERNS:]))

    def _read(self) -> dict[str, list[int]]:
        try:
            with self._path.open(encoding="utf-8") as file:
                return _KnownMaps.model_validate_json(file.read(LARGEST_CHARACTERS), strict=True).maps
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            self._set_aside(error)
            return {}

    def _set_aside(self, error: Exception) -> None:
        aside = self._path.with_name(self._path.name + ".damaged")
        _log.warning("%s cannot be read (%s) and is set aside as %s.", self._path, error, aside.name)
        with suppress(OSError):
            self._path.replace(aside)

    def _write(self, maps: dict[str, list[int]]) -> None:
        text = json.dumps({"schema": SCHEMA, "maps": maps}, ensure_ascii=False, indent=1) + "\n"
        try:
            write_whole(self._path, [text.encode()])
        except FileError as error:
            _log.warning("%s", error)


def _key(infos: Sequence[ChannelInfo]) -> str:
    return json.dumps(pattern_of(infos), ensure_ascii=False)


@dataclass(frozen=True, slots=True)
class ImportOrder:
    """What the operator wants; `inputs` looks into the files and so belongs to the background.

    Attributes
    ----------
    inputs
        Returns what to import.
    setup, setup_file
        Antennas and processing, and the file they come from; None where from none.
    data_folder
        Where the session is made.
    operator, notes
        As for any session.
    process
        Whether the runs are processed.
    """

    inputs: Callable[[], Sequence[ImportInput]]
    setup: Setup
    setup_file: Path | None
    data_folder: Path
    operator: str = ""
    notes: str = ""
    process: bool = True


@dataclass(frozen=True, slots=True)
class Imported:
    """What came of it.

    Attributes
    ----------
    session
        None where no file could be read.
    runs
        One an input, in order.
    not_processed
        Why runs that were imported could not be processed.
    """

    session: Path | None
    runs: tuple[ImportedRun, ...]
    not_processed: tuple[RadarGuiError, ...] = ()

    @property
    def paths(self) -> tuple[Path, ...]:
        """The run files that were made."""
        return tuple(run.path for run in self.runs if run.path is not None)

    @property
    def errors(self) -> tuple[RadarGuiError, ...]:
        """Everything that went wrong."""
        return (*(run.error for run in self.runs if run.error is not None), *self.not_processed)


def import_recordings(order: ImportOrder, progress: Progress = silent) -> Imported:
    """Import what was ordered; a file that fails does not stop the others.

    Parameters
    ----------
    order
        What the operator wants.
    progress
        Called with the share done; what it raises ends the work, and runs that are there already are kept.

    Raises
    ------
    SessionError
        The session cannot be made.
    RadarGuiError
        The choice of channels is not possible.
    """
    inputs = order.inputs()
    work = SessionImport(order.data_folder, order.setup, now=datetime.now().astimezone(), **_about(order, inputs))
    half = 0.5 if order.process else 1.0
    runs = tuple(work.carry_out(inputs, lambda share: progress(half * share)))
    imported = Imported(work.session.path if work.session else None, runs)
    if not order.process:
        return imported
    processed = each_run(imported.paths, _processed, lambda share: progress(0.5 + 0.5 * share))
    return replace(imported, not_processed=tuple(run.error for run in processed if run.error is not None))


def _about(order: ImportOrder, inputs: Sequence[ImportInput]) -> SessionDetails:
    """Return what is known of the session: what the operator says, else what all files say of theirs."""
    # a run file says nothing of its session: session.json beside it does
    stated = [
        session_facts(file.parent) if file.suffix.lower() in RUN.suffixes else session_facts_of(file)
        for one in inputs
        for file in one.files
    ]

    def common(key: str) -> str:
        values = {facts.get(key, "") for facts in stated}
        return values.pop() if len(values) == 1 else ""

    about = SessionDetails(
        operator=order.operator or common("operator"),
        sample=common("sample"),
        target=common("target"),
        notes=order.notes or common("notes"),
    )
    return {**about, **about_setup_file(order.setup_file)}


def _processed(path: Path, progress: Progress) -> RunResult:
    return process_run(path, progress=progress)


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
        The setup that the files bring with them; None where they bring none, or different ones.
    raw
        How the files are laid out where they are plain binary.
    setups_differ
        Which of them brings another setup than which; empty where none does.
    """

    files: tuple[Path, ...]
    together: bool
    infos: tuple[ChannelInfo, ...]
    origin: Mapping[str, tuple[Path, str]]
    names: tuple[str, ...]
    basis: Basis
    setup: Setup | None
    raw: RawLayout | None = None
    setups_differ: str = ""

    @property
    def rate_hz(self) -> float | None:
        """The rate that the files give; None where they do not."""
        return next((info.sample_rate_hz for info in self.infos if info.sample_rate_hz), None)


def look_into(files: Sequence[Path], *, together: bool, raw: RawLayout | None = None) -> FilesLook:
    """Read what the files say, not their samples; of plain binary `raw` says it.

    Raises
    ------
    FileError
        One of them cannot be read.
    """
    together = together and len(files) > 1
    origin: dict[str, tuple[Path, str]] = {}
    infos: list[ChannelInfo] = []
    for file in files if together else files[:1]:
        for info in list_channels(file, raw):
            name = f"{file.name}: {info.name}" if together else info.name
            if name not in origin:
                origin[name] = (file, info.name)
                infos.append(replace(info, name=name))
    guess = MapMemory().guess(infos)
    names = tuple(entry.variable for entry in guess.channel_map.entries) if guess.channel_map else ()
    setup, differ = None, ""
    try:
        setup = common_setup(files[:1] if together else files)
    except UsageError as error:
        differ = str(error)
    return FilesLook(tuple(files), together, tuple(infos), origin, names, guess.basis, setup, raw, differ)


def inputs_of(look: FilesLook, names: Sequence[str], rate_hz: float | None) -> tuple[ImportInput, ...]:
    """Return what to import where the operator chose `names` as I1, Q1, ...; the choice is remembered.

    Raises
    ------
    UsageError
        A channel is chosen twice.
    FileError
        One of the files cannot be read.
    """
    if twice := sorted({name for name in names if list(names).count(name) > 1}):
        raise UsageError(f"chosen twice: {', '.join(twice)}", remedy="Choose another channel for one of them.")
    targets = iq_names(len(names) // 2)
    chosen = ChannelMap(tuple(map(ChannelEntry, targets, names)))
    MapMemory().remember(look.infos, chosen)
    if look.together:
        places = zip(targets, (look.origin[name] for name in names), strict=True)
        whole = ChannelMap(tuple(ChannelEntry(target, variable, file) for target, (file, variable) in places))
        return (ImportInput(whole.paths, whole, rate_hz, look.raw),)
    return tuple(ImportInput((file,), _map_of(file, chosen, look.raw), rate_hz, look.raw) for file in look.files)


def guess_of(file: Path, raw: RawLayout | None = None) -> ChannelGuess | None:
    """Return which channel is which in a file, remembered or guessed; None for a run, whose channels are named so.

    `raw`: how the file is laid out where it is plain binary.

    Raises
    ------
    FileError
        It cannot be read.
    """
    return None if format_of(file, raw) is RUN else MapMemory().guess(list_channels(file, raw))


def remember_map(file: Path, chosen: ChannelMap, raw: RawLayout | None = None) -> None:
    """Keep a choice of channels for files like this one.

    Raises
    ------
    FileError
        It cannot be read.
    """
    MapMemory().remember(list_channels(file, raw), chosen)


def common_setup(files: Iterable[Path]) -> Setup | None:
    """Return the setup that files bring which shall be runs of one session; None where none does.

    Raises
    ------
    UsageError
        Their antennas, spheres or floors are not the same: a session has one setup, and e would be computed with it.
    """
    found: tuple[Setup, Path] | None = None
    for file in files:
        own = valid_setup_of(file)
        if own is None:
            continue
        if found is None:
            found = own, file
        elif any(getattr(own, table) != getattr(found[0], table) for table in MEASURING):
            raise worded(UsageError, "other_setup", file=file, first=found[1])
    return found[0] if found else None


def valid_setup_of(file: Path) -> Setup | None:
    """Return the setup that a file brings; None where it brings none, or one that is not valid."""
    with suppress(RadarGuiError):
        return own_setup_of(file)
    return None


def _map_of(file: Path, chosen: ChannelMap, raw: RawLayout | None) -> ChannelMap | None:
    """Return the map chosen for the first file, or what corresponds to it where the names differ."""
    if format_of(file, raw) is RUN and all(entry.target == entry.variable for entry in chosen.entries):
        return None
    present = {info.name for info in list_channels(file, raw)}
    if all(entry.variable in present for entry in chosen.entries):
        return chosen
    guess = guess_of(file, raw)
    return guess.channel_map if guess else None
