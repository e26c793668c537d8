"""What a bug report needs: versions, OpenGL, folders."""

from __future__ import annotations

import platform
from pathlib import Path

import pyqtgraph
from PySide6 import __version__ as pyside_version
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QPlainTextEdit, QVBoxLayout, QWidget

from radargui import __version__


def facts(opengl: str, data_folder: Path, setup_file: Path | None) -> str:
    """Return the facts as lines of text."""
    return "\n".join(
        (
            f"RadarGUI {__version__}",
            f"Python {platform.python_version()}, PySide6 {pyside_version}, pyqtgraph {pyqtgraph.__version__}",
            f"System: {platform.platform()}",
            f"Track in 3D: {opengl}",
            f"Data folder: {data_folder}",
            f"Setup file: {setup_file or 'none'}",
        )
    )


class About(QDialog):
    """The facts, to be copied."""

    def __init__(self, text: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("About RadarGUI")
        self.resize(560, 220)
        view = QPlainTextEdit(text)
        view.setReadOnly(True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addWidget(view)
        layout.addWidget(buttons)
