"""How wide a text is on paper, and how it breaks into lines."""

from functools import lru_cache

from matplotlib.font_manager import FontProperties, findfont, get_font

from radargui.report.sheet import fonts

_MM_PER_POINT = 25.4 / 72.0


@lru_cache(maxsize=2)
def _font_path(bold: bool) -> str:
    return str(findfont(FontProperties(family=fonts()[0], weight="bold" if bold else "normal")))


@lru_cache(maxsize=8192)
def _advance(character: str, bold: bool) -> float:
    """Return the width of one character in sizes of the font; what the font lacks counts as a square."""
    font = get_font(_font_path(bold))
    if ord(character) not in font.get_charmap():
        return 1.0
    font.set_size(100.0, 72.0)
    return float(font.load_char(ord(character)).linearHoriAdvance) / 65536.0 / 100.0


def width_mm(text: str, size: float, *, bold: bool = False) -> float:
    """Return the width of a line of text in a font size in points."""
    return sum(_advance(character, bold) for character in text) * size * _MM_PER_POINT


def wrapped(text: str, size: float, room_mm: float) -> list[str]:
    """Return the lines of a text that fit into a width; words longer than a line are cut."""
    lines: list[str] = []
    for paragraph in text.split("\n"):
        line = ""
        for word in paragraph.split():
            for piece in _pieces(word, size, room_mm):
                longer = f"{line} {piece}".strip()
                if line and width_mm(longer, size) > room_mm:
                    lines.append(line)
                    line = piece
                else:
                    line = longer
        lines.append(line)
    return lines


def _pieces(word: str, size: float, room_mm: float) -> list[str]:
    if width_mm(word, size) <= room_mm:
        return [word]
    pieces = [""]
    for character in word:
        if pieces[-1] and width_mm(pieces[-1] + character, size) > room_mm:
            pieces.append("")
        pieces[-1] += character
    return pieces


@lru_cache(maxsize=1)
def _characters() -> frozenset[int]:
    return frozenset(code for name in fonts() for code in get_font(findfont(FontProperties(family=name))).get_charmap())


def printable(text: str) -> str:
    """Return a text in which what no font here can draw is a question mark, and control characters are gone."""
    known = _characters()
    return "".join(
        character if character == "\n" or ord(character) in known else "?"
        for character in text
        if character == "\n" or character.isprintable()
    )
