"""What travels with exported samples, whatever the format: one table that is written and read back."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from typing import Any

import tomlkit
from pydantic import TypeAdapter

from radargui import __version__
from radargui.model.block import LARGEST_INDEX, Gap, Marker, are_possible
from radargui.model.digitisation import Digitisation
from radargui.model.setup_file import load_toml

FORMAT = "radargui-export"
FORMAT_VERSION = 1
LARGEST_TEXT = 2_000_000
"""Longest table that is read, in characters."""
_MOST_COEFFICIENTS = 16
"""Of a scaling polynomial: NI's have 4 at most, and what is far longer is damage."""


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


_FACTS = TypeAdapter(ExportFacts)


def facts_of_table(table: Any) -> ExportFacts | None:
    """Return the facts that plain values tell; None where they are none of ours or contradict themselves."""
    if not isinstance(table, dict) or table.get("format") != FORMAT or table.get("format_version") != FORMAT_VERSION:
        return None
    try:
        # As JSON: there a strict check takes a list for a tuple and a table for a dataclass, but no text for a number.
        text = json.dumps({**table, "digitisation": table, "setup_toml": table.get("setup", "")}, allow_nan=False)
        facts = _FACTS.validate_json(text, strict=True)
    except (TypeError, ValueError, RecursionError):
        return None
    known = facts.digitisation
    scaling = known.scaling or ((0.0,),) * known.n_channels
    indices = [facts.n_samples, facts.trigger_index or 0, *(marker.index for marker in facts.markers)]
    is_sound = (
        0 < known.n_channels == len(set(known.channel_names)) == len(scaling)
        and all(1 <= len(row) <= _MOST_COEFFICIENTS for row in scaling)
        and known.sample_rate_hz > 0.0
        and all(0 <= index < LARGEST_INDEX for index in indices)
        and are_possible(facts.gaps)
    )
    # cut: what stands in the header of a run and in lists must not be a book
    known = replace(known, unit=known.unit[:32])
    return replace(facts, digitisation=known, started_at=facts.started_at[:64]) if is_sound else None


def commented(text: str) -> str:
    """Return a text with `# ` before each line, as a CSV file carries it."""
    return "".join(f"# {line}\n" if line else "#\n" for line in text.split("\n"))


def uncommented(lines: Sequence[str]) -> str:
    """Return the text that `commented` was given."""
    return "\n".join(line.rstrip("\r\n").removeprefix("#").removeprefix(" ") for line in lines)
