"""The report as PDF: text pages and figure pages, each with header and footer."""

from __future__ import annotations

from pathlib import Path
from types import TracebackType
from typing import Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

from radargui import __version__
from radargui.report.document import Document, Section
from radargui.report.sheet import HEIGHT_MM, LEFT_MM, RIGHT_MM, WIDTH_MM, rule, write
from radargui.report.text_pages import text_pages
from radargui.report.text_width import printable


class PdfReport:
    """Writes pages one after another into a PDF file; use as a context manager."""

    def __init__(self, path: Path, document: Document) -> None:
        self._document = document
        metadata = {
            "Title": document.title,
            "Author": document.author,
            "Creator": f"RadarGUI {__version__}",
        }
        self._pages: Any = PdfPages(path, metadata=metadata)
        self._count = 0

    def __enter__(self) -> PdfReport:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pages.close()

    def add_text(self, section: Section) -> None:
        """Add the pages of a section's text."""
        for page in text_pages(section):
            self.add(page, section.title)

    def add(self, page: Figure, title: str) -> None:
        """Add one page with its header and footer."""
        self._count += 1
        write(page, LEFT_MM, 15.0, printable(title), fontsize=12.0, fontweight="bold")
        rule(page, 18.0, width=0.8)
        foot = HEIGHT_MM - 9.0
        write(page, LEFT_MM, foot, printable(self._document.title), fontsize=6.5, color="#606060")
        write(page, WIDTH_MM - RIGHT_MM, foot, str(self._count), fontsize=6.5, color="#606060", ha="right")
        self._pages.savefig(page)
