"""Facts, tables and notes flowed onto A4 pages."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from radargui.report.document import Chapter, Content, Facts, Grid, Note
from radargui.report.sheet import (
    HEIGHT_MM,
    LEFT_MM,
    ROOM_MM,
    TOP_MM,
    new_page,
    printable,
    rule,
    width_mm,
    wrapped,
    write,
)

_SIZE = 8.0
_TITLE_SIZE = 9.5
_LINE_MM = 4.2
_GAP_MM = 5.0
_LAST_MM = HEIGHT_MM - 22.0
_COLUMN_GAP_MM = 4.0
_LEAST_COLUMN_MM = 18.0
_WARNING_COLOUR = "#a02000"


def text_pages(section: Chapter) -> Iterator[Figure]:
    """Yield the pages that a section's blocks fill, without header and footer; none where it has no blocks."""
    if section.blocks:
        flow = _Flow()
        for block in section.blocks:
            flow.put(block)
        yield from flow.pages


class _Flow:
    """Places blocks below each other and begins a new page where one is full."""

    def __init__(self) -> None:
        self.pages: list[Figure] = []
        self.y = 0.0
        self.paragraph_end = 0.0
        self._new_page()

    def put(self, block: Content) -> None:
        """Add one block."""
        if isinstance(block, Note):
            self._note(block)
        else:
            self.y = max(self.y, self.paragraph_end + _GAP_MM)
            self._title(block.title, len(block.rows))
            if isinstance(block, Facts):
                self._facts(block)
            else:
                self._grid(block)
        self.y += _GAP_MM

    def _new_page(self) -> None:
        self.page = new_page()
        self.pages.append(self.page)
        self.y = TOP_MM + 6.0
        self.paragraph_end = 0.0

    def _room(self, height_mm: float) -> bool:
        """Begin a new page where `height_mm` does not fit; True if so."""
        if self.y + height_mm <= _LAST_MM:
            return False
        self._new_page()
        return True

    def _title(self, text: str, rows: int) -> None:
        self._room((min(rows, 4) + 2) * _LINE_MM)
        if text:
            write(self.page, LEFT_MM, self.y, printable(text), fontsize=_TITLE_SIZE, fontweight="bold")
            self.y += _LINE_MM + 1.5

    def _facts(self, block: Facts) -> None:
        names = max((width_mm(name, _SIZE) for name, _ in block.rows), default=0.0)
        values_mm = min(names + 6.0, 0.4 * ROOM_MM)
        for name, value in block.rows:
            for number, line in enumerate(wrapped(printable(value), _SIZE, ROOM_MM - values_mm)):
                self._room(_LINE_MM)
                if number == 0:
                    write(self.page, LEFT_MM, self.y, printable(name), fontsize=_SIZE, color="#505050")
                write(self.page, LEFT_MM + values_mm, self.y, line, fontsize=_SIZE)
                self.y += _LINE_MM

    def _note(self, block: Note) -> None:
        colour = _WARNING_COLOUR if block.warning else "black"
        for line in wrapped(printable(block.text), _SIZE, ROOM_MM - 4.0):
            self._room(_LINE_MM)
            write(self.page, LEFT_MM + (4.0 if block.warning else 0.0), self.y, line, fontsize=_SIZE, color=colour)
            self.y += _LINE_MM
        self.paragraph_end = self.y
        self.y -= _GAP_MM - 2.0

    def _grid(self, block: Grid) -> None:
        cells = [[printable(cell) for cell in row] for row in (block.header, *block.rows)]
        size = _fitting_size(cells)
        widths = _column_widths(cells, size)
        header, *rows = ([wrapped(cell, size, width) for cell, width in zip(row, widths, strict=True)] for row in cells)
        self._grid_header(header, widths, block.left, size)
        for row in rows:
            if self._room(_height(row)):
                self._grid_header(header, widths, block.left, size)
            self._grid_row(row, widths, block.left, size, "normal")
        rule(self.page, self.y - 2.8, _length(widths))

    def _grid_header(self, header: list[list[str]], widths: list[float], left: tuple[int, ...], size: float) -> None:
        self._grid_row(header, widths, left, size, "bold")
        rule(self.page, self.y - 2.8, _length(widths))
        self.y += 1.2

    def _grid_row(
        self, row: list[list[str]], widths: list[float], left: tuple[int, ...], size: float, weight: str
    ) -> None:
        x = LEFT_MM
        for number, (lines, width) in enumerate(zip(row, widths, strict=True)):
            place, side = (x, "left") if number in left else (x + width, "right")
            for below, line in enumerate(lines):
                write(self.page, place, self.y + below * _LINE_MM, line, fontsize=size, ha=side, fontweight=weight)
            x += width + _COLUMN_GAP_MM
        self.y += _height(row)


def _height(row: list[list[str]]) -> float:
    return max(len(lines) for lines in row) * _LINE_MM


def _length(widths: list[float]) -> float:
    return sum(widths) + _COLUMN_GAP_MM * (len(widths) - 1)


def _natural(cells: list[list[str]], size: float) -> list[float]:
    return [
        max(width_mm(cell, size, bold=number == 0) for number, cell in enumerate(column)) + 0.5
        for column in zip(*cells, strict=True)
    ]


def _fitting_size(cells: list[list[str]]) -> float:
    """Return a size at which the table fits the page's width without breaking cells, not below 6.5 points."""
    sizes = (_SIZE, 7.5, 7.0, 6.5)
    return next((size for size in sizes if _length(_natural(cells, size)) <= ROOM_MM), sizes[-1])


def _column_widths(cells: list[list[str]], size: float) -> list[float]:
    """Return widths that fill at most the page; the widest columns give way first."""
    widths = _natural(cells, size)
    most = max(widths)
    while most > _LEAST_COLUMN_MM and _length([min(width, most) for width in widths]) > ROOM_MM:
        most -= 0.1
    return [min(width, most) for width in widths]
