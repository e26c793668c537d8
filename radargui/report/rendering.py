"""A report as PDF, its text flowed onto A4 pages, and as one HTML file that needs nothing else."""

import base64
import io
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from radargui import __version__
from radargui.report import sheet
from radargui.report.document import Chapter, Content, Document, Facts, Grid, Note, templates

_SIZE = 8.0
_TITLE_SIZE = 9.5
_LINE_MM = 4.2
_GAP_MM = 5.0
_LAST_MM = sheet.HEIGHT_MM - 22.0
_COLUMN_GAP_MM = 4.0
_LEAST_COLUMN_MM = 18.0
_WARNING_COLOUR = "#a02000"


def text_pages(section: Chapter) -> list[Figure]:
    """Return the pages that a section's blocks fill, without header and footer; none where it has no blocks."""
    if not section.blocks:
        return []
    flow = _Flow()
    for block in section.blocks:
        flow.put(block)
    return flow.pages


class _Flow:
    """Places blocks below each other and begins a new page where one is full."""

    def __init__(self) -> None:
        self.pages: list[Figure] = []
        self.y = self.paragraph_end = 0.0
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
        self.pages.append(sheet.new_page())
        self.y = sheet.TOP_MM + 6.0
        self.paragraph_end = 0.0

    def _room(self, height_mm: float) -> bool:
        """Begin a new page where `height_mm` does not fit; True if so."""
        full = self.y + height_mm > _LAST_MM
        if full:
            self._new_page()
        return full

    def _write(self, x_mm: float, text: str, below_mm: float = 0.0, **looks: Any) -> None:
        sheet.write(self.pages[-1], x_mm, self.y + below_mm, text, **{"fontsize": _SIZE, **looks})

    def _title(self, text: str, rows: int) -> None:
        self._room((min(rows, 4) + 2) * _LINE_MM)
        if text:
            self._write(sheet.LEFT_MM, sheet.printable(text), fontsize=_TITLE_SIZE, fontweight="bold")
            self.y += _LINE_MM + 1.5

    def _facts(self, block: Facts) -> None:
        names = max((sheet.width_mm(name, _SIZE) for name, _ in block.rows), default=0.0)
        values_mm = min(names + 6.0, 0.4 * sheet.ROOM_MM)
        for name, value in block.rows:
            for number, line in enumerate(sheet.wrapped(sheet.printable(value), _SIZE, sheet.ROOM_MM - values_mm)):
                self._room(_LINE_MM)
                if number == 0:
                    self._write(sheet.LEFT_MM, sheet.printable(name), color="#505050")
                self._write(sheet.LEFT_MM + values_mm, line)
                self.y += _LINE_MM

    def _note(self, block: Note) -> None:
        colour, indent_mm = (_WARNING_COLOUR, 4.0) if block.warning else ("black", 0.0)
        for line in sheet.wrapped(sheet.printable(block.text), _SIZE, sheet.ROOM_MM - 4.0):
            self._room(_LINE_MM)
            self._write(sheet.LEFT_MM + indent_mm, line, color=colour)
            self.y += _LINE_MM
        self.paragraph_end = self.y
        self.y -= _GAP_MM - 2.0

    def _grid(self, block: Grid) -> None:
        cells = [[sheet.printable(cell) for cell in row] for row in (block.header, *block.rows)]
        size = _fitting_size(cells)
        widths = _column_widths(cells, size)
        header, *rows = (
            [sheet.wrapped(cell, size, width) for cell, width in zip(row, widths, strict=True)] for row in cells
        )

        def put(row: list[list[str]], weight: str = "normal") -> None:
            x = sheet.LEFT_MM
            for number, (lines, width) in enumerate(zip(row, widths, strict=True)):
                place, side = (x, "left") if number in block.left else (x + width, "right")
                for below, line in enumerate(lines):
                    self._write(place, line, below * _LINE_MM, fontsize=size, ha=side, fontweight=weight)
                x += width + _COLUMN_GAP_MM
            self.y += _height(row)

        def underline() -> None:
            sheet.rule(self.pages[-1], self.y - 2.8, _length(widths))

        def head() -> None:
            put(header, "bold")
            underline()
            self.y += 1.2

        head()
        for row in rows:
            if self._room(_height(row)):
                head()
            put(row)
        underline()


