"""Makes the README's picture: the window while a simulated sphere falls.

Run it where a display is (a virtual one will do):

    python docs/make_screenshot.py
    xvfb-run -a -s "-screen 0 1600x1000x24" python docs/make_screenshot.py --theme dark
"""

from __future__ import annotations

import argparse
import faulthandler
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QBuffer, QCoreApplication, QEventLoop, QIODevice, Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication

from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.notices import NoticeBoard
from radargui.gui.opengl_probe import OpenGLProbe
from radargui.gui.settings import Settings
from radargui.gui.theme import Theme

PICTURE = Path(__file__).parent / "images" / "window.png"
MOST_BYTES = 300_000
SIZE = (1440, 900)
LONGEST_S = 300.0
"""For each thing that is waited for, and for the whole."""
TURN_MS = 50
"""Events are handled so long at most before the time is looked at."""
NEAR_FLOOR_MM = -60.0


def main() -> int:
    """Record runs, let the sphere fall again, and take the picture while it does."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--theme", choices=("light", "dark"), default="light")
    parser.add_argument("--output", type=Path, default=PICTURE)
    chosen = parser.parse_args()

    # where OpenGL in software draws slower than new pictures are asked for, Qt may never come back to be asked the time
    faulthandler.dump_traceback_later(LONGEST_S, exit=True)
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    application = QApplication(sys.argv[:1])
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(Path(folder) / "settings.ini")
        settings.put("data_folder", Path(folder) / "data")
        probe = OpenGLProbe()
        window = MainWindow(Theme(application, chosen.theme), settings, NoticeBoard(), probe=probe)
        window.resize(*SIZE)
        window.show()
        try:
            take(window, application, chosen.output)
        finally:
            faulthandler.cancel_dump_traceback_later()
            window.may_leave = lambda: True  # type: ignore[method-assign]
            window.close()
    return 0


def take(window: MainWindow, application: QApplication, output: Path) -> None:
    """Drive the window to the moment that the picture shows."""
    window.setup_model.assign("simulation.lateral_speed_m_s", 0.04)
    window.setup_model.assign("simulation.rest_s", 1.6)
    wait(application, lambda: window.opengl_answer != "")
    window.actions_.in_space.setChecked(window.actions_.in_space.isEnabled())
    # a run that is done, and one whose result is preliminary
    window.actions_.record.trigger()
    wait(application, lambda: window.control.state is AppState.DONE)
    preliminary: list[object] = []
    window.control.run_preliminary.connect(preliminary.append)
    window.bar.runs.setValue(3)
    window.actions_.record.trigger()
    wait(application, lambda: bool(preliminary))
    wait(application, lambda: not window.track.result_shown and falling(window))
    application.processEvents()
    save(picture_of(window), output)
    window.actions_.stop.trigger()
    window.actions_.stop.trigger()
    wait(application, lambda: not window.control.state.running)


def picture_of(window: MainWindow) -> QImage:
    """Return what the screen shows: words in the 3D view are missing from a widget that draws itself."""
    whole = window.screen().grabWindow(window.winId())
    return whole.toImage() if not whole.isNull() else window.grab().toImage()


def falling(window: MainWindow) -> bool:
    """Return whether the sphere falls once more."""
    shown = window.track.shown
    if shown is None or window.control.state is not AppState.RECORDING:
        return False
    z = shown.position_mm[2]
    return bool(z.min() < NEAR_FLOOR_MM and z[-1] < z[-8])


def wait(application: QApplication, condition: Callable[[], bool]) -> None:
    """Let the window live until something is true."""
    end = time.monotonic() + LONGEST_S
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError("the moment of the picture never came")
        application.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, TURN_MS)
        time.sleep(0.002)


def save(image: QImage, output: Path) -> None:
    """Save a PNG of less than `MOST_BYTES`, with fewer colours where it needs that."""
    flag = Qt.ImageConversionFlag.AvoidDither
    for candidate in (image, image.convertToFormat(QImage.Format.Format_Indexed8, flag)):
        buffer = QBuffer()
        buffer.open(QIODevice.OpenModeFlag.WriteOnly)
        candidate.save(buffer, "PNG", 0)
        data = bytes(buffer.data().data())
        if len(data) < MOST_BYTES:
            break
    else:
        raise ValueError(f"the picture has {len(data)} bytes, more than {MOST_BYTES}")
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_bytes(data)


if __name__ == "__main__":
    sys.exit(main())
