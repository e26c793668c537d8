"""`process` with a budget of processor time: what is asked, and what it cost."""

from __future__ import annotations

import signal
import time
from types import FrameType

from threadpoolctl import threadpool_limits

from radargui.model.errors import RadarGuiError
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import process


class OutOfTimeError(BaseException):
    """The budget is used up; no handler of errors is to take it for one of its own."""


def with_correction(setup: Setup, correction: str) -> Setup:
    """Return the setup with another correction."""
    processing = setup.processing.model_copy(update={"correction": correction})
    return setup.model_copy(update={"processing": processing})


def timed(recording: Recording, setup: Setup, limit_s: float) -> tuple[RunResult | str, float]:
    """Return the result, or in words why there is none, and the processor time in s; one thread of linear algebra."""
    begin_s = time.process_time()
    result: RunResult | str
    try:
        with threadpool_limits(1):
            _alarm(limit_s)
            result = process(recording, setup)
    except OutOfTimeError:
        result = "out of time"
    except RadarGuiError as error:
        result = f"raised: {error}"
    except Exception as error:  # noqa: BLE001 a crash is a finding here, and the other scenes go on
        result = f"crashed: {type(error).__name__}: {error}"
    finally:
        _alarm(0.0)
    return result, time.process_time() - begin_s


def _alarm(limit_s: float) -> None:
    if not hasattr(signal, "setitimer"):
        return  # Windows has none: there nothing stops a search without end

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise OutOfTimeError

    signal.signal(signal.SIGPROF, stop)
    # again every 0.2 s: a first one may come inside a finaliser, which swallows it
    signal.setitimer(signal.ITIMER_PROF, limit_s, 0.2 if limit_s else 0.0)
