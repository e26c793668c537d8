"""Try the frozen folder as a stranger would: commands, then the window, driven by its keys. Run by name.

python packaging/try_frozen.py [dist/radargui]
xvfb-run -a -s "-screen 0 1600x1000x24" python packaging/try_frozen.py      with a window (xdotool needed)
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
QUICK = ROOT / "docs" / "examples" / "quick.toml"
LARGEST_MB, LONGEST_START_S, LONGEST_S, OPENING_S = 420.0, 2.0, 120.0, 15.0


def main() -> int:
    """Try all of it; the first thing that fails ends it."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "dist" / "radargui").resolve()
    program = folder / ("radargui.exe" if os.name == "nt" else "radargui")
    size_mb = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file() and not path.is_symlink()) / 1e6
    print(f"unpacked {size_mb:.0f} MB", flush=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as place:
        home = Path(place)
        own = dict.fromkeys(("HOME", "XDG_STATE_HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "APPDATA"), place)
        environment = {**os.environ, **own, "LOCALAPPDATA": place}
        commands(program, home, environment)
        if sys.platform.startswith("linux"):
            offscreen(program, environment)
            if os.environ.get("DISPLAY") and shutil.which("xdotool"):
                window(program, home, environment)
    require(size_mb <= LARGEST_MB, f"larger than {LARGEST_MB:g} MB")
    return 0


def require(holds: object, otherwise: str) -> None:
    """End with a sentence where something does not hold."""
    if not holds:
        sys.exit(f"FAILED: {otherwise}")


def commands(program: Path, home: Path, environment: dict[str, str]) -> None:
    """Three drops, their report, every format there and back, workers, what needs NI's package."""

    def call(*arguments: object, status: int = 0) -> str:
        words = [str(program), *map(str, arguments)]
        ended = subprocess.run(words, env=environment, capture_output=True, encoding="utf-8", timeout=300, check=False)
        require(ended.returncode == status, f"{arguments}: status {ended.returncode}\n{ended.stdout}{ended.stderr}")
        return ended.stdout + ended.stderr

    require(call("--version").startswith("radargui "), "no version")
    require("PySide6-Essentials  6." in call("info"), "info does not know its packages")
    call("record", "--fast", "--setup", QUICK, "--runs", 3, "--output", home / "sessions")
    (session,) = (home / "sessions").iterdir()
    call("report", session)
    names = {path.suffix for path in (session / "report").iterdir()}
    require({".pdf", ".html", ".csv", ".json"} <= names, f"report: {names}")
    for kind, suffix in (("csv", "csv"), ("mat", "mat"), ("tdms", "tdms"), ("sigmf", "sigmf-meta")):
        call("export", session / "run-0001.h5", "--format", kind, "--output", home / kind)
        call("process", home / kind / f"run-0001.{suffix}", "--setup", QUICK, "--output", home / f"from-{kind}")
        result = json.loads((home / f"from-{kind}" / "run-0001" / "result.json").read_text(encoding="utf-8"))
        require(result["status"] == "ok", f"{kind}: {result['status']}")
    call("batch", session, "--force", "--workers", 2, "--correction", "joint")
    require("No NI gRPC device server" in call("devices", "--remote", "localhost:1", status=1), "nidaqmx is not there")
    print("commands: all good", flush=True)


def offscreen(program: Path, environment: dict[str, str]) -> None:
    """Start the window without a display, see that it lives, and end it as Ctrl-C does."""
    with subprocess.Popen([str(program)], env={**environment, "QT_QPA_PLATFORM": "offscreen"}) as process:
        time.sleep(OPENING_S)
        lives = process.poll() is None
        process.send_signal(signal.SIGINT)
        try:
            process.wait(LONGEST_S)
        except subprocess.TimeoutExpired:
            process.kill()
        require(lives and process.returncode == 0, f"offscreen: status {process.returncode}")
    print("offscreen: opens and closes", flush=True)


def window(program: Path, home: Path, environment: dict[str, str]) -> None:
    """Three drops and a report by the window's own keys; the time until it is shown is that of the second start."""
    settings = home / "RadarGUI" / "RadarGUI.ini"
    settings.parent.mkdir(exist_ok=True)
    settings.write_text(f"[General]\ndata_folder={home / 'data'}\nruns=3\n", encoding="utf-8")
    for again in (False, True):
        begun = time.perf_counter()
        with subprocess.Popen([str(program), "--open", str(QUICK)], env=environment) as process, ended(process):
            found = wait(lambda: _windows(process.pid), "no window", 0.02)
            shown_s = time.perf_counter() - begun
            print(f"window shown after {shown_s:.2f} s", flush=True)
            time.sleep(3.0)
            if again:
                _press(found, "r")
                wait(lambda: _done(home / "data") == 3, "three drops were not recorded and processed")
                _press(found, "ctrl+r")
                wait(lambda: [*(home / "data").glob("*/report/report.pdf")], "no report was written")
                time.sleep(2.0)
            _press(found, "ctrl+q")
            require(process.wait(LONGEST_S) == 0, f"window: status {process.returncode}")
    print("window: three drops, report, closed", flush=True)
    require(shown_s <= LONGEST_START_S, f"the window was shown after {shown_s:.2f} s, more than {LONGEST_START_S:g} s")


@contextlib.contextmanager
def ended(process: subprocess.Popen[bytes]) -> Iterator[None]:
    """Leave no window behind, whatever fails."""
    try:
        yield
    finally:
        if process.poll() is None:
            process.kill()


def wait(condition: Callable[[], object], otherwise: str, every_s: float = 0.5) -> object:
    """Return what a condition gives as soon as it is true."""
    end = time.monotonic() + LONGEST_S
    while not (found := condition()):
        require(time.monotonic() < end, otherwise)
        time.sleep(every_s)
    return found


def _windows(process: int) -> str:
    search = ["xdotool", "search", "--onlyvisible", "--pid", str(process), "--name", "RadarGUI"]
    return subprocess.run(search, capture_output=True, text=True, check=False).stdout.partition("\n")[0]


def _press(window_number: object, key: str) -> None:
    number = str(window_number)
    subprocess.run(["xdotool", "windowfocus", "--sync", number, "key", "--clearmodifiers", key], check=False)


def _done(data: Path) -> int:
    """Return how many runs have a result: the final one is stored when its file is closed for the second time."""
    return sum("results" in _groups(path) for path in data.glob("*/run-*.h5"))


def _groups(path: Path) -> set[str]:
    try:
        import h5py

        with h5py.File(path) as file:
            return set(file)
    except OSError:
        return set()


if __name__ == "__main__":
    sys.exit(main())
