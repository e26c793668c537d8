"""What a report says, made once: chapters of blocks, from which PDF and HTML are written."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure


_POWER = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([+-]\d+)(?!\w|\.\w)")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_BETWEEN = 2
"""Columns of a table, in letters."""


@dataclass(frozen=True, slots=True)
class Facts:
    """Names and values, one pair a line."""

    rows: tuple[tuple[str, str], ...]
    title: str = ""
    kind: Literal["facts"] = "facts"

    @classmethod
    def of(cls, rows: Mapping[str, str], title: str = "") -> Facts:
        """Return the values by their name; of what is empty nothing is said."""
        return cls(tuple((name, value) for name, value in rows.items() if value), title)


@dataclass(frozen=True, slots=True)
class Grid:
    """A table with a header; columns named in `left` are set to the left, the others to the right."""

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    title: str = ""
    left: tuple[int, ...] = (0,)
    kind: Literal["grid"] = "grid"

    @classmethod
    def of(cls, rows: Iterable[Mapping[str, str]], title: str = "", left: tuple[int, ...] = (0,)) -> Grid:
        """Return the table of rows, at least one, each with its cells by the title of their column."""
        found = list(rows)
        return cls(tuple(found[0]), tuple(tuple(row.values()) for row in found), title, left)

    def within(self, letters: int) -> Iterator[Grid]:
        """Yield tables beneath one another, none wider than so many letters; each begins with the first column."""
        columns = list(zip(self.header, *self.rows, strict=True))
        # a title is broken between its words, a figure never
        widths = [_BETWEEN + max(map(len, (*title.split(), *cells))) for title, *cells in columns]
        parts = [[0]]
        for number in range(1, len(columns)):
            if len(parts[-1]) > 1 and sum(widths[one] for one in (*parts[-1], number)) > letters:
                parts.append([0])
            parts[-1].append(number)
        for count, part in enumerate(parts):
            header, *rows = zip(*(columns[one] for one in part), strict=True)
            left = tuple(at for at, one in enumerate(part) if one in self.left)
            yield Grid(header, tuple(rows), "" if count else self.title, left)


@dataclass(frozen=True, slots=True)
class Note:
    """A paragraph; a warning stands out."""

    text: str
    warning: bool = False
    kind: Literal["note"] = "note"


@dataclass(frozen=True, slots=True)
class MainResult:
    """What a report is opened for, set large; beneath it what it is."""

    value: str
    words: str
    kind: Literal["answer"] = "answer"


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure, drawn when it is needed.

    Attributes
    ----------
    title
        Written above; the bookmark of a page of its own.
    draw
        Returns it, as large as it is printed.
    """

    title: str
    draw: Callable[[], Figure] = field(repr=False)


@dataclass(frozen=True, slots=True)
class Plots:
    """Figures between the text.

    Attributes
    ----------
    plots
        Beside each other where they are narrow enough, else beneath.
    fitted
        Whether they are made smaller where the page has less room left for them.
    """

    plots: tuple[Picture, ...]
    fitted: bool = False
    kind: Literal["plots"] = "plots"


Content: TypeAlias = Facts | Grid | Note | MainResult | Plots
"""What a chapter holds between its title and its pictures."""


@dataclass(frozen=True, slots=True)
class Chapter:
    """Part of the report.

    Attributes
    ----------
    title
        Above it, and its bookmark.
    blocks
        Text, tables and figures below each other.
    pictures
        Figures behind them, each on a page of its own.
    small
        Whether text is set small, to fit one page.
    follows
        Whether it may begin below what stands before it, else on a page of its own.
    screen
        What HTML shows instead of `blocks`.
    """

    title: str
    blocks: tuple[Content, ...] = ()
    pictures: tuple[Picture, ...] = ()
    small: bool = False
    follows: bool = False
    screen: tuple[Content, ...] | None = None


def with_powers(text: str) -> str:
    """Return a text with its powers of ten as people write them: "8.9e-06" as 8.9 × 10⁻⁶."""
    return _POWER.sub(lambda found: f"{found[1]} × 10{str(int(found[2])).translate(_RAISED)}", text)


@lru_cache(maxsize=1)
def templates() -> Environment:
    """Return the templates; in HTML every text is escaped."""
    # the window shows chapters without them, and would wait for it at its start
    from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

    folder = PackageLoader("radargui.report")
    made = Environment(loader=folder, autoescape=select_autoescape(["html"]), undefined=StrictUndefined)
    made.filters["powers"] = with_powers
    return made
