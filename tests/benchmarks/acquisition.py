"""Live acquisition: 6 x 200 kS/s with the window, 6 x 1 MS/s headless, latency from sample to screen at 33 kS/s.

python3 packaging/dev.py bench acquisition [window] [fast] [latency] [--seconds S]

A process of its own streams a precomputed record (see README.md); its time is told apart. Needs a display, or Xvfb.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("PYQTGRAPH_QT_LIB", "PySide6")

import numpy as np
import psutil
from support.changed import changed
from support.ni_generator import Generator, generator
from support.one_run import record_run

from radargui.acquisition.acquisition import Acquisition
from radargui.experiment.series import Experiment
from radargui.files.run_card import read_health
from radargui.files.run_file import read_run, run_is_complete
from radargui.model.recording import Block
from radargui.model.setup import Setup, read_setup
from radargui.session.session import Session
from radargui.sources.ni.source import NiSource
from radargui.system.resources import default_setup_path

SETTLED_S = 15.0
"""Ring and caches are full by then: from here on memory must be flat."""
LONGEST_LAG_S = 0.1
LARGEST_GROWTH_MB = 20.0
LATENCY_S = 0.1
MIN_FRAMES_PER_S = 25.0


class Metered(NiSource):
    """Notes when each block was there."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup)
        self.came: list[tuple[float, int]] = []

    def read(self) -> Block | None:
        block = super().read()
        if block is not None:
            self.came.append((time.perf_counter(), block.end_index))
        return block

    def lags_s(self, started_at_s: float, rate_hz: float) -> np.ndarray:
        """Return how late each block was after its last sample had been taken."""
        came = np.array(self.came)
        return came[:, 0] - (started_at_s + came[:, 1] / rate_hz)


class Figures:
    """Prints figures, and remembers whether a limit was missed."""

    def __init__(self) -> None:
        self.failed = False

    def tell(self, what: str, value: object, limit: str = "", *, good: bool = True) -> None:
        self.failed |= not good
        print(f"  {what:44} {value!s:>26}  {limit and ('limit ' + limit):24} {'' if good else 'MISSED'}", flush=True)


def fast_setup(rate_hz: float, seconds: float) -> Setup:
    setup = read_setup(default_setup_path())
    return changed(
        setup,
        daq={"rate_hz": rate_hz, "channel_skew_s": 0.0 if rate_hz > 34e3 else 5e-6},
        # one run without end: the pauses of the scene must not end it
        recording={"quiet_s": 60.0, "maximum_s": seconds + 60.0, "wait_s": 60.0, "falls_only": False},
    )


def common(figures: Figures, stream: Generator, source: Metered, acquisition: Acquisition, path: Path) -> None:
    """Tell what all parts share; after the generator has ended."""
    health, report = acquisition.health, stream.report
    rate_hz = stream.setup.daq.rate_hz
    lags = source.lags_s(report["started_at_s"][-1], rate_hz)
    figures.tell("samples of each channel", health.samples_read)
    figures.tell("lost by the source", health.samples_lost, "0", good=health.samples_lost == 0)
    figures.tell("read but not written", health.samples_not_written, "0", good=health.samples_not_written == 0)
    figures.tell("overwritten in the generator", report["overwritten"], "0", good=not report["overwritten"])
    figures.tell(
        "reader behind, ms (median / 99 % / worst)",
        " / ".join(f"{1e3 * value:.1f}" for value in (np.median(lags), np.percentile(lags, 99), lags.max())),
        f"{1e3 * LONGEST_LAG_S:.0f} ms",
        good=bool(lags.max() <= LONGEST_LAG_S),
    )
    figures.tell("generator: longest backlog, ms", f"{1e3 * report['longest_backlog_s']:.1f}")
    figures.tell("generator: share of one core", f"{report['cpu_share']:.2f}")
    stored = read_run(path)
    figures.tell("file complete, without gaps", run_is_complete(path) and not stored.gaps, good=not stored.gaps)
    wrong = differing(stream, stored.raw, int(acquisition.recorder.output.first_index if acquisition.recorder else 0))
    figures.tell("samples in the file that differ", wrong, "0", good=wrong == 0)
    figures.tell("samples in the file", stored.n_samples)
    record = read_health(path) or {}
    for key in ("writer_queue_peak_samples", "live_lag_peak_s", "live_skipped_samples"):
        figures.tell(key, record.get(key))
    skipped = health.live_skipped_samples / max(health.samples_read, 1)
    figures.tell("skipped by the live track", f"{skipped:.2%}", "1 %", good=skipped < 0.01)


