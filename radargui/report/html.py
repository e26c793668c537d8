"""The report as one HTML file that needs nothing else: no script, no link, pictures inside."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TextIO

from jinja2 import Environment, PackageLoader, StrictUndefined
from matplotlib.figure import Figure

from radargui import __version__
from radargui.report.document import Document, Section
from radargui.report.sheet import body


@dataclass(frozen=True, slots=True)
class InlinePicture:
    """A picture as a data URI."""

    title: str
    uri: str


def inline(title: str, page: Figure) -> InlinePicture:
    """Return a page's figures as SVG within a data URI."""
    text = io.BytesIO()
    page.savefig(text, format="svg", bbox_inches=body(page), metadata={"Date": None, "Creator": None})
    return InlinePicture(title, "data:image/svg+xml;base64," + base64.b64encode(text.getvalue()).decode("ascii"))


class HtmlReport:
    """Writes the report section by section, so that the pictures of one run at a time are in memory."""

    def __init__(self, file: TextIO, document: Document) -> None:
        self._file = file
        self._count = 0
        self._environment = Environment(
            loader=PackageLoader("radargui.report"), autoescape=True, undefined=StrictUndefined
        )
        self._write("begin.html", document=document, version=__version__)

    def add(self, section: Section, pictures: Sequence[InlinePicture]) -> None:
        """Add one section."""
        self._count += 1
        self._write("section.html", number=self._count, section=section, pictures=pictures)

    def end(self) -> None:
        """Write the end of the file."""
        self._write("end.html")

    def _write(self, template: str, **values: object) -> None:
        self._file.write(self._environment.get_template(template).render(**values))
