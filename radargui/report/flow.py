"""Place text, tables and figures below each other on pages of paper."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from radargui.report import sheet
from radargui.report.canvas import Canvas, Line
from radargui.report.document import Chapter, Content, Drawing, Facts, Grid, Note, with_powers
from radargui.report.sheet import Paper

_LARGE, _SMALL = 8.0, 6.5
"""Sizes of text in points."""
_LEAST = {_LARGE: 6.5, _SMALL: 5.5}
"""A table that is too wide is set in a smaller size, down to this one; then its cells are broken."""
_COLUMN_GAP_MM = 4.0
"""Between columns of a table (chosen by hand): in less, two figures beside each other are read as one."""
_LEAST_COLUMN_MM = 18.0
"""About twelve letters at 8 points (chosen by hand): narrower columns would break their words."""
_LABELS_MM = (13.0, 10.0)
"""Room that a figure needs left of its frames and beneath."""
_FREE_MM = 20.0
"""Above the edge of the paper."""
_RULE = Line("#404040", 0.5)
_WARNING_COLOUR = "#a02000"


def text_pages(chapter: Chapter, paper: Paper = "a4") -> list[Figure]:
    """Return the pages that a chapter's blocks fill, without header and footer; none where it has no blocks."""
    if not chapter.blocks:
        return []
    flow = _Flow(paper, small=chapter.small)
    for block in chapter.blocks:
        flow.put(block)
    return flow.pages


class _Flow:
    """Places blocks below each other and begins a new page where one is full."""

    def __init__(self, paper: Paper, *, small: bool) -> None:
        self._paper = paper
        self._size = _SMALL if small else _LARGE
        self._line = 0.525 * self._size
        self._gap = 0.6 * self._size
        self._last = sheet.PAPERS_MM[paper][1] - _FREE_MM
        self.pages: list[Figure] = []
        self.y = self.paragraph_end = 0.0
        self._new_page()

    def put(self, block: Content) -> None:
        """Add one block."""
        if isinstance(block, Note):
            self._note(block)
        elif isinstance(block, Drawing):
            self._drawing(block)
        else:
            self.y = max(self.y, self.paragraph_end + self._gap)
            self._title(block.title, len(block.rows))
            if isinstance(block, Facts):
                self._facts(block)
            else:
                self._grid(block)
        self.y += self._gap

    def _new_page(self) -> None:
        self.pages.append(sheet.new_page(self._paper))
        self._canvas = Canvas(self.pages[-1])
        self.y = sheet.TOP_MM + self._line
        self.paragraph_end = 0.0

    def _room(self, height_mm: float) -> bool:
        """Begin a new page where `height_mm` does not fit; True if so."""
        full = self.y + height_mm > self._last
        if full:
            self._new_page()
        return full

    def _write(self, x_mm: float, text: str, below_mm: float = 0.0, size: float = 0.0, **looks: Any) -> None:
        self._canvas.write(x_mm, self.y + below_mm, text, size or self._size, **looks)

    def _title(self, text: str, rows: int) -> None:
        self._room((min(rows, 4) + 2) * self._line)
        size = 1.19 * self._size
        # bold letters are wider
        for line in sheet.wrapped(sheet.printable(text), size, 0.9 * sheet.ROOM_MM) if text else ():
            self._write(sheet.LEFT_MM, line, size=size, bold=True)
            self.y += 1.2 * self._line
        self.y += 0.16 * self._line

    def _drawing(self, block: Drawing) -> None:
        left, below = _LABELS_MM
        self.y = max(self.y, self.paragraph_end + self._gap)
        self._room((block.height_mm or 40.0) + below + self._line)
        if block.title:
            self._title(block.title, 0)
        height = block.height_mm or self._last + 4.0 - self.y - below
        area = sheet.Area(sheet.LEFT_MM + left, self.y, sheet.ROOM_MM - left, height)
        block.draw(self.pages[-1], area)
        self.y += height + below

    def _facts(self, block: Facts) -> None:
        names = max((sheet.width_mm(name, self._size) for name, _ in block.rows), default=0.0)
        values_mm = min(names + 6.0, 0.4 * sheet.ROOM_MM)
        for name, value in block.rows:
            room = sheet.ROOM_MM - values_mm
            for number, line in enumerate(sheet.wrapped(sheet.printable(with_powers(value)), self._size, room)):
                self._room(self._line)
                if number == 0:
                    self._write(sheet.LEFT_MM, sheet.printable(name), colour="#505050")
                self._write(sheet.LEFT_MM + values_mm, line)
                self.y += self._line

    def _note(self, block: Note) -> None:
        colour, indent_mm = (_WARNING_COLOUR, 4.0) if block.warning else ("black", 0.0)
        for line in sheet.wrapped(sheet.printable(with_powers(block.text)), self._size, sheet.ROOM_MM - 4.0):
            self._room(self._line)
            self._write(sheet.LEFT_MM + indent_mm, line, colour=colour)
            self.y += self._line
        self.paragraph_end = self.y
        self.y -= self._gap - 2.0

    def _grid(self, block: Grid) -> None:
        cells = [[sheet.printable(with_powers(cell)) for cell in row] for row in (block.header, *block.rows)]
        size = _fitting_size(cells, self._size)
        widths = _column_widths(cells, size, block.left)
        header, *rows = (
            [sheet.wrapped(cell, size, width) for cell, width in zip(row, widths, strict=True)] for row in cells
        )

        def put(row: list[list[str]], *, bold: bool = False) -> None:
            x = sheet.LEFT_MM
            for number, (lines, width) in enumerate(zip(row, widths, strict=True)):
                place, align = (x, 0.0) if number in block.left else (x + width, 1.0)
                for below, line in enumerate(lines):
                    self._write(place, line, below * self._line, size, align=align, bold=bold)
                x += width + _COLUMN_GAP_MM
            self.y += self._height(row)

        def underline() -> None:
            left, y = sheet.LEFT_MM, self.y - 0.67 * self._line
            self._canvas.line(np.array([[left, y], [left + _length(widths), y]]), _RULE)

        def head() -> None:
            put(header, bold=True)
            underline()
            self.y += 0.28 * self._line

        head()
        for row in rows:
            if self._room(self._height(row)):
                head()
            put(row)
        underline()

    def _height(self, row: list[list[str]]) -> float:
        return max(len(lines) for lines in row) * self._line


