"""The palette of commands: everything that the menus can do, found by some of its letters."""

from collections.abc import Callable, Iterator

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QApplication, QLineEdit, QMenu, QMenuBar, QWidget

from radargui.gui.dialog import Dialog
from radargui.gui.layout import having
from radargui.gui.mnemonics import without
from radargui.gui.table import WordTable
from radargui.model.rounding import UNKNOWN

_SCROLLS = (Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown)


def rank(typed: str, words: str) -> int | None:
    """Return how far words are from what was typed; None where its letters do not stand in them in that order.

    Each letter counts that was passed over before one that does not begin a word.
    """
    words, at, far = words.lower(), -1, 0
    for letter in typed.lower().replace(" ", ""):
        begins = next((n for n in range(at + 1, len(words)) if words[n] == letter and not words[n - 1].isalnum()), -1)
        following = words.find(letter, at + 1)
        if following < 0:
            return None
        # the next letter goes on with a word, else another word is begun
        found = following if following == at + 1 or begins < 0 else begins
        far += 0 if found in (at + 1, begins) else found - at
        at = found
    return far


def actions_in(menu: QMenu | QMenuBar, way: str = "") -> Iterator[tuple[str, QAction]]:
    """Yield what stands in a menu and in those below it, each with the titles that lead there."""
    inner = {
        one.menuAction(): one for one in menu.findChildren(QMenu, options=Qt.FindChildOption.FindDirectChildrenOnly)
    }
    for action in menu.actions():
        if action in inner:
            title = without(action.text())
            yield from actions_in(inner[action], f"{way} → {title}" if way else title)
        elif not action.isSeparator():
            yield way, action


class Palette(Dialog):
    """One line to type in, and what it means below: Enter or a double click does it.

    Parameters
    ----------
    bar
        Whose actions are offered.
    why_not
        Says of an action that cannot be chosen now why.
    """

    def __init__(self, bar: QMenuBar, why_not: Callable[[QAction], str], parent: QWidget) -> None:
        super().__init__("What shall be done?", (640, 420), parent)
        self._bar, self._why_not = bar, why_not
        self._actions: list[tuple[str, QAction]] = []
        self.line = having(QLineEdit(placeholderText="some letters of it"), accessibleName="What shall be done")
        self.table = WordTable(("What", "Keys", "Where"), "palette")
        having(self.table, focusPolicy=Qt.FocusPolicy.NoFocus, sortingEnabled=False)
        self.line.setToolTip("Some letters of a command, in their order; Enter does the first, the arrow keys choose")
        self.line.textChanged.connect(self._offer)
        self.line.installEventFilter(self)
        self.line.returnPressed.connect(self.do)
        self.table.clicked.connect(self.do)
        self.lay_out(self.line, (self.table, 1))

    def open_anew(self) -> None:
        """Come up with all that there is."""
        self.line.clear()
        self._offer()
        self.line.setFocus()
        self.come_up()

    def _offer(self, typed: str = "") -> None:
        """Show what is meant by what was typed, the nearest first."""
        # a menu may have others each time it is shown
        found = ((rank(typed, without(one.text())), way, one) for way, one in actions_in(self._bar))
        ranked = sorted(((far, way, one) for far, way, one in found if far is not None), key=lambda entry: entry[0])
        self._actions = [(way, one) for _, way, one in ranked]
        self.table.show_rows(
            (
                without(one.text()) + (" ✓" if one.isChecked() else ""),
                one.shortcut().toString(QKeySequence.SequenceFormat.NativeText) or UNKNOWN,
                way if one.isEnabled() else f"not now: {self._why_not(one)}",
            )
            for way, one in self._actions
        )
        if self._actions:
            self.table.selectRow(0)

    def do(self, *_: object) -> None:
        """Do what is chosen, where it can be done now."""
        row = self.table.currentIndex().row()
        if 0 <= row < len(self._actions) and self._actions[row][1].isEnabled():
            self.accept()
            self._actions[row][1].trigger()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Let the keys that go up and down choose in the table while letters are typed."""
        if watched is self.line and isinstance(event, QKeyEvent) and event.key() in _SCROLLS:
            if event.type() == QEvent.Type.KeyPress:
                QApplication.sendEvent(self.table, event)
            return event.type() == QEvent.Type.KeyPress
        return super().eventFilter(watched, event)
