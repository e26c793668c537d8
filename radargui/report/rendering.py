"""Render a report chapter by chapter, as PDF with bookmarks and as one HTML file that needs nothing else."""

import base64
import hashlib
import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any, Self
from urllib.parse import quote

import matplotlib as mpl
import numpy as np
from matplotlib.backends import backend_pdf
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from radargui import __version__
from radargui.report import sheet
from radargui.report.canvas import Canvas, Line
from radargui.report.document import Chapter, Drawing, templates
from radargui.report.flow import text_pages
from radargui.report.sheet import Paper

backend: Any = backend_pdf
_SAFE = " /:;,=.()-+*!?@$&|{}~^_[]"
"""Signs that need no escape in an address of data between quotes."""
_PIXELS_PER_INCH = 100
"""Chosen by hand: a figure of 178 mm is 700 pixels wide."""
_HEAD_SIZE = 12.0
"""Of the title of a page, in points."""
_SCREEN = sheet.Area(14.0, 6.0, 160.0, 0.0)
"""Where a figure lies in the picture of it that HTML shows."""
_SCREEN_WIDTH_MM, _SCREEN_BELOW_MM = 178.0, 10.0
"""Of that picture: 4 mm right of the figure for half of the last number; below, for numbers and name of the axis."""


class _Numbered(backend.PdfFile):  # type: ignore[misc]  # matplotlib's backends have no types
    """A PDF whose pages are numbered at the end: chapters are put in front of those that are written already.

    Each page has a second stream of content, which is written once its number is known.
    """

    _FONT, _SIZE, _DIGIT = "PageNumber", 6.5, 0.556
    """Helvetica, which every viewer has; width of its digits in sizes."""

    def __init__(self, path: Path, metadata: dict[str, str]) -> None:
        self._numbers: dict[int, Any] = {}
        super().__init__(path, metadata=metadata)

    def writeObject(self, reference: Any, contents: Any) -> None:  # noqa: N802 - matplotlib's name
        """Write an object: a page with room for its number, the fonts with that of the numbers."""
        name = backend.Name
        if isinstance(contents, dict) and contents.get("Type") == name("Page"):
            number = self._numbers[reference.id] = self.reserveObject("page number")
            contents = {**contents, "Contents": [contents["Contents"], number]}
        elif reference is self.fontObject:
            kind = {"Type": name("Font"), "Subtype": name("Type1"), "BaseFont": name("Helvetica")}
            contents = {**contents, name(self._FONT): kind}
        super().writeObject(reference, contents)

    def write_numbers(self, paper: Paper) -> None:
        """Write "3 / 12" at the foot of each page, at the right, once all are there."""
        width_mm, _ = sheet.PAPERS_MM[paper]
        points = 72.0 / sheet.MM_PER_INCH
        for number, page in enumerate(self.pageList, 1):
            text = f"{number} / {len(self.pageList)}"
            # the slash and the blanks are half as wide as digits
            wide = self._SIZE * self._DIGIT * (len(text) - 1.5)
            x, y = (width_mm - sheet.RIGHT_MM) * points - wide, sheet.FOOT_MM * points
            drawn = f"q 0.38 g BT /{self._FONT} {self._SIZE} Tf {x:.2f} {y:.2f} Td ({text}) Tj ET Q"
            self.outputStream(self._numbers[page.id], drawn.encode("ascii"))


