"""Figures of a run that plug-ins add to its section of the report."""

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING

from radargui.model.plugins import load_plugin, plugins
from radargui.model.result import RunResult
from radargui.report.document import Picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from radargui.report.sheet import Paper

_logger = logging.getLogger(__name__)
AddedFigure = Callable[[RunResult], "Callable[[Paper], Figure] | None"]
"""A plug-in of the group `radargui.figures`.

Given a result it returns what draws its page on a paper (`report.sheet.new_page`), or None where there is nothing to
draw. What draws keeps only what the page needs: a night has many runs.
"""


def added_pictures(result: RunResult) -> tuple[Picture, ...]:
    """Return the figures that plug-ins draw of a result; one that fails is left out and logged."""
    pictures = []
    for name in plugins("figures"):
        try:
            added: AddedFigure = load_plugin("figures", name)
            draw = added(result)
        except Exception:
            # a plug-in must not cost the report
            _logger.exception("The figure %s was left out", name)
            continue
        if draw is not None:
            pictures.append(Picture(name.replace("-", " "), draw))
    return tuple(pictures)
