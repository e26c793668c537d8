"""What the user chose as I1, Q1, ... before, remembered for each pattern of channel names."""

import json
import logging
import os
from collections.abc import Sequence
from pathlib import Path

import platformdirs

from radargui.files.channel_guess import ChannelGuess, guess_channel_map, guess_of_variables, pattern_of
from radargui.files.reading import LARGEST, ChannelMap
from radargui.files.signals import ChannelInfo
from radargui.model.digitisation import iq_names

FILE_NAME = "channel-maps.json"
SCHEMA = 1
MOST_PATTERNS = 200
LARGEST_CHARACTERS = 5_000_000
_log = logging.getLogger(__name__)


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
        return guess_of_variables([infos[place].name for place in places], infos, "remembered")

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
                return _checked(json.loads(file.read(LARGEST_CHARACTERS)))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError, RecursionError) as error:
            self._set_aside(error)
            return {}

    def _set_aside(self, error: Exception) -> None:
        aside = self._path.with_name(self._path.name + ".damaged")
        _log.warning("%s cannot be read (%s) and is set aside as %s.", self._path, error, aside.name)
        try:
            self._path.replace(aside)
        except OSError:
            return

    def _write(self, maps: dict[str, list[int]]) -> None:
        partial = self._path.with_name(f"{self._path.name}.{os.getpid()}.part")
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            text = json.dumps({"schema": SCHEMA, "maps": maps}, ensure_ascii=False, indent=1)
            partial.write_text(text + "\n", encoding="utf-8")
            partial.replace(self._path)
        except OSError as error:
            _log.warning("%s cannot be written: %s", self._path, error)


def _key(infos: Sequence[ChannelInfo]) -> str:
    return json.dumps(pattern_of(infos), ensure_ascii=False)


def _checked(document: object) -> dict[str, list[int]]:
    maps = document.get("maps") if isinstance(document, dict) and document.get("schema") == SCHEMA else None
    if not isinstance(maps, dict) or not all(_is_places(places) for places in maps.values()):
        raise ValueError("not what this version writes")
    return maps


def _is_places(places: object) -> bool:
    allowed = [len(iq_names(count)) for count in range(1, LARGEST + 1)]
    if not isinstance(places, list) or len(places) not in allowed:
        return False
    return len(set(map(str, places))) == len(places) and all(type(place) is int and place >= 0 for place in places)
