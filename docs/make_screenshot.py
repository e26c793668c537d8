"""Makes every picture of the window in the README and the help, from the simulated source.

Run it where a display is (a virtual one will do):

    python docs/make_screenshot.py
    xvfb-run -a -s "-screen 0 1600x1000x24" python docs/make_screenshot.py --theme dark --output somewhere
"""

from __future__ import annotations

import argparse
import faulthandler
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from PySide6.QtCore import QBuffer, QCoreApplication, QEventLoop, QIODevice, QPoint, QRect, Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication, QWidget

from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.notices import NoticeBoard
from radargui.gui.opengl_probe import OpenGLProbe
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.settings import Settings
from radargui.gui.theme import Theme
from radargui.model.setup import changed, dump_setup, read_setup
from radargui.sources.factory import make_source
from radargui.system.resources import default_setup_path

PICTURES = Path(__file__).parent / "images"
MAX_BYTES = 300_000
SIZE = (1440, 900)
LONGEST_S = 600.0
"""For the whole."""
TURN_MS = 50
"""Events are handled so long at most before the time is looked at."""
NEAR_FLOOR_MM = -40.0
MORE_THAN_NOISE_MM = 1.0
"""A sphere that was put back and hangs still is recorded too, until its rest ends the run."""
REST_S = 6.0
HEIGHTS_M = (0.25, 0.17, 0.10)
DROPS = 3


class HeldClock:
    """Time of the simulated source: real time, but none passes while it is held, or while nobody looks at it.

    A machine that does other things slows the source; it never loses samples, and never records one drop more.
    """

    LONGEST_STEP_S = 1.0

    def __init__(self) -> None:
        self.is_held = False
        self._lock = threading.Lock()
        self._looked_s, self._now_s = time.perf_counter(), 1000.0

    def now(self) -> float:
        """Return the time in s."""
        with self._lock:
            real_s = time.perf_counter()
            if not self.is_held:
                self._now_s += min(real_s - self._looked_s, self.LONGEST_STEP_S)
            self._looked_s = real_s
            return self._now_s

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        """Wait, and return whether it was interrupted."""
        return interrupt.wait(min(max(seconds, 0.0), 0.01))


