"""Named channels as a file of any format holds them, and how they become one recording."""

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from radargui.model.arrays import FloatArray, RawArray
from radargui.model.errors import FileError, UsageError, worded
from radargui.model.recording import Digitisation, Gap, Recording, are_possible
from radargui.model.words import counted

TIME_NAME = "time_s"
"""A column or variable of this name is the file's own time of each sample."""
MAX_CHANNELS = 64
"""As many as a large board has inputs: more is a slip of the finger or a damaged number. Chosen by hand."""


@dataclass(frozen=True, slots=True)
class ChannelInfo:
    """What a file says of one channel, without its samples.

    Attributes
    ----------
    name
        As the file has it, and as a channel map names it.
    count
        Number of samples.
    sample_rate_hz
        None where the file does not say.
    unit
        Empty where the file does not say.
    """

    name: str
    count: int
    sample_rate_hz: float | None = None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Signal:
    """Samples of one channel.

    Attributes
    ----------
    name
        As the file has it.
    samples
        Shape (n_samples,), int16 codes or float64 values in `unit`.
    scaling
        Coefficients c_k of value = sum c_k code^k; None for values.
    unit
        Unit of the values; empty where unknown.
    """

    name: str
    samples: RawArray = field(repr=False)
    scaling: tuple[float, ...] | None = None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Signals:
    """Channels read from one file, in the order they were asked for.

    Attributes
    ----------
    signals
        The channels.
    sample_rate_hz
        As the file's header says; None where it does not.
    time_s
        The file's own time of each sample, shape (n_samples,); None where it has none.
    gaps
        Lost samples that the file tells of.
    channel_skew_s
        Delay of each channel against the one before; None where the file does not say.
    started_at
        ISO 8601 date and time of the first sample; empty where unknown.
    device
        What digitised, for people.
    trigger_index
        Index of the trigger, lost samples counted, or None.
    of_run
        Whether they are values of a run, as it is or as it was exported: what is no number in them came so from the
        device, and stays so; what processes it leaves it out and tells.
    """

    signals: tuple[Signal, ...]
    sample_rate_hz: float | None = None
    time_s: FloatArray | None = field(default=None, repr=False)
    gaps: tuple[Gap, ...] = ()
    channel_skew_s: float | None = None
    started_at: str = ""
    device: str = ""
    trigger_index: int | None = None
    of_run: bool = False


def scaled_signal(name: str, column: Any, scale: float, offset: float, unit: str) -> Signal:
    """Return values = offset + scale x number of a column of any type; numbers of up to 16 bits stay codes."""
    kind, size = column.dtype.kind, column.dtype.itemsize
    if kind == "f" or size > 2:
        # a damaged or wrongly laid out file may hold signalling NaN: told where samples are looked at
        with np.errstate(over="ignore", invalid="ignore"):
            return Signal(name, np.ascontiguousarray(column, dtype=np.float64) * scale + offset, unit=unit)
    if kind == "u" and size == 2:
        # offset binary: the same 16 bits with the highest one turned over
        codes = (np.ascontiguousarray(column, dtype=np.uint16) ^ np.uint16(0x8000)).view(np.int16)
        return Signal(name, codes, (offset + 32768.0 * scale, scale), unit)
    return Signal(name, np.ascontiguousarray(column, dtype=np.int16), (offset, scale), unit)


LARGEST_DEPARTURE = 0.6
"""In samples: how far a time may lie from where uniform sampling puts it: rounding reaches 0.5, the rate's own error a
little more."""


