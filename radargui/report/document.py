"""The report as a list of sections made of blocks; PDF and HTML are drawn from the same."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Literal, TypeAlias

from jinja2 import Environment, PackageLoader, StrictUndefined

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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

    @property
    def turned(self) -> Grid:
        """The table with its columns as rows."""
        header, *rows = zip(self.header, *self.rows, strict=True)
        return Grid(header, tuple(rows), self.title)


@dataclass(frozen=True, slots=True)
class Note:
    """A paragraph; a warning stands out."""

    text: str
    warning: bool = False
    kind: Literal["note"] = "note"


@dataclass(frozen=True, slots=True)
class Picture:
    """A page of figures, drawn when it is needed."""

    title: str
    draw: Callable[[], Figure] = field(repr=False)
    kind: Literal["picture"] = "picture"


Content: TypeAlias = Facts | Grid | Note


@dataclass(frozen=True, slots=True)
class Chapter:
    """Part of the report: text first, then pictures."""

    title: str
    blocks: tuple[Content, ...] = ()
    pictures: tuple[Picture, ...] = ()


@dataclass(frozen=True, slots=True)
class Document:
    """The whole report."""

    title: str
    author: str
    sections: tuple[Chapter, ...]


@lru_cache(maxsize=1)
def templates() -> Environment:
    """Return the templates of HTML; every text is escaped."""
    return Environment(loader=PackageLoader("radargui.report"), autoescape=True, undefined=StrictUndefined)
