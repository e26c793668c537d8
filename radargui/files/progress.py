"""How far a long piece of work is."""

from collections.abc import Callable

Progress = Callable[[float], None]
"""Takes the share done, 0 to 1."""


def silent(share: float) -> None:
    """Take the share done and report it to nobody."""
