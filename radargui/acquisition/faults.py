"""Failures of threads and of steps that must not keep the next step from being done."""

import logging
from collections.abc import Callable

from radargui.model.errors import RadarGuiError, fault_of

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
    except Exception as error:
        _logger.exception("%s failed", what)
        return fault_of(error, what)
    return None
