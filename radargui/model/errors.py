"""The one tree of errors; each says what happened, the likely reasons, and what to do."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from radargui.model.finding import Finding

_logger = logging.getLogger(__name__)


class RadarGuiError(Exception):
    """An error reported to the operator; the window, the command line and the log show the same text.

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
        """Keep reasons and remedy when the error goes from process to process."""
        return (partial(type(self), self.message, reasons=self.reasons, remedy=self.remedy), ())


class UsageError(RadarGuiError):
    """The command or its arguments are wrong (exit status 2)."""


class SetupError(RadarGuiError):
    """A setup file cannot be used: not TOML, a key unknown, a value out of range (exit status 2)."""


class FileError(RadarGuiError):
    """A file cannot be read or written."""


class FileLostError(FileError):
    """A file that is being written was deleted, replaced or truncated by somebody else; its content is lost."""


class SessionError(RadarGuiError):
    """A session folder cannot be made, opened or added to."""


class SourceError(RadarGuiError):
    """A source of samples failed."""


class DeviceError(SourceError):
    """The NI device, its driver or the way to it failed."""


class ProcessingError(RadarGuiError):
    """The samples cannot be turned into a result.

    Attributes
    ----------
    finding
        Why; None where the message alone says it.
    """

    finding: Finding | None = None


class SolveError(ProcessingError):
    """The equations of an estimate have no solution: their matrix is not positive definite."""


class FaultError(RadarGuiError):
    """The program itself failed: nothing about the samples, the setup or the device explains it."""


_Error = TypeVar("_Error", bound=RadarGuiError)


def in_words(kind: type[_Error], words: Mapping[str, Any], facts: Mapping[str, object]) -> _Error:
    """Return an error in words of a table of the resources, with facts in the places that they leave for them."""
    fact, remedy = (words.get(part, "").format_map(facts) for part in ("fact", "remedy"))
    return kind(fact, reasons=[one.format_map(facts) for one in words.get("reasons", ())], remedy=remedy)


def worded(kind: type[_Error], name: str, /, **facts: object) -> _Error:
    """Return the error of a name in `resources/errors.toml`."""
    # read when something fails: no command waits for it
    from radargui.system.resources import resource_table

    try:
        words = resource_table("errors")[name]
    except OSError:
        # a process that may open no more files cannot read them either: the facts alone
        listed = ", ".join(f"{key} {value}" for key, value in facts.items())
        return kind(f"{name.replace('_', ' ')}: {listed}")
    return in_words(kind, words, facts)


def fault_of(error: BaseException, what: str) -> FaultError:
    """Return an unexpected exception as an error for operator and log, with its type and place.

    Parameters
    ----------
    error
        As caught; becomes the cause.
    what
        What failed, for people: "Reading the source".
    """
    frames = [(frame.filename.replace("\\", "/"), frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    # as code objects name it: where the program is frozen they know no whole path
    package = fault_of.__code__.co_filename.replace("\\", "/").removesuffix("model/errors.py")
    # the last place in this program: what a library says below it helps nobody here
    ours = [(f"radargui/{path.removeprefix(package)}", line) for path, line in frames if path.startswith(package)]
    places = ours or [(path.rpartition("/")[2], line) for path, line in frames]
    place = f" ({places[-1][0]}, line {places[-1][1]})" if places else ""
    if isinstance(error, MemoryError):
        fault = FaultError(f"{what} failed: no memory is left{place}", remedy="Close other programs.")
    else:
        fault = FaultError(
            f"{what} failed unexpectedly: {type(error).__name__}: {error}{place}",
            remedy="This is a fault of the program: please report it with the log.",
        )
    fault.__cause__ = error
    return fault


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


class CancelledError(Exception):
    """The work was cancelled; raised by the function to which it reports its progress.

    It is no error and stands outside the tree, so that it is never shown to the operator as one.
    """
