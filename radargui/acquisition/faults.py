"""Failures of threads and of steps that must not keep the next step from being done."""

from __future__ import annotations

import logging
from collections.abc import Callable

from radargui.model.errors import RadarGuiError

_logger = logging.getLogger(__name__)


def attempt(step: Callable[[], object], what: str) -> RadarGuiError | None:
    """Do a step; return its failure as an error for the operator, None where there is none.

    An unexpected failure is logged with its traceback and named as a fault of the program.

    Parameters
    ----------
    step
        What to do.
    what
        Its name for people: "Reading the source".
    """
    try:
        step()
    except RadarGuiError as error:
        _logger.info("%s: %s", what, error)
        return error
    except MemoryError as error:
        _logger.exception("%s failed", what)
        return _caused(
            RadarGuiError(f"{what} failed: no memory is left", remedy="Close other programs or shorten the run."),
            error,
        )
    except Exception as error:
        _logger.exception("%s failed", what)
        return _caused(
            RadarGuiError(
                f"{what} failed unexpectedly: {type(error).__name__}: {error}",
                remedy="This is a fault of the program: please report it with the log.",
            ),
            error,
        )
    return None


def _caused(error: RadarGuiError, cause: Exception) -> RadarGuiError:
    error.__cause__ = cause
    return error
