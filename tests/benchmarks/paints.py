"""Paints of the window while 6 x 200 kS/s are recorded, alone and beside the joint fit: ticks drawn, longest stall.

python3 packaging/dev.py bench paints [--opengl] [--seconds 20] [--rate-hz 200000] [--simulated]

The samples are those of a simulated scene, computed before and given out block by block as a driver's buffer would:
what a device does, no laboratory's processor pays for. `--simulated` computes them, and their truth, while it records.

Columns: time of the phase, 33 ms ticks drawn, longest and 99 % of the times between two paints, longest refresh and
paint, the drawing thread's own processor time for a tick, share of the time in which it was ready and others had the
processors (0 on an idle computer), longest time between two paints without that. Needs a display of 1920 x 1080 or
more; a virtual one will do: xvfb-run -a -s "-screen 0 1920x1080x24" ...
"""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
import pyqtgraph as pg
from pyqtgraph.util.garbage_collector import GarbageCollector
from PySide6.QtCore import QCoreApplication, QEventLoop, Qt, QTimer
from PySide6.QtWidgets import QApplication
from support.changed import changed

from radargui.gui.control.state import AppState
from radargui.gui.main_window import FRAME_MS, MainWindow
from radargui.gui.notices import NoticeBoard
from radargui.gui.opengl_probe import OpenGLProbe
from radargui.gui.settings import Settings
from radargui.gui.theme import Theme
from radargui.model.recording import Block, Digitisation
from radargui.model.setup import Setup, dump_setup, read_setup
from radargui.sources.contract import SYSTEM_CLOCK, Clock, PacedSource, Source
from radargui.sources.factory import make_source
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.scene import RETURN_S
from radargui.system.resources import default_setup_path

SIZE = (1920, 1080)
MIN_DRAWN = 0.99
LONGEST_STALL_S = 0.1
LONGEST_S = 300.0


def queued_s() -> float:
    """Return how long this thread waited, ready, for a processor that others had; 0 where the system is silent."""
    with contextlib.suppress(OSError):
        return int(Path("/proc/thread-self/schedstat").read_text(encoding="ascii").split()[1]) * 1e-9
    return 0.0


class FromMemory(PacedSource):
    """A scene's samples over and over, each period followed by the next: a device, as far as the program sees it."""

    def __init__(self, setup: Setup, clock: Clock) -> None:
        scene = SimulatedRadar(setup, repeat=True)
        self._digitisation, daq = replace(scene.digitisation, device="memory"), setup.daq
        super().__init__("The memory", clock, daq.rate_hz, daq.read_interval_s, None, realtime=True)
        once = SimulatedRadar(setup).n_samples or 1
        self._samples = scene.samples(0, once + round(RETURN_S * daq.rate_hz))

    def open(self) -> Digitisation:
        self._opened = True
        return self._digitisation

    def _read(self) -> Block | None:
        first, end = self._next, self._end_of_block()
        if not self._wait_for(end):
            return None
        self._next = end
        places = np.arange(first, end) % self._samples.shape[1]
        return Block(self._samples[:, places], first)


def from_memory(kind: Any, setup: Setup, *, clock: Clock = SYSTEM_CLOCK, **_: Any) -> Source:
    """Make the source for the window."""
    del kind
    return FromMemory(setup, clock)


class Watch:
    """Times of the paints of the first scope, which has something new each tick, and what all drawing took."""

    def __init__(self) -> None:
        self._window: MainWindow | None = None
        self.paints: dict[str, list[float]] = {}
        self.queued: dict[str, list[float]] = {}
        self.took: dict[str, list[tuple[float, float, str]]] = {}
        paint = pg.GraphicsView.paintEvent
        watch = self

        def counted(view: Any, event: Any) -> None:
            began, own = time.perf_counter(), time.thread_time()
            paint(view, event)
            window = watch._window
            if window is not None:
                if view is window.scopes.time.scopes[0]:
                    watch.paints.setdefault(watch.phase, []).append(began)
                    watch.queued.setdefault(watch.phase, []).append(queued_s())
                watch.took.setdefault(watch.phase, []).append(
                    (time.perf_counter() - began, time.thread_time() - own, "paint")
                )

        # before any plot is made: Qt looks for the methods of a widget once
        pg.GraphicsView.paintEvent = counted

    def follow(self, window: MainWindow) -> None:
        """Watch a window from now on."""
        self._window, watch = window, self
        refresh = window.refresh

        def timed() -> None:
            began, own = time.perf_counter(), time.thread_time()
            refresh()
            watch.took.setdefault(watch.phase, []).append(
                (time.perf_counter() - began, time.thread_time() - own, "refresh")
            )

        window._timer.timeout.disconnect()
        window._timer.timeout.connect(timed)

    @property
    def phase(self) -> str:
        control = self._window.control if self._window else None
        if control is None or control.state not in (AppState.ARMED, AppState.RECORDING, AppState.SETTLING):
            return ""
        return "beside the joint fit" if len(control.backlog) else "recording alone"

    def show(self, phase: str) -> bool:
        """Print the figures of a phase; return whether they keep the limits."""
        times = np.array(self.paints.get(phase, ()))
        steps = np.diff(times)
        # where the phase was left and entered again no time passed in it
        inside = steps < 5.0
        queued, steps = np.diff(self.queued.get(phase, ()))[inside], steps[inside]
        if steps.size < 3:
            print(f"{phase:22} {'too short':>9}")
            return False
        drawn = min(1.0, steps.size * FRAME_MS / 1e3 / steps.sum())
        longest = {
            what: max((s for s, _, one in self.took[phase] if one == what), default=0.0)
            for what in ("refresh", "paint")
        }
        ticks = sum(one == "refresh" for *_, one in self.took[phase])
        own = sum(s for _, s, _ in self.took[phase]) / ticks
        print(
            f"{phase:22} {steps.sum():8.1f} {drawn:8.1%} {1e3 * steps.max():8.0f} {1e3 * np.quantile(steps, 0.99):8.0f}"
            f" {1e3 * longest['refresh']:8.0f} {1e3 * longest['paint']:8.0f} {1e3 * own:8.1f}"
            f" {queued.sum() / steps.sum():8.0%} {1e3 * (steps - queued).max():8.0f}",
            flush=True,
        )
        return bool(drawn >= MIN_DRAWN and steps.max() < LONGEST_STALL_S)

    def seconds(self, phase: str) -> float:
        steps = np.diff(self.paints.get(phase, [0.0]))
        return float(steps[steps < 5.0].sum())


