"""A report as PDF: chapters become data and figures in a folder, which the typesetter Typst makes pages of.

A report as one HTML file that needs nothing else, written chapter by chapter.
"""

import base64
import hashlib
import io
import json
import shutil
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

import matplotlib as mpl

from radargui import __version__
from radargui.model.errors import FileError
from radargui.report.content import Chapter, Content, Picture, Plots, templates, with_powers
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


Paper = Literal["a4", "letter"]
_NAMES: dict[Paper, str] = {"a4": "a4", "letter": "us-letter"}
"""What Typst calls them."""
_FONTS = ("DejaVuSans.ttf", "DejaVuSans-Bold.ttf")
"""Of matplotlib, in which the words of figures are set: Typst's own fonts have no such letters."""


class Typesetter:
    """Chapters of a PDF as they come: each is data at once, its figures are files.

    Parameters
    ----------
    folder
        An empty one, which may be deleted once the PDF is written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._chapters: list[dict[str, Any]] = []
        self._n_figures = 0

    def put(self, chapter: Chapter) -> None:
        """Add a chapter."""
        blocks = [self._block(one) for one in chapter.blocks]
        pictures = [{"title": printable(one.title), "file": self._figure(drawn(one))} for one in chapter.pictures]
        words = {"title": printable(chapter.title), "small": chapter.small, "follows": chapter.follows}
        self._chapters.append({**words, "blocks": blocks, "pictures": pictures})

    def put_in_front(self, chapters: Sequence[Chapter]) -> None:
        """Put chapters before all that are there."""
        behind, self._chapters = self._chapters, []
        for one in chapters:
            self.put(one)
        self._chapters += behind

    def write(self, path: Path, paper: Paper, title: str, author: str, made_at: str) -> None:
        """Write the PDF.

        Raises
        ------
        FileError
            The typesetter cannot be loaded or cannot do it.
        """
        about = {
            "title": " ".join(printable(title).split()),
            "author": printable(author),
            "made_with": f"RadarGUI {__version__}",
        }
        data = {**about, "paper": _NAMES[paper], "chapters": self._chapters}
        (self._folder / "data.json").write_text(json.dumps(data), encoding="utf-8")
        template = (resources.files("radargui.report") / "templates" / "report.typ").read_bytes()
        (self._folder / "report.typ").write_bytes(template)
        # a folder of their own: beside them lies one that has a box for every letter that the others lack
        fonts = self._folder / "fonts"
        fonts.mkdir(exist_ok=True)
        for name in _FONTS:
            shutil.copyfile(Path(mpl.get_data_path(), "fonts", "ttf", name), fonts / name)
        try:
            # it is large, and loaded only where a PDF is made
            import typst

            main = str(self._folder / "report.typ")
            typst.compile(main, str(path), str(self._folder), [str(fonts)], format="pdf", timestamp=_seconds(made_at))
        except (ImportError, RuntimeError) as error:
            reason = " ".join(str(error).split()) or type(error).__name__
            raise FileError(f"The pages of the report could not be typeset: {reason}") from error

    def _block(self, block: Content) -> dict[str, Any]:
        if isinstance(block, Plots):
            shown = [{"title": printable(one.title), "file": self._figure(drawn(one))} for one in block.plots]
            return {"kind": block.kind, "plots": shown, "fitted": block.fitted}
        return {name: _data(getattr(block, name)) for name in block.__slots__}

    def _figure(self, svg: str) -> str:
        self._n_figures += 1
        name = f"{self._n_figures}.svg"
        (self._folder / name).write_text(svg, encoding="utf-8")
        return name


def _seconds(made_at: str) -> int:
    """Return date and time of a report in seconds since 1970: of the same content the same file is made."""
    return round(datetime.fromisoformat(made_at).timestamp())


def printable(text: str) -> str:
    """Return a text without the control characters in it; line ends stay, other white space is a blank."""
    signs = ("\n" if one == "\n" else " " if one.isspace() else one for one in text)
    return "".join(one for one in signs if one == "\n" or one.isprintable())


def _data(value: object) -> object:
    if isinstance(value, str):
        return printable(with_powers(value))
    if isinstance(value, Mapping):
        return {name: _data(one) for name, one in value.items()}
    return [_data(one) for one in value] if isinstance(value, tuple) else value
