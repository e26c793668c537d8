"""Menus and dialogs by keys alone: each entry, button and field has a letter of its own, and Tab goes as one reads."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, strategies as st
from PySide6.QtCore import QPoint, Qt, QUrl
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QCheckBox,
    QComboBox,
    QDialog,
    QLabel,
    QLineEdit,
    QMenu,
    QPlainTextEdit,
    QPushButton,
    QWidget,
)
from support.gui_sessions import make_session

from radargui.gui.calibration.dialog import Recorded
from radargui.gui.layout import takes_tab
from radargui.gui.main_window import MainWindow
from radargui.gui.mnemonics import lettered, named_parts, without
from radargui.gui.panels import About, HelpBrowser
from radargui.gui.plots.plot import Plot
from radargui.gui.scopes.scope import GainDialog
from radargui.system.resources import help_page

FIELDS = (QLineEdit, QAbstractSpinBox, QComboBox, QPlainTextEdit)


def letter_of(text: str) -> str:
    found = re.findall(r"&(\w)", text)
    assert len(found) < 2, text
    return found[0].lower() if found else ""


def doubles(texts: list[str]) -> list[str]:
    """Return what shares a letter with another, or has none though one is left for it."""
    letters = Counter(map(letter_of, texts))
    left = [
        text for text in texts if not letter_of(text) and {one for one in text.lower() if one.isalnum()} - set(letters)
    ]
    return left + [text for text in texts if letter_of(text) and letters[letter_of(text)] > 1]


def test_every_entry_of_every_menu_has_a_letter_of_its_own(window: MainWindow) -> None:
    bar = [action.text() for action in window.menuBar().actions()]
    assert all(map(letter_of, bar))
    assert not doubles(bar)
    # those of the bar, of the look, of the views, of what was opened before, and of a plot
    every = [menu for menu in window.menuBar().findChildren(QMenu) if menu.title()]
    every.append(window.findChildren(Plot)[0].menu())
    assert len(every) == len(bar) + 4
    for menu in every:
        texts = [action.text() for action in menu.actions() if not action.isSeparator()]
        assert all(map(letter_of, texts)), texts
        assert not doubles(texts), texts


def test_the_letter_chooses_the_entry(active: MainWindow) -> None:
    view = next(menu for menu in active.menuBar().findChildren(QMenu) if without(menu.title()) == "View")
    entry = next(action for action in view.actions() if without(action.text()) == "Session")
    view.popup(active.mapToGlobal(QPoint(20, 20)))
    QTest.keyClicks(view, letter_of(entry.text()))
    assert active.panels.docks["session"].widget().isVisible()
    assert not view.isVisible()


@given(st.lists(st.text("abcde 12&", min_size=1, max_size=6), max_size=7))
def test_letters_are_given_while_there_are_any(texts: list[str]) -> None:
    given_texts = lettered(texts)
    assert [without(text) for text in given_texts] == [without(text) for text in texts]
    letters = [letter_of(text) for text in given_texts]
    assert len(set(filter(None, letters))) == len([*filter(None, letters)])
    # no other choice gives one to more of them: what is left without finds all its letters taken
    for text, letter in zip(given_texts, letters, strict=True):
        assert letter or {one for one in text if one.isalnum()} <= set(letters)
    assert lettered(given_texts) == given_texts


def calibration(window: MainWindow, page: int) -> QDialog:
    dialog = window.calibration.dialog
    dialog.begin([Path("run-0001.h5")])
    dialog.recordings.show_recordings([Recorded(Path("run-0001.h5"))])
    dialog.unknowns.show_setup(window.setup_model.setup)
    dialog._go(page)
    return dialog


def opened_by(action: str) -> Callable[[MainWindow], QDialog]:
    def open_(window: MainWindow) -> QDialog:
        getattr(window.actions_, action).trigger()
        assert window.transfer.dialog is not None
        return window.transfer.dialog

    return open_


def shown(name: str) -> Callable[[MainWindow], QDialog]:
    def show(window: MainWindow) -> QDialog:
        dialog: Any = window
        for part in name.split("."):
            dialog = getattr(dialog, part)
        dialog.show()
        return dialog

    return show


def made(make: Callable[[MainWindow], QDialog]) -> Callable[[MainWindow], QDialog]:
    def show(window: MainWindow) -> QDialog:
        dialog = make(window)
        dialog.show()
        return dialog

    return show


def gains(window: MainWindow) -> QDialog:
    window.panels.go_to("scopes")
    window.scopes.time.ask_gain()
    (dialog,) = window.scopes.time.findChildren(GainDialog)
    return dialog


DIALOGS: dict[str, Callable[[MainWindow], QDialog]] = {
    "import": opened_by("import_"),
    "export": opened_by("export_samples"),
    "compare": opened_by("compare"),
    **{f"calibration {page + 1}": lambda window, page=page: calibration(window, page) for page in range(4)},
    "log": shown("log"),
    "wiring": shown("wiring"),
    "gain": gains,
    "preview": shown("run_controller.report_preview"),
    "about": made(lambda window: About("", Path(), None, window)),
    "help": made(lambda window: HelpBrowser(QUrl.fromLocalFile(str(help_page())), window, None)),
}


@pytest.mark.parametrize("name", DIALOGS)
def test_a_dialog_is_used_by_keys_alone(window: MainWindow, name: str, wait_for: Any, tmp_path: Path) -> None:
    window.sessions.open(make_session(tmp_path / "data", 4))
    wait_for(lambda: not window.jobs.running)
    dialog = DIALOGS[name](window)
    wait_for(lambda: not window.jobs.running)
    if name == "import":
        file = tmp_path / "samples.bin"
        file.write_bytes(bytes(4000))
        dialog.choose([file])
        wait_for(lambda: not window.jobs.running)
    for _ in range(3):
        QApplication.processEvents()
    assert dialog.isVisible()

    texts = [part.text() for part in named_parts(dialog)]
    assert not doubles(texts), texts
    parts = [one for one in dialog.findChildren(QWidget) if one.isVisibleTo(dialog) and not belongs_to_qt(one)]
    led_to = {one.buddy() for one in parts if isinstance(one, QLabel)}
    buttons = {one for one in parts if isinstance(one, QPushButton | QCheckBox)}
    assert all(letter_of(one.text()) for one in buttons), [one.text() for one in buttons]
    chain = [one for one in chain_of(dialog) if takes_tab(one) and one.isVisibleTo(dialog) and not belongs_to_qt(one)]
    for one in parts:
        if isinstance(one, FIELDS) and not getattr(one, "isReadOnly", bool)():
            assert one in led_to or one.accessibleName(), (one, one.objectName())
        if isinstance(one, (*FIELDS, QAbstractButton)) and one.focusPolicy() is not Qt.FocusPolicy.NoFocus:
            assert one in chain, (one, getattr(one, "text", str)())
    # columns beside each other are read one after the other, each from above
    places = [(one, one.mapTo(dialog, one.rect().center())) for one in chain]
    for (before, here), (after, there) in itertools.pairwise(places):
        backwards = there.y() < here.y() - 12 and there.x() <= here.x()
        first_again = chain.index(after) == 0
        assert first_again or not backwards, (words_on(before), words_on(after), here, there)
    dialog.close()
    wait_for(lambda: not window.jobs.running)


def chain_of(root: QWidget) -> Iterator[QWidget]:
    """Yield what Tab goes through, from the first on."""
    one = root.nextInFocusChain()
    while one is not root:
        yield one
        one = one.nextInFocusChain()


def belongs_to_qt(widget: QWidget) -> bool:
    """Return whether Qt made a part of another widget: the line of a spin box, the cross that clears a line."""
    parent = widget.parentWidget()
    return widget.objectName().startswith("qt_") or isinstance(parent, QLineEdit | QAbstractSpinBox | QComboBox)


def words_on(widget: QWidget) -> str:
    return str(getattr(widget, "text", str)() or widget.accessibleName() or widget)


def test_a_button_that_is_called_otherwise_has_a_letter_again(window: MainWindow) -> None:
    window.actions_.wiring.trigger()
    window.wiring.show_failure("Nothing was measured.")
    for _ in range(3):
        QApplication.processEvents()
    assert without(window.wiring.begin.text()) == "Check again"
    assert letter_of(window.wiring.begin.text())
    window.wiring.reject()