class PdfFile:
    """A PDF whose chapters may be put in front of those that are written already.

    Parameters
    ----------
    path
        File to write.
    paper
        Of every page.
    title, author
        Of the document.
    """

    def __init__(self, path: Path, paper: Paper, title: str, author: str) -> None:
        metadata = {"Title": title, "Author": author, "Creator": f"RadarGUI {__version__}"}
        self._pages: Any = backend.PdfPages(path, metadata=metadata)
        # there is no other way to bookmarks and numbers
        self._file = self._pages._file = _Numbered(path, metadata)  # noqa: SLF001
        self._paper, self._title = paper, title
        self._bookmarks: list[tuple[str, Any]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bookmarks:
            self._file.write_numbers(self._paper)
            self._write_outline()
        self._pages.close()

    def put(self, chapter: Chapter) -> None:
        """Add the pages of a chapter."""
        for page in text_pages(chapter, self._paper):
            self._page(page, chapter.title)
        for picture in chapter.pictures:
            self._page(picture.draw(self._paper), f"{chapter.title}: {picture.title}")

    @contextmanager
    def in_front(self) -> Iterator[None]:
        """Put what is written inside before all that was written until now."""
        pages, before = self._file.pageList, len(self._bookmarks)
        yield
        for items in (pages, self._bookmarks):
            items[:] = [*items[before:], *items[:before]]

    def _page(self, page: Figure, title: str) -> None:
        head = _one_line(title, _HEAD_SIZE)
        canvas, ends_mm = Canvas(page), (sheet.LEFT_MM, sheet.LEFT_MM + sheet.ROOM_MM)
        canvas.write(sheet.LEFT_MM, 15.0, head, _HEAD_SIZE, bold=True)
        canvas.line(np.array([(end, 18.0) for end in ends_mm]), Line("#404040", 0.8))
        foot_mm = sheet.size_mm(page)[1] - sheet.FOOT_MM
        canvas.write(sheet.LEFT_MM, foot_mm, _one_line(self._title, 6.5), 6.5, colour="#606060")
        self._pages.savefig(page)
        self._bookmarks.append((title, self._file.pageList[-1]))

    def _write_outline(self) -> None:
        """Write one bookmark a title (PDF 32000-1, 12.3.3), and the catalog once more, with them in it."""
        file, name = self._file, backend.Name
        first_of = dict(reversed(self._bookmarks))
        titles = list(dict.fromkeys(title for title, _ in self._bookmarks))
        outline = file.reserveObject("outline")
        items = [file.reserveObject("bookmark") for _ in titles]
        for number, (title, item) in enumerate(zip(titles, items, strict=True)):
            near = {"Prev": items[number - 1]} if number else {}
            near |= {"Next": items[number + 1]} if number + 1 < len(items) else {}
            shown, target = b"\xfe\xff" + title.encode("utf-16-be", errors="replace"), [first_of[title], name("Fit")]
            file.writeObject(item, {"Title": shown, "Parent": outline, "Dest": target, **near})
        found = {"Type": name("Outlines"), "First": items[0], "Last": items[-1], "Count": len(items)}
        file.writeObject(outline, found)
        catalog = {"Type": name("Catalog"), "Pages": file.pagesObject, "Outlines": outline}
        view = {"PageMode": name("UseOutlines"), "ViewerPreferences": {"DisplayDocTitle": True}}
        file.writeObject(file.rootObject, {**catalog, **view})


def _one_line(text: str, size: float) -> str:
    """Return what of a text fits on one line of a page."""
    first, *more = sheet.wrapped(" ".join(sheet.printable(text).split()), size, 0.85 * sheet.ROOM_MM)
    return f"{first} …" if more else first


def section_html(chapter: Chapter, name: str) -> str:
    """Return a chapter for the HTML file, with its figures in it."""
    blocks = chapter.blocks if chapter.screen is None else chapter.screen
    pictures = [{"title": one.title, "uri": _inline(page := one.draw("a4"), body(page))} for one in chapter.pictures]
    template = templates().get_template("section.html")
    return template.render(name=name, section=chapter, blocks=blocks, pictures=pictures, picture_of=picture_of)


_LABELS_MM = 12.0
"""Below the lowest axes."""


def body(page: Figure) -> Bbox:
    """Return the part of a page from the header down to its lowest words or axes, in inches: what HTML shows."""
    width_mm, height_mm = sheet.size_mm(page)
    words = (word for one in page.get_children() if isinstance(one, Canvas) for word in one.words)
    lowest_mm = [height_mm - y_mm - 2.0 for _, _, y_mm, _ in words]
    lowest_mm += [axes.get_position().y0 * height_mm - _LABELS_MM for axes in page.axes]
    edges_mm = (2.0, max(min(lowest_mm, default=0.0), 0.0), width_mm - 2.0, height_mm - sheet.TOP_MM + 4.0)
    return Bbox.from_extents(*(edge / sheet.MM_PER_INCH for edge in edges_mm))


def write_html(path: Path, title: str, sections: Iterable[tuple[str, str, str]]) -> None:
    """Write the HTML file.

    Parameters
    ----------
    path
        File to write.
    title
        Of the document.
    sections
        Name, title and content of each, see `section_html`.
    """
    script = (resources.files("radargui.report") / "templates" / "sort.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")
    parts, begin = list(sections), templates().get_template("begin.html")
    names = [(name, title) for name, title, _ in parts]
    with path.open("w", encoding="utf-8", errors="replace", newline="\n") as file:
        file.write(begin.render(title=title, names=names, version=__version__, digest=digest))
        file.writelines(content for _, _, content in parts)
        file.write(f"<script>{script}</script>\n</body>\n</html>\n")


def picture_of(block: Drawing) -> str:
    """Return a figure as an address of data, as wide as text."""
    return _inline(drawn_alone(block))


def drawn_alone(block: Drawing) -> Figure:
    """Return a figure on a background of its own."""
    height_mm = block.height_mm or 80.0
    figure = sheet.new_figure(_SCREEN_WIDTH_MM, _SCREEN.top + height_mm + _SCREEN_BELOW_MM)
    block.draw(figure, _SCREEN._replace(height=height_mm))
    return figure


def pixels_of(block: Drawing) -> str:
    """Return a figure as an address of a PNG, for viewers that draw no SVG."""
    content = io.BytesIO()
    drawn_alone(block).savefig(content, format="png", dpi=_PIXELS_PER_INCH)
    return "data:image/png;base64," + base64.b64encode(content.getvalue()).decode("ascii")


def _inline(page: Figure, part: Any = None) -> str:
    """Return a figure as SVG within a data URI; what is white shows the page's own background."""
    text = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none"}):
        page.savefig(text, format="svg", bbox_inches=part, transparent=True, metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml," + quote(text.getvalue(), safe=_SAFE)