def main() -> int:
    """Record runs, let the sphere fall again, and take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--theme", choices=("light", "dark"), default="light")
    parser.add_argument("--output", type=Path, default=PICTURES)
    chosen = parser.parse_args()

    # where OpenGL in software draws slower than new pictures are asked for, Qt may never come back to be asked the time
    faulthandler.dump_traceback_later(LONGEST_S, exit=True)
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    application = QApplication(sys.argv[:1])
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "data"
        settings = Settings(Path(folder) / "settings.ini")
        settings.put("data_folder", data)
        clock = HeldClock()
        source = partial(make_source, clock=clock)
        window = MainWindow(
            Theme(application, chosen.theme), settings, NoticeBoard(), source_maker=source, probe=OpenGLProbe()
        )
        window.resize(*SIZE)
        window.show()
        window.panels.work_in("measure")
        try:
            for name, image in take(window, clock, data):
                save(image, chosen.output / f"{name}.png")
        finally:
            faulthandler.cancel_dump_traceback_later()
            clock.is_held = False
            window.may_leave = lambda: True  # type: ignore[method-assign]
            window.close()
    return 0


def take(window: MainWindow, clock: HeldClock, data: Path) -> Iterator[tuple[str, QImage]]:
    """Drive the window to the states that the pictures show, and yield each with its name."""
    window.setup_model.assign("simulation.lateral_speed_m_s", 0.02)
    # long enough for the rate in the health line to forget that the clock was held
    window.setup_model.assign("simulation.rest_s", REST_S)
    wait(lambda: window.opengl_answer != "")
    window.actions_.in_space.setChecked(window.actions_.in_space.isEnabled())
    yield "window", falling_once_more(window, clock)
    window.actions_.stop.trigger()
    window.actions_.stop.trigger()
    clock.is_held = False
    wait(lambda: not window.control.state.running)

    window.runs.table.selectRow(0)
    wait(lambda: window.track.result is not None and is_idle(window))
    yield "track", part_of(window, window.panels.docks["run"])
    # wide and high, so that nothing is scrolled or cut
    window.panels.go_to("run")
    for name, view in (("correction", "steps"), ("methods", "methods")):
        window.run.choose(view)
        wait(partial(is_idle, window))
        if view == "methods":
            compare(window, "published", "ellipse")
        yield name, part_of(window, window.panels.docks["run"])

    sessions = [recorded(data / "series", height) for height in HEIGHTS_M]
    window.sessions.open(sessions[0])
    wait(partial(is_idle, window))
    window.show_view("speeds")
    window.series.show_beside(tuple(sessions[1:]))
    wait(lambda: window.series.facts is not None and len(window.series.facts.sessions) == len(sessions))
    for name in ("speeds", "falls"):
        window.show_view(name)
        wait(partial(is_idle, window))
        yield name, part_of(window, window.panels.docks["run"])


def falling_once_more(window: MainWindow, clock: HeldClock) -> QImage:
    """Return the window while the third drop of a session falls, the second of a series; two have their results."""
    window.actions_.record.trigger()
    wait(lambda: window.control.state is AppState.DONE)
    window.bar.runs.setValue(3)
    window.actions_.record.trigger()
    wait(lambda: sum(one.label.isdecimal() for one in window.runs.model.entries) == 2)
    # no third drop before the second has its result, however slow this machine is
    clock.is_held = True
    wait(lambda: all(one.summary and not one.summary["preliminary"] for one in drops(window)))
    clock.is_held = False
    wait(lambda: window.track.result is None and is_falling(window))
    clock.is_held = True
    # what is under way between source and screen arrives
    turn(until=lambda: not window.jobs.running)
    if "drop 3 (2 of 3)" not in window.bar.state.text:
        raise RuntimeError(f"the picture would show {window.bar.state.text!r}")
    return picture_of(window)


def recorded(folder: Path, height_m: float) -> Path:
    """Return a session of simulated drops from a height, recorded as fast as they are computed."""
    setup = read_setup(default_setup_path())
    floor = setup.floor.height_m or 0.0
    setup = changed(
        setup,
        {
            "tracer.release_position_m": [0.0, 0.0, floor + height_m],
            "simulation.restitution": 0.8,
            "processing.correction": "adaptive",
        },
    )
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{1e3 * height_m:.0f}.toml"
    path.write_text(dump_setup(setup), encoding="utf-8")
    known = set(folder.iterdir())
    command = [sys.executable, "-m", "radargui", "record", "--fast", "--setup", str(path), "--output", str(folder)]
    about = ["--runs", str(DROPS), "--sample", "steel sphere", "--target", "glass plate"]
    subprocess.run([*command, *about], check=True, capture_output=True)
    (made,) = set(folder.iterdir()) - known
    return made


def picture_of(window: MainWindow) -> QImage:
    """Return what the screen shows: words in the 3D view are missing from a widget that draws itself."""
    whole = window.screen().grabWindow(window.winId())
    return whole.toImage() if not whole.isNull() else window.grab().toImage()


def part_of(window: MainWindow, panel: QWidget) -> QImage:
    """Return what the screen shows of a panel."""
    turn(until=lambda: True)
    fine = window.devicePixelRatioF()
    corner = panel.mapTo(window, QPoint(0, 0))
    return picture_of(window).copy(QRect(corner * fine, panel.size() * fine))


def compare(window: MainWindow, *methods: str) -> None:
    """Let other corrections compute the run that is shown, and wait for them."""
    page = window.run.tabs.page("methods")
    for method in methods:
        page.boxes[method].setChecked(True)
    page.compute.click()
    wait(lambda: not window.work.busy and len(page.table.rows.entries) == 1 + len(methods))


def drops(window: MainWindow) -> list[RunEntry]:
    """Return the runs that count."""
    return [one for one in window.runs.model.entries if not one.rejected]


def is_idle(window: MainWindow) -> bool:
    """Return whether nothing is being read or computed."""
    return not window.jobs.running and not window.work.busy


def is_falling(window: MainWindow) -> bool:
    """Return whether the sphere falls once more."""
    shown = window.track.shown
    if shown is None or window.control.state is not AppState.RECORDING:
        return False
    z = shown.position_mm[2]
    return bool(z.min() < NEAR_FLOOR_MM and z[-8] - z[-1] > MORE_THAN_NOISE_MM)


def wait(condition: Callable[[], object]) -> None:
    """Let the window live until something is true; who hangs is ended by the guard over the whole."""
    while not condition():
        QCoreApplication.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, TURN_MS)
        time.sleep(0.002)


def turn(until: Callable[[], bool], times: int = 20) -> None:
    """Let the window live for some turns, so that all that waits is drawn, and on until something is true."""
    for _ in range(times):
        QCoreApplication.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, TURN_MS)
        time.sleep(0.01)
    wait(until)


def save(image: QImage, output: Path) -> None:
    """Save a PNG of less than `MAX_BYTES`, with fewer colours where it needs that."""
    flag = Qt.ImageConversionFlag.AvoidDither
    for candidate in (image, image.convertToFormat(QImage.Format.Format_Indexed8, flag)):
        buffer = QBuffer()
        buffer.open(QIODevice.OpenModeFlag.WriteOnly)
        candidate.save(buffer, "PNG", 0)
        data = bytes(buffer.data().data())
        if len(data) < MAX_BYTES:
            break
    else:
        raise ValueError(f"the picture has {len(data)} bytes, more than {MAX_BYTES}")
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_bytes(data)


if __name__ == "__main__":
    sys.exit(main())
