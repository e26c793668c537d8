"""The menus: every action and every panel stands in one of them."""

from __future__ import annotations

from PySide6.QtGui import QActionGroup
from PySide6.QtWidgets import QMenuBar

from radargui.gui.actions import Actions
from radargui.gui.panels import Panels
from radargui.gui.theme import CHOICES, Theme


def fill_menus(bar: QMenuBar, does: Actions, panels: Panels, theme: Theme) -> QActionGroup:
    """Fill the bar; return the group that chooses the look, each action's data is its choice."""
    file = bar.addMenu("&File")
    file.addActions([does.open_setup, does.save_setup, does.save_setup_as])
    file.addSeparator()
    file.addActions([does.new_session, does.sessions, does.open_session])
    file.addSeparator()
    file.addActions([does.import_, does.export_samples])
    file.addSeparator()
    file.addActions([does.report, does.export])
    file.addSeparator()
    file.addAction(does.quit)
    run = bar.addMenu("&Run")
    run.addActions([does.start, does.record, does.stop])
    run.addSeparator()
    run.addActions([does.mark, does.pause, does.show_live, does.reprocess, does.compare])
    run.addSeparator()
    run.addActions([does.reject, does.show_rejected, does.sound])
    run.addSeparator()
    run.addAction(does.wiring)
    view = bar.addMenu("&View")
    panels.fill(view)
    view.addSeparator()
    view.addAction(does.in_space)
    looks = view.addMenu("Theme")
    group = QActionGroup(bar)
    for choice in CHOICES:
        action = looks.addAction(choice.capitalize())
        action.setCheckable(True)
        action.setData(choice)
        action.setChecked(choice == theme.choice)
        group.addAction(action)
    view.addSeparator()
    view.addActions([does.reset_layout, does.dismiss])
    bar.addMenu("&Help").addAction(does.about)
    return group