def differing(stream: Generator, raw: np.ndarray, first: int) -> int:
    """Return how many recorded samples are not those that the generator streams."""
    from radargui.sources.simulated.model import SimulatedRadar

    period = stream.about["period_samples"]
    codes = SimulatedRadar(stream.setup, repeat=True).samples(0, period)
    wrong, place = 0, 0
    while place < raw.shape[1]:
        start = (first + place) % period
        count = min(period - start, raw.shape[1] - place)
        wrong += int((raw[:, place : place + count] != codes[:, start : start + count]).any(axis=0).sum())
        place += count
    return wrong


class Watch(threading.Thread):
    """Memory and processor time of this process, once a second."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self._process = psutil.Process()
        self._stop_ = threading.Event()
        self.memory: list[tuple[float, int]] = []
        self._began = time.perf_counter()
        self._cpu = sum(self._process.cpu_times()[:2])
        self.start()

    def run(self) -> None:
        while not self._stop_.wait(1.0):
            self.memory.append((time.perf_counter() - self._began, self._process.memory_info().rss))

    def tell(self, figures: Figures) -> None:
        self._stop_.set()
        self.join()
        passed = time.perf_counter() - self._began
        share = (sum(self._process.cpu_times()[:2]) - self._cpu) / passed
        figures.tell("RadarGUI: share of one core", f"{share:.2f}")
        late = [memory for when, memory in self.memory if when > SETTLED_S]
        if len(late) < 10:
            figures.tell("memory", "too short to tell")
            return
        third = len(late) // 3
        growth = (np.median(late[-third:]) - np.median(late[:third])) / 1e6
        good = bool(growth < LARGEST_GROWTH_MB)
        figures.tell(f"memory after {SETTLED_S:.0f} s, MB", f"{late[-1] / 1e6:.0f}")
        figures.tell("its growth since, MB", f"{growth:.1f}", f"{LARGEST_GROWTH_MB:.0f} MB", good=good)


def headless(figures: Figures, folder: Path, seconds: float) -> None:
    """Record 6 x 1 MS/s with a live track, without the window."""
    print(f"6 x 1 MS/s headless, recording and live track, {seconds:.0f} s")
    setup = changed(fast_setup(1e6, seconds), daq={"read_interval_s": 0.02, "buffer_s": 5.0})
    with generator(setup) as stream:
        source = Metered(stream.setup)
        session = Session.create(folder, stream.setup, now=datetime.now(UTC))
        experiment = Experiment(stream.setup, lambda _: source, session, seconds=seconds, process=False)
        watch = Watch()
        run = record_run(experiment)
        watch.tell(figures)
    acquisition = experiment.acquisition
    if acquisition is None or run.path is None:
        raise SystemExit("nothing was recorded")
    common(figures, stream, source, acquisition, run.path)


def window(figures: Figures, folder: Path, seconds: float) -> None:
    """Record 6 x 200 kS/s while the window draws."""
    print(f"6 x 200 kS/s with recording, live correction, live track and the window, {seconds:.0f} s")
    draw(figures, folder, fast_setup(200e3, seconds), seconds, with_latency=False)


def latency(figures: Figures, folder: Path, seconds: float) -> None:
    """Measure from sample to screen at the laboratory's rate."""
    seconds = min(seconds, 20.0)
    print(f"6 x 33.3 kS/s: from sample to screen, {seconds:.0f} s")
    draw(figures, folder, fast_setup(20e6 / 600, seconds), seconds, with_latency=True)


