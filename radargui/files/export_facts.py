"""What travels with exported samples, whatever the format: one table that is written and read back."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from typing import Any

import tomlkit

from radargui import __version__
from radargui.model.block import LARGEST_INDEX, Gap, Marker, are_possible
from radargui.model.digitisation import Digitisation
from radargui.model.setup_file import load_toml

FORMAT = "radargui-export"
FORMAT_VERSION = 1
LARGEST_TEXT = 2_000_000
"""Longest table that is read, in characters."""


@dataclass(frozen=True, slots=True)
class ExportFacts:
    """All that is known of a run but its samples.

    Attributes
    ----------
    name
        Stem of the run file.
    digitisation
        Channels, rate, scale, skew, unit, device.
    n_samples
        Stored samples of each channel, lost ones not counted.
    gaps, trigger_index, started_at
        As in `Recording`.
    markers
        The operator's notes at samples.
    setup_toml
        The setup as TOML text; empty where the run holds none.
    session
        Facts of the session by name (name, operator, notes, ...); empty for a run alone.
    """

    name: str
    digitisation: Digitisation
    n_samples: int
    gaps: tuple[Gap, ...] = ()
    trigger_index: int | None = None
    started_at: str = ""
    markers: tuple[Marker, ...] = ()
    setup_toml: str = field(default="", repr=False)
    session: Mapping[str, str] = field(default_factory=dict)

    def started_utc(self) -> datetime | None:
        """Return when the first sample was taken, in UTC without a zone as formats want it; None where unknown."""
        try:
            return datetime.fromisoformat(self.started_at).astimezone(UTC).replace(tzinfo=None)
        except ValueError:
            return None

    def table(self) -> dict[str, Any]:
        """Return the facts as plain values that TOML and JSON can hold; what is not known is left out."""
        # value = sum c_k code^k with the rows of `scaling`
        table: dict[str, Any] = {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "radargui_version": __version__,
            "name": self.name,
            **asdict(self.digitisation),
            "n_samples": self.n_samples,
            "started_at": self.started_at,
            "gaps": [asdict(gap) for gap in self.gaps],
            "markers": [asdict(marker) for marker in self.markers],
            "trigger_index": self.trigger_index,
            "session": dict(self.session) or None,
            "setup": self.setup_toml or None,
        }
        return {key: value for key, value in table.items() if value is not None}

    def text(self) -> str:
        """Return the facts as a TOML text."""
        table = self.table()
        setup = table.pop("setup", None)
        document = tomlkit.document()
        # The long text goes last, but before the tables: in TOML a key behind a table would belong to it.
        tables = {key: table.pop(key) for key in ("gaps", "markers", "session") if table.get(key)}
        for key, value in table.items():
            document[key] = value
        if setup is not None:
            document["setup"] = tomlkit.string(setup, multiline=True)
        for key, value in tables.items():
            document[key] = value
        return tomlkit.dumps(document)


def facts_of_text(text: str) -> ExportFacts | None:
    """Return the facts that a TOML text tells; None where it is none of ours or damaged."""
    if len(text) > LARGEST_TEXT or FORMAT not in text:
        return None
    try:
        table = load_toml(text)
    except ValueError:
        return None
    return facts_of_table(table)


def facts_of_table(table: Any) -> ExportFacts | None:
    """Return the facts that plain values tell; None where they are none of ours or contradict themselves."""
    if not isinstance(table, dict) or table.get("format") != FORMAT or table.get("format_version") != FORMAT_VERSION:
        return None
    try:
        return _facts(table)
    except (KeyError, TypeError, ValueError, OverflowError):
        return None


def _facts(table: Mapping[str, Any]) -> ExportFacts:
    names = tuple(_text(name) for name in table["channel_names"])
    if not names or len(set(names)) != len(names):
        raise ValueError("channel names")
    trigger, skew_s = table.get("trigger_index"), table.get("channel_skew_s")
    gaps = tuple(Gap(_index(row["first_index"]), _index(row["count"]), _text(row["reason"])) for row in table["gaps"])
    if not are_possible(gaps):
        raise ValueError("gaps")
    return ExportFacts(
        name=_text(table["name"]),
        digitisation=Digitisation(
            channel_names=names,
            sample_rate_hz=_number(table["sample_rate_hz"], above=0.0),
            scaling=_scaling(table.get("scaling"), len(names)),
            channel_skew_s=None if skew_s is None else _number(skew_s),
            unit=_text(table["unit"])[:32],
            device=_text(table["device"]),
        ),
        n_samples=_index(table["n_samples"]),
        gaps=gaps,
        trigger_index=None if trigger is None else _index(trigger),
        started_at=_text(table["started_at"])[:64],
        markers=tuple(Marker(_index(row["index"]), _text(row["text"])) for row in table["markers"]),
        setup_toml=_text(table.get("setup", "")),
        session={_text(key): _text(value) for key, value in table.get("session", {}).items()},
    )


def _scaling(rows: Any, n_channels: int) -> tuple[tuple[float, ...], ...] | None:
    if rows is None:
        return None
    scaling = tuple(tuple(_number(value) for value in row) for row in rows)
    if len(scaling) != n_channels or any(not 1 <= len(row) <= 16 for row in scaling):
        raise ValueError("scaling")
    return scaling


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError("a text")
    return value


def _index(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < LARGEST_INDEX:
        raise TypeError("an index")
    return value


def _number(value: Any, above: float = -math.inf) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value) or value <= above:
        raise TypeError("a number")
    return float(value)


def commented(text: str) -> str:
    """Return a text with `# ` before each line, as a CSV file carries it."""
    return "".join(f"# {line}\n" if line else "#\n" for line in text.split("\n"))


def uncommented(lines: Sequence[str]) -> str:
    """Return the text that `commented` was given."""
    return "\n".join(line.rstrip("\r\n").removeprefix("#").removeprefix(" ") for line in lines)
