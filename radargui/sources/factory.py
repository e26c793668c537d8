"""Make a source of a kind; this is the only place that does.

A source that restarts its device after a failure; the samples lost meanwhile are a gap.
"""

import logging
import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

from radargui.model.errors import SourceError, worded
from radargui.model.plugins import load_plugin, plugins
from radargui.model.recording import Block, Digitisation, Gap, Truth
from radargui.model.setup import Setup
from radargui.sources.contract import SYSTEM_CLOCK, Clock, ReplaySource, Source

_DRIFT = 200e-6
"""Relative: the device's clock and this computer's agree better than this."""


class SampleClock:
    """Time of sample 0, t_0 = min over blocks of (arrival - end index / rate).

    No sample can arrive before it is taken, so the block that waited least tells best. What is known ages by the
    largest drift between the two clocks, so that a slow device clock is followed over hours.

    Parameters
    ----------
    rate_hz
        Rate of the samples.
    """

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._zero_s: float | None = None
        self._last_s = 0.0

    def arrived(self, end_index: int, now_s: float) -> None:
        """Take that all samples before `end_index` had arrived at `now_s`."""
        zero_s = now_s - end_index / self._rate_hz
        # the earliest arrival knows t_0 best; old knowledge is worth less as the clocks drift apart
        if self._zero_s is not None:
            zero_s = min(zero_s, self._zero_s + _DRIFT * max(now_s - self._last_s, 0.0))
        self._zero_s, self._last_s = zero_s, now_s

    def index_at(self, now_s: float) -> int:
        """Return the index of the sample taken at `now_s`; 0 where none has arrived yet."""
        return 0 if self._zero_s is None else round((now_s - self._zero_s) * self._rate_hz)


_log = logging.getLogger(__name__)

BETWEEN_TRIES_S = 0.5
"""A device that was plugged in again takes some seconds to appear. Chosen by hand."""


class RestartingSource:
    """Keeps the contract of a source over failures of the one inside.

    A failure of `open`, or of the first `start`, is not repaired: then something is wrong that the operator must see.
    Indices go on over a restart by the clock of this computer: the lost samples are those that the device would have
    taken since its last one that was read, good to some milliseconds.

    Parameters
    ----------
    make
        Makes the source inside; its argument tells whether it is a restart, which must not wait for a start signal.
    within_s
        How long to try again after a failure.
    clock
        Counts the lost time, and paces the tries.
    """

    def __init__(self, make: Callable[[bool], Source], *, within_s: float, clock: Clock = SYSTEM_CLOCK) -> None:
        self._make = make
        self._within_s = within_s
        self._clock = clock
        self._inside: Source = make(False)
        self._stopping = threading.Event()
        self._changing = threading.Lock()
        self._digitisation: Digitisation | None = None
        self._times = SampleClock(1.0)
        self._shift = 0
        self._next = 0
        self._gap: Gap | None = None
        self._error: SourceError | None = None
        self.restarts = 0

    @property
    def is_waiting(self) -> bool:
        """Whether the edge that sampling begins at has not come yet."""
        return self._inside.is_waiting

    def open(self) -> Digitisation:
        """Open the source inside; return how samples will be digitised.

        Raises
        ------
        SourceError
            It cannot be opened.
        """
        self._digitisation = self._inside.open()
        return self._digitisation

    def start(self) -> None:
        """Begin to sample; index 0 is the first sample after this call.

        Raises
        ------
        SourceError
            The source inside refuses, or is not open.
        """
        self._stopping.clear()
        self._shift = self._next = 0
        self._gap = None
        self._error = None
        self._inside.start()
        if self._digitisation is not None:
            self._times = SampleClock(self._digitisation.sample_rate_hz)

    def read(self) -> Block | None:
        """Return the next block, after a failure the first one of the restarted source with the gap; None at the end.

        Raises
        ------
        SourceError
            The source inside failed and could not be started again in time.
        """
        if self._error is not None and not self._stopping.is_set():
            raise self._error
        while not self._stopping.is_set():
            try:
                block = self._inside.read()
                return block and self._continued(block)
            except SourceError as error:
                self._restart(error)
        return None

    def _continued(self, block: Block) -> Block:
        gap, self._gap = self._gap, None
        inner = block.gap and Gap(block.gap.first_index + self._shift, block.gap.count, block.gap.reason)
        if gap is None:
            gap = inner
        elif inner is not None:
            gap = Gap(gap.first_index, gap.count + inner.count, gap.reason)
        # a device that was restarted waited for no edge
        trigger = block.trigger_index if self._shift == 0 else None
        out = Block(block.samples, block.first_index + self._shift, gap, trigger)
        self._next = out.end_index
        self._times.arrived(out.end_index, self._clock.now())
        return out

    def _restart(self, error: SourceError) -> None:
        """Start a new source inside, or raise."""
        began_s = self._clock.now()
        _log.warning("The source failed and is started again: %s", error)
        latest = error
        while not self._stopping.is_set():
            try:
                self._replace()
            except SourceError as again:
                latest = again
                _log.info("It could not be started again yet: %s", again)
            else:
                self._mark_gap(error)
                return
            if self._clock.now() - began_s >= self._within_s:
                self._error = self._given_up(error, latest)
                raise self._error from error
            self._clock.wait(BETWEEN_TRIES_S, self._stopping)

    def _replace(self) -> None:
        self._quietly(self._inside.stop)
        self._quietly(self._inside.close)
        inside = self._make(True)
        try:
            self._check(inside.open())
            with self._changing:
                # nobody may stop the old source between the question and the start of the new one
                if not self._stopping.is_set():
                    inside.start()
                self._inside = inside
        except SourceError:
            self._quietly(inside.close)
            raise

    def _check(self, digitisation: Digitisation) -> None:
        # one file has one rate and one scaling
        if digitisation != self._digitisation:
            raise SourceError(
                "The device came back with another rate, scaling or serial number.", remedy="Start a new run."
            )

    def _mark_gap(self, error: SourceError) -> None:
        self.restarts += 1
        # one at least: without a gap the phase would be unwrapped across the break
        lost = max(1, self._times.index_at(self._clock.now()) - self._next)
        self._gap = Gap(self._next, lost, _reason(error))
        self._shift = self._next + lost
        _log.warning("Started again; about %d samples of each channel are lost", lost)

    def _given_up(self, error: SourceError, latest: SourceError) -> SourceError:
        if latest is error:
            return error
        tried = f"It could not be started again within {self._within_s:g} s: {latest.message}"
        return type(error)(f"{error.message} {tried}", reasons=error.reasons, remedy=error.remedy)

    def _quietly(self, step: Callable[[], None]) -> None:
        """Do a step of ending the source that failed; that it fails again is no news."""
        try:
            step()
        except SourceError as error:
            _log.debug("Ending the source that failed: %s", error)

    def stop(self) -> None:
        """End sampling; idempotent, from any thread."""
        self._stopping.set()
        with self._changing:
            inside = self._inside
        inside.stop()

    def close(self) -> None:
        """Release everything; idempotent."""
        self.stop()
        self._inside.close()

    def backlog(self) -> int:
        """Return how many samples per channel wait in the driver."""
        return self._inside.backlog()

    def truth(self, first_index: int, count: int) -> Truth | None:
        """Return what really happened, for simulations that were not restarted."""
        return self._inside.truth(first_index, count) if self._shift == 0 else None