def draw(figures: Figures, folder: Path, setup: Setup, seconds: float, *, with_latency: bool) -> None:
    from pyqtgraph.util.garbage_collector import GarbageCollector
    from PySide6.QtCore import QCoreApplication, QEvent, QTimer
    from PySide6.QtWidgets import QApplication

    from radargui.gui.control.state import Asked
    from radargui.gui.main_window import MainWindow
    from radargui.gui.notices import NoticeBoard
    from radargui.gui.settings import Settings
    from radargui.gui.theme import Theme
    from radargui.model.setup import write_setup

    application = QApplication.instance() or QApplication([])
    keeper = GarbageCollector(interval=0.5)
    write_setup(setup, folder / "bench.toml")
    with generator(setup) as stream:
        source = Metered(stream.setup)
        settings = Settings(folder / "settings.ini")
        settings.put("data_folder", folder / "data")
        shown = MainWindow(
            Theme(application, "light"),
            settings,
            NoticeBoard(),
            setup_path=folder / "bench.toml",
            source_maker=lambda *_, **__: source,
            find_devices=lambda _: (),
        )
        shown.may_leave = lambda: True
        shown.resize(1600, 1000)
        shown.show()
        frames: list[tuple[float, int]] = []
        spent: list[float] = []
        state: dict[str, Any] = {}
        refresh = shown.refresh

        def drawn(index: int) -> None:
            frames.append((time.perf_counter(), index))

        def timed() -> None:
            began = time.perf_counter()
            refresh()
            spent.append(time.perf_counter() - began)
            acquisition = shown.control.reached.acquisition
            if acquisition is not None and acquisition.live is not None:
                state["acquisition"] = acquisition
                index = acquisition.live.latest
                # the widgets are painted before a timer of no time is served
                QTimer.singleShot(0, lambda: drawn(index))

        shown._timer.timeout.disconnect()
        shown._timer.timeout.connect(timed)
        watch = Watch()
        shown.record()
        QTimer.singleShot(round(1e3 * seconds), application.quit)
        application.exec()
        watch.tell(figures)
        shown.control.end(Asked.CANCEL)
        QTimer.singleShot(60_000, application.quit)
        shown.control.state_changed.connect(lambda: None if shown.control.state.running else application.quit())
        application.exec()
        stopped = not shown.control.state.running
        shown.close()
        shown.deleteLater()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        keeper.timer.stop()
    if not stopped or "acquisition" not in state:
        raise SystemExit("the window did not record")
    acquisition = state["acquisition"]
    common(figures, stream, source, acquisition, acquisition.recorder.path)
    times = np.array([when for when, _ in frames])
    rate = (times.size - 1) / (times[-1] - times[0])
    figures.tell("frames per second", f"{rate:.1f}", f"{MIN_FRAMES_PER_S:.0f}", good=rate >= MIN_FRAMES_PER_S)
    gaps = 1e3 * np.diff(times)
    figures.tell("between frames, ms (median / 99 %)", f"{np.median(gaps):.0f} / {np.percentile(gaps, 99):.0f}")
    figures.tell("drawing, ms a frame (median)", f"{1e3 * np.median(spent):.1f}")
    late = latencies_s(frames, stream.report["started_at_s"][-1], stream.setup.daq.rate_hz)
    value = float(np.percentile(late, 95))
    good = value <= LATENCY_S or not with_latency
    figures.tell("sample to screen, ms (median)", f"{1e3 * np.median(late):.0f}")
    figures.tell("sample to screen, ms (95 %)", f"{1e3 * value:.0f}", "100 ms" if with_latency else "", good=good)


def latencies_s(frames: list[tuple[float, int]], started_at_s: float, rate_hz: float) -> np.ndarray:
    """Return for samples at even distances how long after it was taken each was on the screen."""
    when, index = np.array([one[0] for one in frames]), np.array([one[1] for one in frames])
    step = max(1, round(1e-3 * rate_hz))
    samples = np.arange(index[index > 0][0], index[-1], step)
    frame = np.searchsorted(np.maximum.accumulate(index), samples, side="right")
    return when[frame] - (started_at_s + samples / rate_hz)


PARTS = {"window": (window, 60.0), "fast": (headless, 30.0), "latency": (latency, 20.0)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="all where left out")
    parser.add_argument("--seconds", type=float, help="length of each part")
    options = parser.parse_args()
    parts = options.parts or list(PARTS)
    if sys.platform == "linux" and not os.environ.get("DISPLAY") and {"window", "latency"} & set(parts):
        xvfb = shutil.which("xvfb-run")
        if xvfb is None:
            raise SystemExit("The window needs a display or Xvfb: install xvfb, or run only the part fast.")
        screen = ["-a", "-s", "-screen 0 1920x1200x24"]
        return subprocess.run([xvfb, *screen, sys.executable, *sys.argv], check=False).returncode
    figures = Figures()
    for name in parts:
        part, seconds = PARTS[name]
        with tempfile.TemporaryDirectory() as folder:
            part(figures, Path(folder), options.seconds or seconds)
    print("a limit was missed" if figures.failed else "all limits kept")
    return int(figures.failed)


if __name__ == "__main__":
    sys.exit(main())
