"""How panels, forms and dialogs are laid out: boxes, buttons, wrapped words, titled groups of labelled fields."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypeVar

from PySide6 import QtWidgets
from PySide6.QtCore import QEvent, QObject, QSignalBlocker, QSize, Qt, QTimer, SignalInstance
from PySide6.QtGui import QFont, QPaintEvent, QResizeEvent, QWheelEvent

from radargui.gui.bubble import FaultBubble
from radargui.system.resources import resource_table

Margins = tuple[int, int, int, int]
Part = QtWidgets.QWidget | QtWidgets.QLayout | int | tuple[QtWidgets.QWidget | QtWidgets.QLayout, int]
_FOCUS_ROOM = (3, 3, 3, 3)
"""For the frame around what has the keys: it is drawn within the box."""
ALARM = "color: palette(bright-text); font-weight: bold;"
"""Style of words that say what is wrong."""
FRAMED = "QLineEdit { border: 2px solid palette(bright-text); padding: 1px 0; }"
"""Style of a line whose text is wrong; its padding leaves the line as high as the window's style draws it."""
TIPS: dict[str, dict[str, str]] = resource_table("window/tips")
"""What buttons, fields and columns mean, by their words, where no other place says it."""
Edge = Literal["bright-text", "link-visited", "link"]
"""Of a strip: an alarm, something to look at, something that is being done."""
_Box = TypeVar("_Box", bound=QtWidgets.QBoxLayout)
_Holder = TypeVar("_Holder", QtWidgets.QStackedWidget, QtWidgets.QSplitter)
_Thing = TypeVar("_Thing")


def having(what: _Thing, **properties: Any) -> _Thing:
    """Return a widget with properties as Qt calls them: PySide takes them so where it makes one, its types know few."""
    for name, value in properties.items():
        getattr(what, f"set{name[:1].upper()}{name[1:]}")(value)
    return what


def fill(box: _Box, *parts: Part, margins: Margins = (0, 0, 0, 0), spacing: int = 2) -> _Box:
    """Put parts into a box one after another.

    Parameters
    ----------
    parts
        Widgets and layouts, each alone or with its share of the room that is left; a number alone is empty room.
    margins, spacing
        Around and between them, in pixels.
    """
    box.setContentsMargins(*margins)
    box.setSpacing(spacing)
    for part in parts:
        if isinstance(part, int):
            box.addStretch(part)
            continue
        what, share = part if isinstance(part, tuple) else (part, 0)
        box.addLayout(what, share) if isinstance(what, QtWidgets.QLayout) else box.addWidget(what, share)
    return box


def boxed(box: QtWidgets.QBoxLayout, *parts: Part, **room: Any) -> QtWidgets.QWidget:
    """Return a widget that holds parts as `fill` puts them into a box."""
    return having(QtWidgets.QWidget(), layout=fill(box, *parts, **room))


def holding(what: _Holder, *widgets: QtWidgets.QWidget) -> _Holder:
    """Return a stack or a splitter with widgets in it."""
    for widget in widgets:
        what.addWidget(widget)
    return what


class Pages(QtWidgets.QStackedWidget):
    """Pages of which one is shown; some are made when they are first looked at: the window starts sooner without them.

    Parameters
    ----------
    names
        Of the pages, in their order.
    later
        Makes each of those that come later.
    made
        The others.

    Attributes
    ----------
    made
        Those that there are, by name.
    """

    def __init__(self, names: Iterable[str], later: Mapping[str, Callable[[], QtWidgets.QWidget]], **made: Any) -> None:
        super().__init__()
        self._names, self._later, self.made = tuple(names), later, made
        holding(self, *(made.get(name) or QtWidgets.QWidget() for name in self._names))
        self.currentChanged.connect(self._ask_for_room)
        self._ask_for_room()

    def _ask_for_room(self, _index: int = 0) -> None:
        """Need as much room as the page in front: a low one is not scrolled because another one is high."""
        for place in range(self.count()):
            in_front = place == self.currentIndex()
            needs = QtWidgets.QSizePolicy.Policy.Preferred if in_front else QtWidgets.QSizePolicy.Policy.Ignored
            if (page := self.widget(place)) is not None:
                page.setSizePolicy(needs, needs)
        self.updateGeometry()

    @property
    def shown(self) -> str:
        """Name of the page in front."""
        return self._names[self.currentIndex()]

    def turn_to(self, name: str) -> None:
        """Show a page."""
        self.page(name)
        self.setCurrentIndex(self._names.index(name))

    def page(self, name: str) -> Any:
        """Return a page, which is made where it was not there."""
        if name not in self.made:
            self.made[name] = self._later[name]()
            shown, place = self.currentIndex(), self._names.index(name)
            with QSignalBlocker(self):
                if (empty := self.widget(place)) is not None:
                    self.removeWidget(empty)
                self.insertWidget(place, self.made[name])
                self.setCurrentIndex(shown)
            self._ask_for_room()
        return self.made[name]


