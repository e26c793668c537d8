"""The help that F1 opens: the pages in the browser; where they were not built, the texts that they are built from."""

from PySide6.QtCore import QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QHBoxLayout, QTextBrowser, QWidget

from radargui.gui.layout import Dialog, button, fill
from radargui.model.resources import help_page


def show_help(parent: QWidget) -> None:
    """Open the help; without a browser it is shown here."""
    page = help_page()
    url = QUrl.fromLocalFile(str(page))
    if page.suffix == ".html" and QDesktopServices.openUrl(url):
        return
    HelpBrowser(url, parent).show()


class HelpBrowser(Dialog):
    """One page after the other, as their links lead."""

    def __init__(self, url: QUrl, parent: QWidget) -> None:
        super().__init__("Help", (820, 720), parent)
        self.pages = QTextBrowser(openExternalLinks=True)
        self.pages.setSource(url)
        back = button("Back", self.pages.backward)
        self.lay_out(self.pages, fill(QHBoxLayout(), back, 1, button("Close", self.reject, default=True)))
