"""The setup in the operator's words: what each value is called, in which unit it is shown, what is wrong with it."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pydantic import ValidationError

from radargui.model.plugins import plugins
from radargui.model.setup import Setup
from radargui.model.setup_error import describe, dotted, faults_in_order, find_place
from radargui.system.resources import resource_table

LINK = "setup:"
"""Before a key in the link that leads to its field."""
_KEY = re.compile(r"\b[a-z]+(?:\[\d+\])?\.[a-z_0-9]+(?:\[\d+\])?")
_OPTION = re.compile(r" \(or --[a-z]+\)")


def parse_number(text: str, scale: float = 1.0) -> float | str | None:
    """Return the number that a text means, the text itself where it means none, None where it is empty.

    A decimal comma is understood. `scale` is shown value per stored value.
    """
    cleaned = text.strip().replace("\u2212", "-")
    if not cleaned:
        return None
    try:
        value = float(cleaned.replace(",", ".") if cleaned.count(",") == 1 and "." not in cleaned else cleaned)
    except ValueError:
        return cleaned
    return float(f"{value / scale:.12g}")


def _whole(text: str, scale: float) -> object:
    value = parse_number(text, scale)
    return int(value) if isinstance(value, float) and value.is_integer() else value


READERS: dict[str, Callable[[str, float], object]] = {
    "number": parse_number,
    "integer": _whole,
    "string": lambda text, _scale: text.strip() or None,
    "array": lambda text, _scale: [part.strip() for part in text.split(",") if part.strip()] or None,
}
"""What a text means, by the kind of its value; None where it is empty."""


def show_number(value: object, scale: float = 1.0) -> str:
    """Return a stored number as the operator reads it."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "" if value is None else str(value)
    return f"{value * scale:.10g}"