def take_out(layout: QtWidgets.QLayout, *widgets: QtWidgets.QWidget) -> None:
    """Take widgets out of a layout for good; they are gone from the screen at once."""
    for widget in widgets:
        layout.removeWidget(widget)
        widget.hide()
        widget.deleteLater()


def button(
    words: str, does: Callable[..., Any] | SignalInstance, tip: str = "", *, default: bool = False
) -> QtWidgets.QPushButton:
    """Return a button; in a dialog Enter presses the one that is the `default`."""
    made = QtWidgets.QPushButton(words, autoDefault=default, default=default)
    made.clicked.connect(does)
    return having(made, toolTip=tip or TIPS["buttons"].get(words, ""))


def menu_button(words: str, menu: QtWidgets.QMenu) -> QtWidgets.QToolButton:
    """Return a button that shows a menu, also by Enter."""
    made = QtWidgets.QToolButton(popupMode=QtWidgets.QToolButton.ToolButtonPopupMode.InstantPopup)
    made.clicked.connect(made.showMenu)
    return having(made, text=words, menu=menu, toolTip=TIPS["buttons"].get(words, ""))


def labelled(words: str, field: QtWidgets.QWidget) -> QtWidgets.QLabel:
    """Return the label of a field, which leads to it; of several beside each other to the first."""
    inside = (one for one in (field, *field.findChildren(QtWidgets.QWidget)) if takes_tab(one))
    return having(QtWidgets.QLabel(words), buddy=next(inside, field))


def takes_tab(widget: QtWidgets.QWidget) -> bool:
    """Return whether Tab stops at a widget, and not at what stands in it for it."""
    return bool(widget.focusPolicy() & Qt.FocusPolicy.TabFocus) and widget.focusProxy() is None


class Group(QtWidgets.QGroupBox):
    """A titled group of labelled fields.

    Parameters
    ----------
    parts
        What it holds at first, see `put`.
    """

    def __init__(self, title: str = "", *parts: tuple[str, QtWidgets.QWidget] | QtWidgets.QWidget) -> None:
        super().__init__(title)
        self.rows = QtWidgets.QFormLayout(self, labelAlignment=Qt.AlignmentFlag.AlignLeft, verticalSpacing=4)
        self.rows.setFieldGrowthPolicy(QtWidgets.QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        self.rows.setContentsMargins(8, 6, 8, 8)
        self.put(*parts)

    def put(self, *parts: tuple[str, QtWidgets.QWidget] | QtWidgets.QWidget) -> None:
        """Add fields, each with the words that name it, and widgets that take the whole width."""
        for part in parts:
            self.row(*part) if isinstance(part, tuple) else self.whole(part)

    def row(self, words: str, field: QtWidgets.QWidget, tip: str = "") -> None:
        """Add a field; `words` names it with its unit."""
        tip = tip or TIPS["fields"].get(words, "")
        # of a line with a button the line is what the keys come to
        (field.focusProxy() or field).setAccessibleName(words)
        self.rows.addRow(having(labelled(words, field), toolTip=tip), having(field, toolTip=tip))

    def whole(self, widget: QtWidgets.QWidget) -> None:
        """Add a widget over the whole width."""
        if isinstance(widget, QtWidgets.QCheckBox) and not widget.toolTip():
            widget.setToolTip(TIPS["fields"].get(widget.text(), ""))
        self.rows.addRow(widget)


class Choice(QtWidgets.QComboBox):
    """A list to choose from that the wheel scrolls past, never changes.

    Parameters
    ----------
    items
        What may be chosen, each value with the words that show it.
    """

    def __init__(self, items: Iterable[tuple[Any, str]] = (), chosen: Any = None) -> None:
        super().__init__()
        self.offer(items, chosen)

    def offer(self, items: Iterable[tuple[Any, str]], chosen: Any = None) -> None:
        """Let other values be chosen, `chosen` at first where it is one of them; nobody is told."""
        with QSignalBlocker(self):
            self.clear()
            for value, words in items:
                self.addItem(words, value)
            self.setCurrentIndex(max(0, self.findData(chosen)))

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        """Leave the wheel to the form."""
        event.ignore()


def follow(changed: SignalInstance, show: Callable[[], None]) -> None:
    """Show what there is now, and again with each change."""
    changed.connect(show)
    show()


def ticking(
    parent: QObject, interval_ms: int, does: Callable[..., Any] | SignalInstance, *, once: bool = False
) -> QTimer:
    """Return a timer that calls each so many milliseconds while it runs, or once each time it is started."""
    made = QTimer(parent, interval=interval_ms, singleShot=once)
    made.timeout.connect(does)
    return made


def side_by_side(*widgets: QtWidgets.QWidget) -> QtWidgets.QWidget:
    """Return a box that holds widgets beside each other."""
    return boxed(QtWidgets.QHBoxLayout(), *widgets, margins=_FOCUS_ROOM, spacing=4)


class PlainLabel(QtWidgets.QLabel):
    """Words that wrap and are never taken for markup."""

    def __init__(self, text: str = "", *, selectable: bool = True) -> None:
        super().__init__(text, textFormat=Qt.TextFormat.PlainText, wordWrap=True)
        self.setSizePolicy(QtWidgets.QSizePolicy.Policy.Preferred, QtWidgets.QSizePolicy.Policy.Minimum)
        if selectable:
            self.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)


