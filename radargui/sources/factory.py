"""Make a source of a kind; this is the only place that does."""

from pathlib import Path
from typing import TypeAlias

from radargui.model.errors import SourceError, worded
from radargui.model.plugins import load_plugin, plugins
from radargui.model.setup import Setup
from radargui.sources.contract import SYSTEM_CLOCK, Clock, ReplaySource, Source
from radargui.sources.restarting import RestartingSource

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
