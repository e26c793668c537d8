"""Remember which channels the user chose as I1, Q1, ..., for each pattern of channel names."""

import json
import logging
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

import platformdirs
from pydantic import AfterValidator, BaseModel, Field

from radargui.files.access import write_whole
from radargui.files.reading import LARGEST, ChannelGuess, ChannelMap, guess_channel_map, guess_of_variables, pattern_of
from radargui.files.signals import ChannelInfo
from radargui.model.errors import FileError

FILE_NAME = "channel-maps.json"
SCHEMA = 1
"""Of the file as this version writes it."""
MOST_PATTERNS = 200
"""Remembered; the oldest are forgotten first. Chosen by hand: a laboratory names its channels in a few ways."""
LARGEST_CHARACTERS = 5_000_000
"""Read of the file: far more than as many patterns take, only damage is longer. Chosen by hand."""
_log = logging.getLogger(__name__)


def _different(places: list[int]) -> list[int]:
    if len(places) % 2 or len(set(places)) != len(places):
        raise ValueError("allowed: a different channel for each I and Q")
    return places


_DIFFERENT = AfterValidator(_different)
_Places = Annotated[list[Annotated[int, Field(ge=0)]], Field(min_length=2, max_length=2 * LARGEST), _DIFFERENT]


class _KnownMaps(BaseModel):
    """What the file holds: by pattern of names, the places of I1, Q1, ... among them."""

    schema_version: Literal[1] = Field(alias="schema")
    maps: dict[str, _Places]


def default_memory_path() -> Path:
    """Return the file in the user's own configuration folder; it may not be there yet."""
    return platformdirs.user_config_path("radargui", appauthor=False) / FILE_NAME


class MapMemory:
    """Channel maps by pattern of names, in a small file; a damaged one is set aside and never stops anything.

    Parameters
    ----------
    path
        The file; None: the user's own.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._path = path or default_memory_path()

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
        self._write(dict(list(maps.items())[-MOST_PATTERNS:]))

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