class OneLine(QtWidgets.QLabel):
    """Words on one line of the room there is; where they are longer an ellipsis says so, and the tip has them all."""

    def __init__(self, text: str = "") -> None:
        super().__init__(textFormat=Qt.TextFormat.PlainText)
        self.setSizePolicy(QtWidgets.QSizePolicy.Policy.Ignored, QtWidgets.QSizePolicy.Policy.Fixed)
        self.setText(text)

    def setText(self, text: str) -> None:  # noqa: N802 - Qt's name
        """Show other words."""
        super().setText(text)
        self.setToolTip(text.replace("<", "‹"))

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw what there is room for."""
        room = self.contentsRect()
        shown = self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, room.width())
        QtWidgets.QStylePainter(self).drawItemText(
            room, self.alignment(), self.palette(), self.isEnabled(), shown, self.foregroundRole()
        )


class Paragraph(PlainLabel):
    """Words above something that takes the room: as high as they need at the width there is."""

    def __init__(self, text: str = "") -> None:
        super().__init__(text)
        self.setSizePolicy(having(self.sizePolicy(), heightForWidth=True))


class Answer(PlainLabel):
    """Words that take no room while there are none."""

    def __init__(self) -> None:
        super().__init__()
        self.hide()

    def say(self, text: str) -> None:
        """Show words; an empty text: there are none."""
        having(self, text=text, visible=bool(text))


class FaultText(Answer):
    """What is wrong with a field, beneath it; nothing while it is right."""

    def __init__(self) -> None:
        super().__init__()
        self.setStyleSheet(ALARM)


class PathField(QtWidgets.QWidget):
    """A line for a path with a button that lets it be chosen; `fault` says beside it what is wrong.

    Parameters
    ----------
    title
        Of the dialog in which it is chosen.
    start
        Path that stands there at first.
    files
        Filters of the files that may be chosen; a folder is chosen where left out.
    """

    def __init__(self, title: str, start: Path | None = None, files: str = "") -> None:
        super().__init__()
        self._title, self._files = title, files
        self.line, self.fault = QtWidgets.QLineEdit(str(start or "")), FaultBubble()
        self.line.textChanged.connect(lambda _text: self.refuse(""))
        chooses = button("Choose…", self.browse)
        fill(QtWidgets.QHBoxLayout(self), self.line, chooses, margins=_FOCUS_ROOM, spacing=4)
        self.setFocusProxy(self.line)

    @property
    def path(self) -> Path | None:
        """What was typed or chosen."""
        text = self.line.text().strip().strip('"')
        return Path(text).expanduser() if text else None

    def refuse(self, fault: str) -> None:
        """Say what is wrong with the path; an empty text: nothing is."""
        self.fault.say(fault, self.line)
        having(self.line, accessibleDescription=fault, styleSheet=FRAMED if fault else "")

    def browse(self) -> None:
        """Let the operator choose."""
        there = str(self.path or self.line.placeholderText())
        if self._files:
            name, _ = QtWidgets.QFileDialog.getOpenFileName(self, self._title, there, self._files)
        else:
            name = QtWidgets.QFileDialog.getExistingDirectory(self, self._title, there)
        if name:
            self.line.setText(name)


class Turning(QtWidgets.QWidget):
    """Parts one beneath another, or beside each other where there is the width for it.

    Parameters
    ----------
    min_px
        Width from which they stand beside each other.
    parts
        Each with its share of the height, and its share of the width.
    """

    def __init__(self, min_px: int, *parts: tuple[QtWidgets.QWidget, int, int]) -> None:
        super().__init__()
        self._min_px, self._parts = min_px, parts
        self._box = fill(QtWidgets.QBoxLayout(QtWidgets.QBoxLayout.Direction.TopToBottom, self))
        for part, share, _ in parts:
            self._box.addWidget(part, share)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        """Turn where there is another width."""
        across, direction = self.width() >= self._min_px, QtWidgets.QBoxLayout.Direction
        self._box.setDirection(direction.LeftToRight if across else direction.TopToBottom)
        for place, (_, share_down, share_across) in enumerate(self._parts):
            self._box.setStretch(place, share_across if across else share_down)
        super().resizeEvent(event)


class Strip(QtWidgets.QFrame):
    """A line of words with buttons behind, edged in a colour that says what kind it is; hidden until it is needed.

    Parameters
    ----------
    edge
        Its colour, as a role of the palette.
    """

    def __init__(self, edge: Edge, *buttons: QtWidgets.QWidget) -> None:
        super().__init__()
        self.setObjectName("strip")
        line = f"border: none; border-left: 6px solid palette({edge});"
        self.setStyleSheet(f"QFrame#strip {{ background: palette(button); {line} }}")
        self.words = PlainLabel()
        # as high as its words need at the width there is, not at the one that a label would like
        self.words.setSizePolicy(QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Preferred)
        row = fill(QtWidgets.QHBoxLayout(self), (self.words, 1), *buttons, margins=(8, 2, 4, 2), spacing=6)
        for one in buttons:
            # beside the first line: of many lines the last ones may be scrolled away
            row.setAlignment(one, Qt.AlignmentFlag.AlignTop)
        self.hide()


class Scroll(QtWidgets.QScrollArea):
    """Scrolls a widget that is as large as the room, and larger where that is too small; no key stops here.

    Parameters
    ----------
    content
        What is scrolled.
    across
        Whether from side to side as well.
    """

    def __init__(self, content: QtWidgets.QWidget, *, across: bool = False) -> None:
        super().__init__(widgetResizable=True)
        self.content = content
        self.setWidget(content)
        having(self, frameShape=QtWidgets.QFrame.Shape.NoFrame, focusPolicy=Qt.FocusPolicy.NoFocus)
        if not across:
            self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)


class Sections(QtWidgets.QWidget):
    """Titles one beneath another, each above its part; the part of one of them is open.

    Parameters
    ----------
    parts
        What each title holds.

    Attributes
    ----------
    heads
        The buttons with the titles, by title.
    """

    def __init__(self, parts: Mapping[str, QtWidgets.QWidget]) -> None:
        super().__init__()
        self._parts, self.heads = parts, {title: self._head(title) for title in parts}
        column, only_one = fill(QtWidgets.QVBoxLayout(self), spacing=1), QtWidgets.QButtonGroup(self)
        for title, head in self.heads.items():
            only_one.addButton(head)
            head.toggled.connect(partial(self._turn, title))
            column.addWidget(head)
            column.addWidget(parts[title])
            self._turn(title, False)
        next(iter(self.heads.values())).setChecked(True)

    def reveal(self, widget: QtWidgets.QWidget) -> None:
        """Open the part that holds a widget."""
        for title, part in self._parts.items():
            if part.isAncestorOf(widget):
                self.heads[title].setChecked(True)

    def offer(self, title: str, *, wanted: bool) -> None:
        """Show a title that has something to say now, or take it away; it does not take an open part with it."""
        head = self.heads[title]
        if not wanted and head.isChecked():
            next(iter(self.heads.values())).setChecked(True)
        head.setVisible(wanted)

    def _head(self, title: str) -> QtWidgets.QToolButton:
        style = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
        head = having(QtWidgets.QToolButton(autoRaise=True, toolButtonStyle=style), text=title, checkable=True)
        head.setSizePolicy(QtWidgets.QSizePolicy.Policy.Expanding, QtWidgets.QSizePolicy.Policy.Fixed)
        return having(
            head,
            toolTip=TIPS["sections"][title],
            focusPolicy=Qt.FocusPolicy.StrongFocus,
            minimumHeight=head.fontMetrics().height() + 10,
        )

    def _turn(self, title: str, is_open: bool) -> None:
        head = self.heads[title]
        head.setArrowType(Qt.ArrowType.DownArrow if is_open else Qt.ArrowType.RightArrow)
        having(head, font=having(QFont(head.font()), bold=is_open))
        self._parts[title].setVisible(is_open)


class FormScroll(Scroll):
    """Scrolls a column of groups up and down, and is never narrower than it."""

    def __init__(self, *groups: QtWidgets.QWidget) -> None:
        column = boxed(QtWidgets.QVBoxLayout(), *groups, 1, margins=(6, 6, 6, 6), spacing=6)
        super().__init__(having(column, objectName="form"))
        # plots take what room there is, forms only what they need
        self.setSizePolicy(QtWidgets.QSizePolicy.Policy.Preferred, QtWidgets.QSizePolicy.Policy.Expanding)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Ask for more width where the groups need it: Qt asks for none when what is scrolled has grown."""
        if event.type() == QEvent.Type.LayoutRequest:
            self.updateGeometry()
        return super().eventFilter(watched, event)

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return the width of the content beside the scroll bar."""
        width = self.content.minimumSizeHint().width() + self.verticalScrollBar().sizeHint().width()
        return QSize(width, 120)
