"""A report as one HTML file that needs nothing else, written chapter by chapter."""

import base64
import hashlib
import io
from collections.abc import Iterable
from functools import lru_cache
from importlib import resources
from pathlib import Path
from urllib.parse import quote

from radargui import __version__
from radargui.report.content import Chapter, Picture, templates
from radargui.report.plots import svg_of

_SAFE = " /:;,=.()-+*!?@$&|{}~^_[]"
"""Signs that need no escape in an address of data between quotes."""
_PIXELS_PER_INCH = 100
"""Chosen by hand: a figure of 178 mm is 700 pixels wide."""


@lru_cache(maxsize=8)
def drawn(plot: Picture) -> str:
    """Return a figure as SVG; PDF and HTML of a chapter draw it once."""
    return svg_of(plot.draw())


def section_html(chapter: Chapter, name: str) -> str:
    """Return a chapter for the HTML file, with its figures in it."""
    blocks = chapter.blocks if chapter.screen is None else chapter.screen
    template = templates().get_template("section.html")
    return template.render(name=name, section=chapter, blocks=blocks, picture_of=picture_of)


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


def picture_of(plot: Picture) -> str:
    """Return a figure as an address of data that holds SVG."""
    return "data:image/svg+xml," + quote(drawn(plot), safe=_SAFE)


def pixels_of(plot: Picture) -> str:
    """Return a figure as an address of a PNG, for viewers that draw no SVG."""
    content = io.BytesIO()
    plot.draw().savefig(content, format="png", dpi=_PIXELS_PER_INCH)
    return "data:image/png;base64," + base64.b64encode(content.getvalue()).decode("ascii")
