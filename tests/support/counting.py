"""Work for lanes: a module of its own, which a process can import."""

from __future__ import annotations

from collections.abc import Iterator

PARTS = 4
"""Pieces of work from which on other processes are begun."""


def counting(steps: int) -> Iterator[tuple[str, int]]:
    """Yield each step as a sentence and as a number; fewer than no steps are a fault."""
    if steps < 0:
        raise ZeroDivisionError
    for step in range(steps):
        yield f"step {step} of {steps}", step
