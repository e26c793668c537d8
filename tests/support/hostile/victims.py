"""Sound files of every kind that is read, and how each is read."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import sigmf
from support.file_samples import (
    codes,
    default_setup,
    read_all_channels,
    result_of,
    volts,
    write_csv,
    write_mat5,
    write_mat73,
    write_run,
    write_sigmf,
    write_tdms,
)
from support.found_sessions import find_sessions
from support.run_contents import read_markers, read_run_truth, read_summary

from radargui.experiment.importing import MapMemory
from radargui.files import mat_file
from radargui.files.formats import EXPORT_FORMATS, export_run, list_channels, own_setup_of
from radargui.files.reading import guess_channel_map, read_recording
from radargui.files.run_file import read_run, read_run_setup, run_stream
from radargui.files.run_results import results_are_current, write_results
from radargui.files.stored_results import read_whole_result
from radargui.model.errors import RadarGuiError
from radargui.model.setup import read_setup, write_setup
from radargui.session.session import Session
from radargui.session.transfer import plan_export
from radargui.system.resources import default_setup_path


@dataclass(frozen=True)
class Victim:
    """One kind of file.

    Attributes
    ----------
    make
        Writes a sound one into a folder and returns the file that gets damaged.
    read
        Does with it whatever the program does with such a file.
    is_text
        Whether texts and numbers in it are exchanged, too.
    """

    make: Callable[[Path], Path]
    read: Callable[[Path], None]
    is_text: bool = False


def _recording(path: Path) -> None:
    with _each() as attempt:
        attempt(lambda: guess_channel_map(list_channels(path)))
        attempt(lambda: own_setup_of(path))
        attempt(lambda: _sane(path))


def _sane(path: Path) -> None:
    recording = read_all_channels(path) if len(list_channels(path)) < 3 else read_recording(path)
    if recording.raw.shape != (recording.digitisation.n_channels, recording.n_samples) or not recording.n_samples:
        raise AssertionError(f"shape {recording.raw.shape}")
    if not np.isfinite(recording.volts()).all() or not recording.digitisation.sample_rate_hz > 0.0:
        raise AssertionError("values that are no numbers")
    if recording.time_s().shape != (recording.n_samples,):
        raise AssertionError("times")


def _run(path: Path) -> None:
    with _each() as attempt:
        for read in (read_run, read_run_setup, read_run_truth, read_markers, read_summary):
            attempt(lambda read=read: read(path))
        attempt(lambda: results_are_current(path, default_setup()))
        attempt(lambda: read_whole_result(path, default_setup(), lambda _: read_run(path)))
        attempt(lambda: _stream(path))
        attempt(lambda: find_sessions(path.parent.parent))


def _stream(path: Path) -> None:
    with run_stream(path) as run:
        for _ in run.pieces():
            pass


def _session(path: Path) -> None:
    with _each() as attempt:
        attempt(lambda: Session.open(path.parent))
        attempt(lambda: find_sessions(path.parent.parent))
        attempt(lambda: plan_export(path.parent, EXPORT_FORMATS["csv"]))


@contextlib.contextmanager
def _each() -> Iterator[Callable[[Callable[[], object]], None]]:
    """Let every attempt be made; the first refusal is raised in the end."""
    refusals: list[RadarGuiError] = []

    def attempt(act: Callable[[], object]) -> None:
        try:
            act()
        except RadarGuiError as error:
            refusals.append(error)

    yield attempt
    if refusals:
        raise refusals[0]


def _make_run(folder: Path) -> Path:
    path = folder / "run-0001.h5"
    write_run(path, 600)
    write_results(path, result_of(read_run(path)))
    return path


def _make_exported(name: str) -> Callable[[Path], Path]:
    def make(folder: Path) -> Path:
        write_run(folder / "run-0001.h5", 300)
        return export_run(folder / "run-0001.h5", EXPORT_FORMATS[name], folder)[0]

    return make


def _make_exported_mat73(folder: Path) -> Path:
    kept, mat_file.LARGEST_V5_BYTES = mat_file.LARGEST_V5_BYTES, 0
    try:
        return _make_exported("mat")(folder)
    finally:
        mat_file.LARGEST_V5_BYTES = kept


def _make_tdms(folder: Path) -> Path:
    scaled = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear", "wf_increment": 1e-3}
    scaled |= {"NI_Scale[0]_Linear_Slope": 0.5, "NI_Scale[0]_Linear_Y_Intercept": 1.0}
    return write_tdms(folder / "a.tdms", codes(2, 60), ["I1", "Q1"], scaled)


def _make_sigmf(folder: Path) -> Path:
    captures = [{"core:sample_start": 0, "core:global_index": 0}, {"core:sample_start": 9, "core:global_index": 12}]
    return write_sigmf(folder / "a", codes(4, 50).T.astype("<i2"), "ci16_le", 2, captures=captures)


def _make_sigmf_archive(folder: Path) -> Path:
    sigmf.fromfile(str(_make_sigmf(folder)), autoscale=False).archive(str(folder / "b.sigmf"))
    return folder / "b.sigmf"


def _make_session(folder: Path) -> Path:
    session = Session.create(folder, default_setup(), operator="Eve", notes="a note", name="s", now=datetime.now(UTC))
    write_run(session.path / "run-0001.h5", 40)
    return session.path / "session.json"


def _make_memory(folder: Path) -> Path:
    path = folder / "maps.json"
    path.write_text('{"schema": 1, "maps": {"[\\"a\\", \\"b\\"]": [1, 0]}}', encoding="utf-8")
    return path


def _remember(path: Path) -> None:
    from radargui.files.signals import ChannelInfo

    MapMemory(path).guess([ChannelInfo("a", 5), ChannelInfo("b", 5)])


def _make_setup(folder: Path) -> Path:
    return Path(shutil.copy(default_setup_path(), folder / "setup.toml"))


def _setup(path: Path) -> None:
    setup = read_setup(path)
    write_setup(setup, path.with_name("again.toml"))
    if read_setup(path.with_name("again.toml")) != setup:
        raise AssertionError("a setup is not read as it was written")


VICTIMS: dict[str, Victim] = {
    "run": Victim(_make_run, _run),
    "run as a recording": Victim(_make_run, _recording),
    "csv": Victim(lambda folder: write_csv(folder / "a.csv", volts(2, 30)), _recording, is_text=True),
    "mat v5": Victim(lambda folder: write_mat5(folder / "a.mat", volts(2, 40), compressed=False), _recording),
    "mat v5 compressed": Victim(lambda folder: write_mat5(folder / "a.mat", volts(2, 40)), _recording),
    "mat 7.3": Victim(lambda folder: write_mat73(folder / "a.mat", volts(2, 400)), _recording),
    "tdms": Victim(_make_tdms, _recording),
    "sigmf metadata": Victim(_make_sigmf, _recording, is_text=True),
    "sigmf samples": Victim(lambda folder: _make_sigmf(folder).with_suffix(".sigmf-data"), _recording),
    "sigmf archive": Victim(_make_sigmf_archive, _recording),
    "exported csv": Victim(_make_exported("csv"), _recording, is_text=True),
    "exported mat": Victim(_make_exported("mat"), _recording),
    "exported mat 7.3": Victim(_make_exported_mat73, _recording),
    "exported tdms": Victim(_make_exported("tdms"), _recording),
    "exported sigmf": Victim(_make_exported("sigmf"), _recording, is_text=True),
    "setup file": Victim(_make_setup, _setup, is_text=True),
    "session record": Victim(_make_session, _session, is_text=True),
    "channel maps": Victim(_make_memory, _remember, is_text=True),
}
