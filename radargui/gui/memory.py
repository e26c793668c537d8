"""What the window takes from the last time, and keeps for the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from radargui.gui.main_window import MainWindow

FIRST_SIZE = (1440, 900)


def restore(window: MainWindow) -> None:
    """Take size and layout of the last time; what cannot be used is left out."""
    window.resize(*FIRST_SIZE)
    geometry = window.settings.blob("geometry")
    if not geometry.isEmpty():
        window.restoreGeometry(geometry)
    window.panels.resize(window.size())
    window.panels.restore(window.settings.blob("layout"))


def remember(window: MainWindow) -> None:
    """Keep size, layout and what the operator typed."""
    put = window.settings.put
    put("geometry", window.saveGeometry())
    put("layout", window.panels.keep())
    put("operator", window.session_panel.operator)
    put("data_folder", window.session_panel.data_folder)
    put("runs", window.bar.runs.value())
    put("scope_window_s", window.scopes.window_s)
    if window.hardware.replay.path is not None:
        put("replay_file", window.hardware.replay.path)
    window.setup_desk.remember()
    window.settings.sync()
