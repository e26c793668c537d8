"""F1 opens the help: the built pages in the browser, else the texts they are built from."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import QUrl
from PySide6.QtWidgets import QWidget
from pytestqt.qtbot import QtBot

from radargui.gui.main_window import MainWindow
from radargui.gui.panels import HelpBrowser, show_help
from radargui.model import resources


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[QUrl]:
    """What the browser was asked for; it is there and says so."""
    asked: list[QUrl] = []
    monkeypatch.setattr("PySide6.QtGui.QDesktopServices.openUrl", lambda url: asked.append(url) is None)
    return asked


def test_the_built_help_opens_in_the_browser(
    window: MainWindow, opened: list[QUrl], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = tmp_path / "help" / "index.html"
    page.parent.mkdir()
    page.touch()
    monkeypatch.setattr(resources, "resources_folder", lambda: tmp_path)
    assert window.actions_.help.shortcut().toString() == "F1"
    window.actions_.help.trigger()
    assert opened == [QUrl.fromLocalFile(str(page))]


def test_without_a_build_the_texts_are_shown(qtbot: QtBot, opened: list[QUrl], monkeypatch: pytest.MonkeyPatch) -> None:
    text = Path(__file__).parents[2] / "docs" / "tutorial.md"
    monkeypatch.setattr("radargui.gui.panels.help_page", lambda: text)
    parent = QWidget()
    qtbot.addWidget(parent)
    show_help(parent)
    (browser,) = parent.findChildren(HelpBrowser)
    assert not opened
    assert browser.pages.toPlainText().startswith("The first drop")
    browser.pages.setSource(QUrl("uncertainty.md"))
    assert browser.pages.toPlainText().startswith("Uncertainties")
    browser.close()


def test_installed_without_pages_the_texts_beside_the_resources_are_shown(
    window: MainWindow, opened: list[QUrl], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "help").mkdir()
    (tmp_path / "help" / "tutorial.md").write_text("# Installed help\n", encoding="utf-8")
    monkeypatch.setattr(resources, "resources_folder", lambda: tmp_path)
    monkeypatch.setattr(resources, "__file__", str(tmp_path / "site" / "radargui" / "model" / "resources.py"))
    window.actions_.help.trigger()
    (browser,) = window.findChildren(HelpBrowser)
    assert not opened
    assert browser.pages.toPlainText().startswith("Installed help")
    browser.close()


def test_where_no_help_was_installed_it_says_where_it_is(qtbot: QtBot, tmp_path: Path) -> None:
    parent = QWidget()
    qtbot.addWidget(parent)
    browser = HelpBrowser(QUrl.fromLocalFile(str(tmp_path / "tutorial.md")), parent, None)
    assert "docs/tutorial.md" in browser.pages.toPlainText()
