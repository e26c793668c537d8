"""A report as PDF: chapters become data and figures in a folder, which the typesetter Typst makes pages of."""

import json
import shutil
from collections.abc import Mapping, Sequence
from datetime import datetime
from importlib import resources
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl

from radargui import __version__
from radargui.model.errors import FileError
from radargui.report.content import Chapter, Content, Plots, with_powers
from radargui.report.html import drawn

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
