"""What an operator presses in the dialog that compares results."""

from __future__ import annotations

from typing import Any

from radargui.gui.main_window import MainWindow


def keep_new_result(window: MainWindow, wait_for: Any) -> None:
    """Compute in the dialog that is open, keep what is new, close it, and wait until the window shows it."""
    dialog: Any = window.transfer.dialog
    if not dialog.keep.isEnabled():
        dialog.compare.click()
        wait_for(lambda: not dialog.work.busy)
    dialog.keep.click()
    wait_for(lambda: not dialog.work.busy)
    dialog.reject()
    wait_for(lambda: not window.jobs.running)
