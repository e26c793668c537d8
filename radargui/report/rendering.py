"""A report as PDF, and as one HTML file that needs nothing else: no script, no link, pictures inside."""

import base64
import io
from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from radargui import __version__
from radargui.report.document import Document
from radargui.report.sheet import HEIGHT_MM, LEFT_MM, RIGHT_MM, WIDTH_MM, body, page_style, printable, rule, write
from radargui.report.text_pages import text_pages


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
    environment = Environment(loader=PackageLoader("radargui.report"), autoescape=True, undefined=StrictUndefined)
    metadata = {"Title": document.title, "Author": document.author, "Creator": f"RadarGUI {__version__}"}
    numbers = count(1)
    with (
        page_style(),
        html.open("w", encoding="utf-8", errors="replace", newline="\n") as file,
        PdfPages(pdf, metadata=metadata) as pages,
    ):

        def put(template: str, **values: object) -> None:
            file.write(environment.get_template(template).render(**values))

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
    page.savefig(text, format="svg", bbox_inches=body(page), metadata={"Date": None, "Creator": None})
    return "data:image/svg+xml;base64," + base64.b64encode(text.getvalue()).decode("ascii")


def _put_page(pages: Any, page: Figure, title: str, foot: str, number: int) -> None:
    """Add one page with its header and footer."""
    write(page, LEFT_MM, 15.0, printable(title), fontsize=12.0, fontweight="bold")
    rule(page, 18.0, width=0.8)
    foot_mm = HEIGHT_MM - 9.0
    write(page, LEFT_MM, foot_mm, printable(foot), fontsize=6.5, color="#606060")
    write(page, WIDTH_MM - RIGHT_MM, foot_mm, str(number), fontsize=6.5, color="#606060", ha="right")
    pages.savefig(page)