def uniform(time_s: FloatArray, where: str) -> tuple[float, tuple[Gap, ...]]:
    """Return sample rate in Hz and gaps from times that may be rounded.

    The step is the median difference; a difference near k steps means k - 1 lost samples. The rate then is the number
    of steps over the whole span, so that rounding of the times cancels out, and a rate within rounding of a whole
    number is that number.

    Parameters
    ----------
    time_s
        Shape (n_samples,), at least 2.
    where
        Where the times are, for messages.

    Raises
    ------
    FileError
        Not finite, not increasing, or not uniform.
    """
    if time_s.size < 2:
        raise FileError(f"{where}: one time is not enough for a sample rate.", remedy="Give --rate-hz.")
    finite = np.isfinite(time_s)
    if not finite.all():
        raise FileError(f"{where}: the time of sample {int(np.argmin(finite)) + 1} is not a number.")
    steps = np.diff(time_s)
    if steps.min() <= 0.0:
        late = int(np.argmax(steps <= 0.0)) + 2
        raise worded(FileError, "times_do_not_increase", where=where, sample=late)
    # one at least: rounded times may lie closer together than half a step
    counts = np.maximum(np.rint(steps / np.median(steps)), 1.0)
    index = np.concatenate([[0.0], np.cumsum(counts)])
    rate_hz = float(index[-1]) / float(time_s[-1] - time_s[0])
    departure = np.abs((time_s - time_s[0]) * rate_hz - index)
    if not math.isfinite(rate_hz) or departure.max() > LARGEST_DEPARTURE:
        far = int(np.argmax(departure)) + 1
        raise worded(FileError, "times_not_uniform", where=where, sample=far, departure=departure.max())
    whole = round(rate_hz)
    # each end of the span may be off by as much as any time: so well is the rate known
    if whole >= 1 and abs(whole - rate_hz) <= rate_hz * min(1e-4, 2.0 * departure.max() / index[-1] + 1e-12):
        rate_hz = float(whole)
    return rate_hz, _gaps(counts)


def rate_of_step(step_s: float) -> float | None:
    """Return the sample rate in Hz of a sampling interval, None where it is not one; 2e-5 s is 50 kHz exactly."""
    if not math.isfinite(step_s) or step_s <= 0.0 or not math.isfinite(1.0 / step_s):
        return None
    rate_hz = 1.0 / step_s
    whole = float(round(rate_hz))
    return whole if whole and abs(whole - rate_hz) <= 1e-9 * rate_hz else rate_hz


def _gaps(counts: FloatArray) -> tuple[Gap, ...]:
    places = np.flatnonzero(counts > 1.0)
    lost = counts[places].astype(np.int64) - 1
    # counted with what was lost before
    first = places + 1 + np.cumsum(lost) - lost
    return tuple(Gap(*one, "times jump") for one in zip(first.tolist(), lost.tolist(), strict=True))


SAME_RATE = 1e-3
"""Rates that differ by less are the same one, written with fewer digits."""
_log = logging.getLogger(__name__)


def assemble(
    parts: Sequence[Signals], targets: Sequence[str], *, name: str, where: str, rate_hz: float | None
) -> Recording:
    """Return one recording of the signals of all parts in order.

    Codes stay codes where every signal has int16 codes with a scaling, else all become float64 values.

    Parameters
    ----------
    parts
        What was read, one entry a file.
    targets
        Channel names of the recording, one a signal.
    name
        Name of the recording.
    where
        The file or files, for messages.
    rate_hz
        Rate the operator gave. It goes before what a header says (with a warning in the log), for headers often hold a
        default; times of samples must agree with it.

    Raises
    ------
    FileError
        No rate, rates or lengths that differ, samples that are not numbers in a file of another program.
    UsageError
        The rate given is none.
    """
    signals = [signal for part in parts for signal in part.signals]
    lengths = {int(signal.samples.size) for signal in signals}
    if len(lengths) > 1:
        lengths_text = ", ".join(f"{signal.name}: {signal.samples.size}" for signal in signals)
        raise FileError(f"{where}: channels differ in length ({lengths_text} samples).")
    if lengths == {0}:
        raise FileError(f"{where} holds no samples.")
    time_s, gaps, timed_rate_hz = _times(parts, where)
    if not are_possible(gaps):
        raise FileError(f"{where} tells of lost samples that cannot be.", reasons=("it is damaged",))
    rate = _rate(parts, timed_rate_hz, rate_hz, where)
    raw, scaling = _stack(signals)
    _want_numbers([signal for part in parts if not part.of_run for signal in part.signals], where)
    units = {signal.unit for signal in signals if signal.unit}
    return Recording(
        name=name,
        raw=raw,
        digitisation=Digitisation(
            channel_names=tuple(targets),
            sample_rate_hz=rate,
            scaling=scaling,
            channel_skew_s=_skew_s(parts, where),
            unit=units.pop() if len(units) == 1 else "V" if not units else "mixed",
            device=next((part.device for part in parts if part.device), ""),
        ),
        gaps=gaps,
        file_time_s=time_s,
        trigger_index=next((part.trigger_index for part in parts if part.trigger_index is not None), None),
        started_at=next((part.started_at for part in parts if part.started_at), ""),
    )