def _reason(error: SourceError) -> str:
    """Return why samples are missing in a few words: a gap record is short."""
    code = re.search(r"error (-\d+)", error.message)
    if code is not None:
        return f"restarted after error {code[1]}, count by the clock"
    return f"restarted, count by the clock: {error.message}"


SourceKind: TypeAlias = str
BUILT_IN = ("simulated", "ni", "replay")


def source_kinds() -> tuple[SourceKind, ...]:
    """Return what `make_source` makes: what is built in, then the plug-ins of the group `radargui.sources`."""
    return (*BUILT_IN, *plugins("sources"))


def make_source(
    kind: SourceKind,
    setup: Setup,
    *,
    run: int = 0,
    realtime: bool = True,
    repeat: bool = False,
    file: Path | None = None,
    clock: Clock = SYSTEM_CLOCK,
) -> Source:
    """Return a source, not yet open.

    Parameters
    ----------
    kind
        One of `source_kinds`. A plug-in is called as `added(setup, run=run, clock=clock)` and returns a `Source`.
    setup
        What is acquired.
    run
        Number of the run in its session, for the simulated source.
    realtime
        For simulation and replay: keep the sampling rate, otherwise as fast as asked.
    repeat
        For the simulation: begin again for ever.
    file
        What is replayed.
    clock
        Paces simulation and replay, and the restart of a device.

    Raises
    ------
    SetupError
        The simulated scene is impossible.
    SourceError
        The kind is unknown, or replay was asked for without a file or with one of another number of channels.
    FileError
        The file cannot be read.
    """
    match kind:
        case "simulated":
            # brings the integration of motions along, which neither a device nor the start of the window waits for
            from radargui.sources.simulated.model import SimulatedSource

            return SimulatedSource(setup, run=run, realtime=realtime, clock=clock, repeat=repeat)
        case "replay":
            return _replay(setup, file, realtime=realtime, clock=clock)
        case "ni":
            return _device(setup, clock)
    if kind not in plugins("sources"):
        raise SourceError(f"{kind!r} is no source", remedy=f"Choose one of {', '.join(source_kinds())}.")
    made: Source = load_plugin("sources", kind)(setup, run=run, clock=clock)
    return made


def at_once(setup: Setup) -> Setup:
    """Return the setup whose device starts without waiting for an edge: to look only, or again after an error."""
    changes = {"start": "now", "start_source": None, "start_pretrigger": False}
    return setup.model_copy(update={"daq": setup.daq.model_copy(update=changes)})


def _device(setup: Setup, clock: Clock) -> Source:
    # loads NI's client, which a computer without it must not need
    from radargui.sources.ni.source import NiSource

    # a run of fixed length about an edge cannot be continued
    if not setup.recording.restart_after_error or setup.daq.start_pretrigger:
        return NiSource(setup, clock=clock)
    return RestartingSource(
        lambda again: NiSource(at_once(setup) if again else setup, clock=clock),
        within_s=setup.recording.restart_within_s,
        clock=clock,
    )


def _replay(setup: Setup, file: Path | None, *, realtime: bool, clock: Clock) -> ReplaySource:
    from radargui.files.reading import read_recording

    if file is None:
        raise SourceError("No file to replay was named", remedy="Name a recording.")
    recording = read_recording(file)
    if recording.n_receivers != setup.n_receivers:
        counts = {"pairs": recording.n_receivers, "receivers": setup.n_receivers}
        raise worded(SourceError, "pairs_to_replay", name=file.name, **counts)
    return ReplaySource(recording, realtime=realtime, clock=clock, block_s=setup.daq.read_interval_s)