def _length(widths: list[float]) -> float:
    return sum(widths) + _COLUMN_GAP_MM * (len(widths) - 1)


def _natural(cells: list[list[str]], size: float) -> list[float]:
    return [
        max(sheet.width_mm(cell, size, bold=number == 0) for number, cell in enumerate(column)) + 0.5
        for column in zip(*cells, strict=True)
    ]


def _fitting_size(cells: list[list[str]], size: float) -> float:
    """Return a size at which the table fits the page's width without breaking cells, not below the least one."""
    least = _LEAST[size]
    while size > least and _length(_natural(cells, size)) > sheet.ROOM_MM:
        size -= 0.5
    return size


def _column_widths(cells: list[list[str]], size: float, left: tuple[int, ...]) -> list[float]:
    """Return widths that fill at most the page: heads give way first, then columns of words, then those of numbers."""
    whole = _natural(cells, size)
    words = [[max(head.split(), key=len, default="") for head in cells[0]], *cells[1:]]
    widths = _natural(words, size)
    wanted = sum(whole) - sum(widths)
    if wanted > 0.0:
        share = min(1.0, max(0.0, sheet.ROOM_MM - _length(widths)) / wanted)
        widths = [least + share * (most - least) for least, most in zip(widths, whole, strict=True)]
    for giving in (set(left), set(range(len(widths)))):
        most = max(widths)
        while most > _LEAST_COLUMN_MM and _length(widths) > sheet.ROOM_MM:
            most -= 0.1
            widths = [min(width, most) if number in giving else width for number, width in enumerate(widths)]
    return widths