def _times(parts: Sequence[Signals], where: str) -> tuple[FloatArray | None, tuple[Gap, ...], float | None]:
    times = [part.time_s for part in parts if part.time_s is not None]
    if not times:
        gaps = {part.gaps for part in parts}
        if len(gaps) > 1:
            raise FileError(f"{where}: the files lost different samples and cannot be joined.")
        return None, gaps.pop(), None
    rate_hz, lost = uniform(times[0], where)
    for other in times[1:]:
        if other is not times[0] and np.abs(other - times[0]).max() * rate_hz > 1.0:
            raise FileError(f"{where}: the files give different times and cannot be joined.")
    return times[0], lost, rate_hz


def _rate(parts: Sequence[Signals], timed_hz: float | None, given_hz: float | None, where: str) -> float:
    if given_hz is not None and not (math.isfinite(given_hz) and given_hz > 0.0):
        raise UsageError(f"--rate-hz {given_hz} is not a sample rate: allowed a number above 0.")
    headers = [part.sample_rate_hz for part in parts if part.sample_rate_hz is not None]
    if any(not _same(rate, headers[0]) for rate in headers[1:]):
        rates_text = ", ".join(f"{rate:g}" for rate in headers)
        raise FileError(f"{where}: the channels have different sample rates: {rates_text} Hz.")
    header_hz = headers[0] if headers else None
    if timed_hz is not None:
        for other, whose in ((given_hz, "--rate-hz says"), (header_hz, "the header says")):
            if other is not None and not _same(other, timed_hz):
                rates = {"timed_hz": timed_hz, "whose": whose, "other_hz": other}
                raise worded(FileError, "rate_against_times", where=where, **rates)
        return timed_hz
    if given_hz is None and header_hz is None:
        raise worded(FileError, "no_rate", where=where)
    if given_hz is not None and header_hz is not None and not _same(given_hz, header_hz):
        _log.warning("%s says %.6g Hz; %.6g Hz is used, as asked with --rate-hz.", where, header_hz, given_hz)
    return float(given_hz or header_hz or math.nan)


def _same(first: float, second: float) -> bool:
    return abs(first - second) <= SAME_RATE * abs(second)


def _skew_s(parts: Sequence[Signals], where: str) -> float | None:
    delays_s = {part.channel_skew_s for part in parts}
    if len(delays_s) > 1:
        _log.warning("%s: the files tell different delays between channels; none of them is used.", where)
        return None
    return delays_s.pop()


def _stack(signals: Sequence[Signal]) -> tuple[RawArray, tuple[tuple[float, ...], ...] | None]:
    scaling = tuple(signal.scaling for signal in signals if signal.scaling is not None)
    if len(scaling) == len(signals):
        return np.stack([np.asarray(signal.samples, dtype=np.int16) for signal in signals]), scaling
    return np.stack([_values(signal) for signal in signals]), None


def _values(signal: Signal) -> FloatArray:
    samples = np.asarray(signal.samples, dtype=np.float64)
    if signal.scaling is None:
        return samples
    return np.asarray(np.polynomial.polynomial.polyval(samples, signal.scaling), dtype=np.float64)


def _want_numbers(signals: Sequence[Signal], where: str) -> None:
    for signal in signals:
        finite = np.isfinite(signal.samples)
        if not finite.all():
            count, first = counted(int((~finite).sum()), "sample"), int(np.argmin(finite)) + 1
            raise worded(FileError, "no_numbers", where=where, name=signal.name, count=count, first=first)
