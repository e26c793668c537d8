"""Ask NI-DAQmx about one device, and remember what it answered before.

After a device was unplugged and plugged in again, NI-DAQmx may fail to tell its properties to a process that knew it
before, and tell them to any other (nidaqmx-python issue 818). A property that a device never had fails in the same way.
"""

from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from radargui.model.errors import DeviceError
from radargui.sources.ni.driver import device_error, load_nidaqmx

_ANSWERED: set[tuple[str, str, str]] = set()
"""Place, device and property, of this process: the driver forgets them for the process."""
_LONGEST_S = 20.0
"""A process starts and loads the driver in two or three; chosen by hand for a slow disk."""

_Answer = TypeVar("_Answer")


class Questions:
    """Asks one device for its properties.

    Parameters
    ----------
    place
        Where the driver is: "this computer" or HOST:PORT.
    device
        Name of the device.

    Attributes
    ----------
    lost
        Properties that it told this process once, and does not tell any more.
    """

    def __init__(self, place: str, device: str) -> None:
        self._device = place, device
        self.lost: list[str] = []

    def ask(self, what: str, question: Callable[[], Any], default: Any = None) -> Any:
        """Return the answer of the driver, or the default where this device does not have that property."""
        key = (*self._device, what)
        try:
            answer = question()
        except load_nidaqmx().errors.DaqError:
            if key in _ANSWERED:
                self.lost.append(what)
            return default
        _ANSWERED.add(key)
        return answer

    def forgotten(self, title: str) -> DeviceError | None:
        """Return what is said of a device of that title where anything is lost."""
        if not self.lost:
            return None
        return device_error("forgotten", title=title, place=self._device[0], lost=", ".join(self.lost))


def asked_afresh(question: Callable[[str], _Answer], device: str) -> _Answer | None:
    """Return what a new process is told of a device; None where it is told nothing.

    Parameters
    ----------
    question
        A function of a module, asked with the device's name in the new process.
    device
        Name of the device.
    """
    context = get_context("spawn")
    answers, end = context.Pipe(duplex=False)
    # daemon: a driver that hangs must not keep the program from ending
    process = context.Process(target=_answer, args=(end, question, device), daemon=True)
    try:
        process.start()
        end.close()
        return answers.recv() if answers.poll(_LONGEST_S) else None
    except (EOFError, OSError):
        return None
    finally:
        answers.close()
        if process.pid is not None:
            process.kill()
            process.join()


def _answer(connection: Connection, question: Callable[[str], object], device: str) -> None:
    # who asks is told nothing, and says so
    with suppress(Exception):
        connection.send(question(device))
