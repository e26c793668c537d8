"""Work done here and now: for a panel without a window around it."""

from collections.abc import Callable
from typing import Any


def at_once(_what: str, work: Callable[[], Any], then: Callable[[Any], None], *_otherwise: object) -> None:
    """Run `work` and what follows, as `Jobs.start` does it in the background."""
    then(work())