def _height(row: list[list[str]]) -> float:
    return max(len(lines) for lines in row) * _LINE_MM


def _length(widths: list[float]) -> float:
    return sum(widths) + _COLUMN_GAP_MM * (len(widths) - 1)


def _natural(cells: list[list[str]], size: float) -> list[float]:
    return [
        max(sheet.width_mm(cell, size, bold=number == 0) for number, cell in enumerate(column)) + 0.5
        for column in zip(*cells, strict=True)
    ]


def _fitting_size(cells: list[list[str]]) -> float:
    """Return a size at which the table fits the page's width without breaking cells, not below 6.5 points."""
    sizes = (_SIZE, 7.5, 7.0, 6.5)
    return next((size for size in sizes if _length(_natural(cells, size)) <= sheet.ROOM_MM), sizes[-1])


def _column_widths(cells: list[list[str]], size: float) -> list[float]:
    """Return widths that fill at most the page; the widest columns give way first."""
    widths = _natural(cells, size)
    most = max(widths)
    while most > _LEAST_COLUMN_MM and _length([min(width, most) for width in widths]) > sheet.ROOM_MM:
        most -= 0.1
    return [min(width, most) for width in widths]


def render(document: Document, pdf: Path, html: Path, progress: Callable[[float], None]) -> None:
    """Write both files section by section, so that the pictures of one run at a time are in memory.

    Parameters
    ----------
    document
        What they show.
    pdf, html
        Files to write, in a folder that is there.
    progress
        Called with the share done.

    Raises
    ------
    OSError
        The folder cannot be written or the disk is full.
    """
    metadata = {"Title": document.title, "Author": document.author, "Creator": f"RadarGUI {__version__}"}
    numbers = count(1)
    with (
        sheet.page_style(),
        html.open("w", encoding="utf-8", errors="replace", newline="\n") as file,
        PdfPages(pdf, metadata=metadata) as pages,
    ):

        def put(template: str, **values: object) -> None:
            file.write(templates().get_template(template).render(**values))

        put("begin.html", document=document, version=__version__)
        for number, section in enumerate(document.sections, 1):
            for page in text_pages(section):
                _put_page(pages, page, section.title, document.title, next(numbers))
            pictures = []
            for picture in section.pictures:
                page = picture.draw()
                pictures.append({"title": picture.title, "uri": _inline(page)})
                _put_page(pages, page, f"{section.title}: {picture.title}", document.title, next(numbers))
            put("section.html", number=number, section=section, pictures=pictures)
            progress(number / len(document.sections))
        put("end.html")


def _inline(page: Figure) -> str:
    """Return a page's figures as SVG within a data URI."""
    text = io.BytesIO()
    page.savefig(text, format="svg", bbox_inches=sheet.body(page), metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(text.getvalue()).decode("ascii")


def _put_page(pages: Any, page: Figure, title: str, foot: str, number: int) -> None:
    """Add one page with its header and footer."""
    sheet.write(page, sheet.LEFT_MM, 15.0, sheet.printable(title), fontsize=12.0, fontweight="bold")
    sheet.rule(page, 18.0, width=0.8)
    foot_mm = sheet.HEIGHT_MM - 9.0
    sheet.write(page, sheet.LEFT_MM, foot_mm, sheet.printable(foot), fontsize=6.5, color="#606060")
    sheet.write(page, sheet.WIDTH_MM - sheet.RIGHT_MM, foot_mm, str(number), fontsize=6.5, color="#606060", ha="right")
    pages.savefig(page)
