"""The one tree of errors: what happened, likely why, what to do."""

from __future__ import annotations

from collections.abc import Sequence


class RadarGuiError(Exception):
    """An error told to the operator; the window, the command line and the log show the same text.

    Parameters
    ----------
    message
        What happened, one sentence.
    reasons
        Likely causes, short clauses.
    remedy
        What the operator can do about it, one sentence.
    """

    def __init__(self, message: str, *, reasons: Sequence[str] = (), remedy: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.reasons = tuple(reasons)
        self.remedy = remedy

    def __str__(self) -> str:
        """Return the whole text on one line."""
        ended = self.message.rstrip().endswith((".", ":", "!", "?"))
        parts = [self.message if ended or not (self.reasons or self.remedy) else f"{self.message}."]
        if self.reasons:
            parts.append("Likely: " + "; or ".join(self.reasons) + ".")
        if self.remedy:
            parts.append(self.remedy)
        return " ".join(" ".join(part.split()) for part in parts)

    def __reduce__(self) -> tuple[object, ...]:
        """Keep reasons and remedy when the error crosses a process border."""
        return (_rebuild, (type(self), self.message, self.reasons, self.remedy))


def _rebuild(kind: type[RadarGuiError], message: str, reasons: tuple[str, ...], remedy: str) -> RadarGuiError:
    return kind(message, reasons=reasons, remedy=remedy)


class UsageError(RadarGuiError):
    """The command or its arguments are wrong (exit status 2)."""


class SetupError(RadarGuiError):
    """A setup file cannot be used: not TOML, a key unknown, a value out of range (exit status 2)."""


class FileError(RadarGuiError):
    """A file cannot be read or written."""


class SessionError(RadarGuiError):
    """A session folder cannot be made, opened or added to."""


class SourceError(RadarGuiError):
    """A source of samples failed."""


class DeviceError(SourceError):
    """The NI device, its driver or the way to it failed."""


class ProcessingError(RadarGuiError):
    """The samples cannot be turned into a result."""


class CancelledError(Exception):
    """Somebody wants no more of some work; raised by the function it tells its progress to.

    No fault, hence outside the tree: nothing that shows errors to the operator may take it for one.
    """