def wait(condition: Callable[[], bool]) -> None:
    """Let the window live, as the program does, until something is true; looks seldom."""
    end = time.monotonic() + LONGEST_S
    loop, timer = QEventLoop(), QTimer(interval=500)
    timer.timeout.connect(lambda: loop.quit() if condition() or time.monotonic() > end else None)
    timer.start()
    loop.exec()
    timer.stop()
    if not condition():
        raise TimeoutError("waited in vain")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--opengl", action="store_true", help="the track in 3D")
    parser.add_argument("--simulated", action="store_true", help="samples computed while they are recorded")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each phase")
    parser.add_argument("--rate-hz", type=float, default=200_000.0)
    chosen = parser.parse_args()
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    application = QApplication(sys.argv[:1])
    watch = Watch()
    # as the window's own start does
    garbage = GarbageCollector(interval=0.5)
    setup = changed(read_setup(default_setup_path()), daq={"rate_hz": chosen.rate_hz, "channel_skew_s": 0.0})
    setup = changed(setup, processing={"correction": "joint"})
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "setup.toml"
        path.write_text(dump_setup(setup), encoding="utf-8")
        settings = Settings(Path(folder) / "settings.ini")
        settings.put("data_folder", Path(folder) / "data")
        window = MainWindow(
            Theme(application, "light"),
            settings,
            NoticeBoard(),
            setup_path=path,
            source_maker=make_source if chosen.simulated else from_memory,
            probe=OpenGLProbe(),
        )
        window.resize(*SIZE)
        window.show()
        window.panels.resize(*SIZE)
        window.actions_.reset_layout.trigger()
        wait(lambda: window.opengl_answer != "")
        window.actions_.in_space.setChecked(chosen.opengl)
        if window.track.in_space != chosen.opengl:
            print(f"OpenGL: {window.opengl_answer}", file=sys.stderr)
            return 2
        watch.follow(window)
        window.bar.runs.setValue(40)
        began = time.process_time(), time.monotonic()
        window.actions_.record.trigger()
        phases = ("recording alone", "beside the joint fit")
        wait(lambda: all(watch.seconds(one) > chosen.seconds for one in phases[1:]) or not window.control.state.running)
        share = (time.process_time() - began[0]) / (time.monotonic() - began[1])
        load = " ".join(f"{one:.1f}" for one in os.getloadavg()) if hasattr(os, "getloadavg") else "not known"
        health = window.control.health
        lost = health.samples_lost + health.samples_not_written if health else -1
        print(
            f"{application.platformName()}, {'OpenGL' if chosen.opengl else 'no OpenGL'},"
            f" {window.width()} x {window.height()}, samples {'simulated' if chosen.simulated else 'from memory'},"
        )
        print(f"{share:.0%} of a core by the window's process, load {load}, {lost} samples lost of each channel")
        titles = ("s", "drawn", "stall ms", "99 % ms", "refresh", "paint", "own ms", "queued", "without")
        print(f"{'':22} {' '.join(f'{title:>8}' for title in titles)}")
        kept = [watch.show(one) for one in phases]
        good = all(kept)
        for notice in window.board.notices:
            print(f"{notice.level}: {notice.text}")
        print(
            "limits kept"
            if good
            else f"MISSED: at least {MIN_DRAWN:.0%} drawn, no stall of {1e3 * LONGEST_STALL_S:.0f} ms"
        )
        window.may_leave = lambda: True
        window.leave()
        wait(lambda: not window.unfinished() or window.isHidden())
        garbage.timer.stop()
    return int(not good)


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    os._exit(status)
