"""F1 opens the help: the built pages in the browser, else the texts they are built from."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from PySide6.QtCore import QUrl
from PySide6.QtWidgets import QWidget
from pytestqt.qtbot import QtBot

from radargui.gui.main_window import MainWindow
from radargui.gui.panels import TITLES, HelpBrowser, show_help
from radargui.system.resources import help_page, resource_table


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[QUrl]:
    """What the browser was asked for; it is there and says so."""
    asked: list[QUrl] = []
    monkeypatch.setattr("PySide6.QtGui.QDesktopServices.openUrl", lambda url: asked.append(url) is None)
    return asked


def test_the_built_help_opens_in_the_browser(window: MainWindow, opened: list[QUrl], tmp_path: Path) -> None:
    page = tmp_path / "help" / "index.html"
    page.parent.mkdir()
    page.touch()
    assert help_page(tmp_path / "help") == page
    show_help(window, first=page)
    assert opened == [QUrl.fromLocalFile(str(page))]
    assert window.actions_.help.shortcut().toString() == "F1"


def test_every_panel_has_its_page() -> None:
    pages = resource_table("window/guide")["help"]
    assert set(pages) == set(TITLES)
    docs = Path(__file__).parents[2] / "docs"
    assert all((docs / f"{page}.md").is_file() for page in pages.values())


def test_without_a_build_the_texts_are_shown(qtbot: QtBot, opened: list[QUrl], tmp_path: Path) -> None:
    parent, checkout = QWidget(), tmp_path / "checkout"
    qtbot.addWidget(parent)
    shutil.copytree(Path(__file__).parents[2] / "docs", checkout / "docs")
    text = help_page(tmp_path / "none", checkout)
    assert text == checkout / "docs" / "tutorial.md"
    show_help(parent, first=text)
    (browser,) = parent.findChildren(HelpBrowser)
    assert not opened
    assert browser.pages.toPlainText().startswith("The first drop")
    browser.pages.setSource(QUrl("uncertainty.md"))
    assert browser.pages.toPlainText().startswith("Uncertainties")
    browser.close()


def test_installed_without_pages_the_texts_beside_the_resources_are_shown(
    window: MainWindow, opened: list[QUrl], tmp_path: Path
) -> None:
    (tmp_path / "help").mkdir()
    (tmp_path / "help" / "tutorial.md").write_text("# Installed help\n", encoding="utf-8")
    show_help(window, first=help_page(tmp_path / "help", tmp_path / "site"))
    browser = window.findChildren(HelpBrowser)[-1]
    assert not opened
    assert browser.pages.toPlainText().startswith("Installed help")
    browser.close()


def test_where_no_help_was_installed_it_says_where_it_is(qtbot: QtBot, tmp_path: Path) -> None:
    parent = QWidget()
    qtbot.addWidget(parent)
    browser = HelpBrowser(QUrl.fromLocalFile(str(tmp_path / "tutorial.md")), parent, None)
    assert "docs/tutorial.md" in browser.pages.toPlainText()
