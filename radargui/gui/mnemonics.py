"""Letters underlined in menus and dialogs: each entry, button and field has its own, as far as letters last.

They are given here and not written into the words: what is shown together changes with page and source, and two that
were given the same letter are noticed only by who presses it.
"""

from collections.abc import Iterator, Sequence

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QAbstractButton, QLabel, QMenu, QWidget


def without(text: str) -> str:
    """Return words without the sign before their letter."""
    return text.replace("&", "")


def lettered(texts: Sequence[str]) -> list[str]:
    """Return words with `&` before a letter that none of the others has; without where none is left for them.

    Who comes first has the first letter of its words. Of the others each has one that is free, of its other words
    rather than within one; where none is, one whose owner finds another.
    """
    plain = [without(text) for text in texts]
    owner: dict[str, int] = {}

    def give(number: int, tried: set[str]) -> bool:
        # what nobody has goes before what another one would have to change for
        for letter in sorted(_letters(plain[number]), key=owner.__contains__):
            if letter not in tried:
                tried.add(letter)
                if letter not in owner or give(owner[letter], tried):
                    owner[letter] = number
                    return True
        return False

    for number, text in enumerate(plain):
        for first in _letters(text)[:1]:
            owner.setdefault(first, number)
    for number in set(range(len(plain))) - set(owner.values()):
        give(number, set())
    given = {number: letter for letter, number in owner.items()}
    return [_marked(text, given.get(number, "")) for number, text in enumerate(plain)]


def _letters(text: str) -> list[str]:
    """Return the letters and digits of a text, those that begin a word first."""
    places = [place for place, sign in enumerate(text) if sign.isascii() and sign.isalnum()]
    places.sort(key=lambda place: place > 0 and text[place - 1].isalnum())
    return list(dict.fromkeys(text[place].lower() for place in places))


def _marked(text: str, letter: str) -> str:
    """Return a text with the sign before its letter: where that begins a word, else where it comes first."""
    places = [place for place, sign in enumerate(text.lower()) if letter and sign == letter]
    places.sort(key=lambda place: place > 0 and text[place - 1].isalnum())
    return f"{text[: places[0]]}&{text[places[0] :]}" if places else text


def letter_menu(menu: QMenu) -> None:
    """Give the entries of a menu their letters, and those of the menus in it."""
    _set([action for action in menu.actions() if not action.isSeparator()])
    # not by the actions: PySide would take the menu that it is asked for away with them
    for inner in menu.findChildren(QMenu, options=Qt.FindChildOption.FindDirectChildrenOnly):
        letter_menu(inner)


def letter_parts(root: QWidget) -> None:
    """Give what is seen in a window its letters: buttons, and the labels of fields."""
    _set(list(named_parts(root)))


def named_parts(root: QWidget) -> Iterator[QAbstractButton | QLabel]:
    """Yield the buttons with words and the labels that lead to a field, where they can be seen."""
    for part in root.findChildren(QWidget):
        if isinstance(part, QAbstractButton) or (isinstance(part, QLabel) and part.buddy() is not None):
            named: QAbstractButton | QLabel = part
            if _letters(named.text()) and named.isVisibleTo(root):
                yield named


def _set(parts: Sequence[QAction | QAbstractButton | QLabel]) -> None:
    for part, text in zip(parts, lettered([part.text() for part in parts]), strict=True):
        if text != part.text():
            part.setText(text)