@dataclass(frozen=True, slots=True)
class Words:
    """What a value of the setup is called beside its field.

    Attributes
    ----------
    name, unit
        As written: `Tilt`, `°`.
    scale
        Shown value per stored value: 1000 for a metre shown in mm.
    tip
        What it means.
    choices
        What may be chosen, stored value to words; empty where it is typed.
    empty
        What holds where nothing is typed, said in the empty field; None: something must be typed.
    """

    name: str
    unit: str = ""
    scale: float = 1.0
    tip: str = ""
    choices: Mapping[Any, str] = field(default_factory=dict)
    empty: str | None = None

    @property
    def label(self) -> str:
        """Name and unit as they stand beside the field."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name

    def shown(self, value: object) -> str:
        """Return a stored value as the field shows it."""
        if isinstance(value, (list, tuple)):
            return ", ".join(show_number(one, self.scale) for one in value)
        if isinstance(value, bool):
            return "yes" if value else "no"
        return self.choices.get(value) or show_number(value, self.scale)

    def with_unit(self, value: object) -> str:
        """Return a stored value with its unit; `not set` where there is none."""
        return f"{self.shown(value)}{self.tail}" if value is not None else "not set"

    @property
    def tail(self) -> str:
        """The unit as it follows a number: the sign of a degree without a space (SI Brochure, 5.4.3)."""
        return f"{'' if self.unit == '°' else ' '}{self.unit}" if self.unit else ""


_TABLE = resource_table("window/words")
FORMS: dict[str, dict[str, Any]] = _TABLE["forms"]
UNKNOWNS: dict[str, dict[str, Any]] = _TABLE["unknowns"]
"""What a calibration may change: its title, and the values of the setup that are its priors."""
_ANTENNAS: dict[str, str] = _TABLE["antennas"]
_UNCERTAIN: dict[str, dict[str, Any]] = _TABLE["uncertain"]
"""Standard uncertainties of what has no field."""
_WORDS = {key: Words(**found | {"choices": dict(found.get("choices", ()))}) for key, found in _TABLE["values"].items()}
_BY = _WORDS["processing.correction"]
_BARE = re.compile(r"(?<![\w.:\]])[a-z]+(?:_[a-z0-9]+)+\b")
_RECEIVER = re.compile(r"\breceiver\[(\d+)\](?!\.)")
_LAST: dict[str, list[str]] = {}
for _key in _WORDS:
    _LAST.setdefault(_key.rpartition(".")[2], []).append(_key)
_NAMES = {last: _WORDS[keys[0]].name for last, keys in _LAST.items() if len({_WORDS[key].name for key in keys}) == 1}
"""What a key is called that stands without its table, where that is told by its last word alone."""
_ADDED = {name: name for name in plugins("corrections")}
_WORDS["processing.correction"] = replace(_BY, choices={**_BY.choices, **_ADDED})


def words_of(key: str) -> Words:
    """Return what the value of a key is called; one that has no field is called by its key.

    Parameters
    ----------
    key
        As in error messages, counted from 1: `receiver[2].tilt_deg`, `tracer.release_position_m[3]`.
    """
    words = _WORDS.get(re.sub(r"\[\d+\]", "", key))
    if words is None:
        return words_of_u(key) if ".u_" in key else Words(key)
    if words.name.endswith(" x, y, z") and key.endswith("]"):
        return replace(words, name=f"{words.name.removesuffix(' x, y, z')} {'xyz'[int(key[-2]) - 1]}")
    return words


def words_of_u(key: str) -> Words:
    """Return what a standard uncertainty is called: by the value that it belongs to."""
    value, last = key.replace(".u_", "."), key.rpartition(".")[2]
    if (words := words_of(value)).name != value:
        return replace(words, name=f"{words.name.removeprefix('or ')} ±", choices={})
    return Words(**_UNCERTAIN[last]) if last in _UNCERTAIN else Words(key)


def parts_of(key: str) -> list[str | int]:
    """Split `receiver[2].tilt_deg` into receiver, 1, tilt_deg."""
    names = re.findall(r"[^.\[\]]+", key)
    return [int(name) - 1 if name.isdecimal() else name for name in names]


def kind_of(key: str) -> str:
    """Return what stands at a key: a string, number, integer, boolean or array of texts, or a place in space."""
    place = find_place(Setup, parts_of(key))
    if place is None:
        raise KeyError(key)
    is_vector = place.is_list and place.entry(0).schema["type"] == "number"
    return "place" if is_vector else str(place.schema["type"])


def entries_of(key: str) -> int:
    """Return how many numbers a place has: three of one in space, two of one on a floor."""
    place = find_place(Setup, parts_of(key))
    return 1 if place is None else len(place.schema.get("prefixItems", (1, 2, 3)))


def limits_of(key: str) -> tuple[float, float]:
    """Return the least and the most that a number may be, as it is stored.

    Raises
    ------
    KeyError
        No such number, or it has no limits of its own.
    """
    place = find_place(Setup, parts_of(key))
    if place is None:
        raise KeyError(key)
    return float(place.schema["minimum"]), float(place.schema["maximum"])


def is_of_antenna(key: str) -> bool:
    """Return whether the field of a key stands in the panel of the antennas."""
    return re.split(r"[.\[]", key)[0] in _ANTENNAS


def called(key: str) -> str:
    """Return whose value it is and what it is called: `Receiver 2: Tilt`."""
    return f"{_whose(key)}{words_of(key).name}"


def called_u(key: str) -> str:
    """Return the same of a standard uncertainty: `Receiver 2: Polarisation ±`."""
    return f"{_whose(key)}{words_of_u(key).name}"


def _whose(key: str) -> str:
    table, _, _ = key.partition(".")
    name, _, number = table.rstrip("]").partition("[")
    whose = f"{_ANTENNAS.get(name, '')} {number}".strip()
    return f"{whose}: " if whose else ""


def field_in(text: str) -> str:
    """Return the first key of a sentence about the setup that has a field; empty where there is none."""
    return next((found[0] for found in _KEY.finditer(text) if words_of(found[0]).name != found[0]), "")


def in_words(text: str, *, linked: bool = False) -> str:
    """Return a sentence about the setup with the names that the fields have; other words with a point stay.

    Parameters
    ----------
    text
        With keys as in the setup file, receivers counted from 1; a key may stand without its table.
    linked
        Whether a link to its field follows each key; `text` is HTML then.
    """

    def named(found: re.Match[str]) -> str:
        key = found[0]
        if words_of(key).name == key:
            return key
        return f"“{called(key)}”" + link(key)

    def without_table(found: re.Match[str]) -> str:
        last = found[0]
        if last not in _NAMES:
            return last
        # which of several receivers is meant is not said
        (key, *others) = _LAST[last]
        is_one = not others and not key.startswith("receiver.")
        return f"“{_NAMES[last]}”" + (link(key) if is_one else "")

    def link(key: str) -> str:
        return f' (<a href="{LINK}{key}">Go there</a>)' if linked else ""

    # the form has no options of the command line
    text = _KEY.sub(named, _OPTION.sub("", text)).replace("[[receiver]]", "receivers")
    text = _BARE.sub(without_table, text)
    return _RECEIVER.sub(r"receiver \1", text)


def faults_of(error: ValidationError) -> tuple[dict[str, str], str]:
    """Return what is wrong with each value, in the words and the unit of its field, and the worst of it in one line."""
    faults: dict[str, str] = {}
    for fault in faults_in_order(error):
        key, place, text = dotted(fault["loc"]), find_place(Setup, fault["loc"]), ""
        if fault["type"] == "value_error":
            # what concerns several values, or a whole table, is said at the one it begins with
            of_table = bool(key) and place is not None and place.is_table
            sentence = f"{key}.{fault['ctx']['error']}" if of_table else str(fault["ctx"]["error"])
            text, named = in_words(sentence), _KEY.search(sentence)
            key = named[0] if named and (of_table or not key) else key
        words = words_of(key)
        if not text:
            shown = words.shown(fault["input"]) if fault["type"] != "missing" else ""
            allowed = place.allowed(words.scale) if place is not None else fault["msg"]
            text = f"{shown} is not allowed" if shown else "a value is needed"
            text = f"{text}: {allowed}{words.tail}"
        faults.setdefault(key, text)
    key, text = next(iter(faults.items()))
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    panel = "Antenna calibration" if is_of_antenna(key) else "Hardware setup"
    has_field = _WORDS.get(re.sub(r"\[\d+\]", "", key)) is not None
    return faults, f"{panel}, {called(key)}: {text}{more}" if has_field else describe(error, Setup)
