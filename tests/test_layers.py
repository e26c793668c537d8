"""Every module but those of the window loads without Qt, and every one but the NI source without any NI package."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import radargui

PACKAGE = Path(radargui.__file__).parent
# the window, which is Qt; the NI source, which is NI's package; __main__ starts the program when it is loaded
LEFT_OUT = ("radargui.gui", "radargui.sources.ni", "radargui.__main__")
SCRIPT = """
import importlib, json, sys
for name in json.loads(sys.argv[1]):
    importlib.import_module(name)
loaded = [name for name in sys.modules if name.partition(".")[0] == "radargui"]
tops = {name.partition(".")[0] for name in sys.modules}
print(json.dumps([loaded, sorted(tops & {"PySide6", "shiboken6", "pyqtgraph", "OpenGL", "nidaqmx", "grpc"})]))
"""


def is_left_out(name: str) -> bool:
    return any(name == one or name.startswith(f"{one}.") for one in LEFT_OUT)


def test_all_modules_but_those_named_load_without_qt_and_without_nis_package() -> None:
    files = [path.relative_to(PACKAGE.parent) for path in PACKAGE.rglob("*.py")]
    on_disk = {".".join(file.with_suffix("").parts).removesuffix(".__init__") for file in files}
    wanted = {name for name in on_disk if not is_left_out(name)}
    assert all(one in on_disk for one in LEFT_OUT), "what is left out is there"
    assert {".".join(file.parent.parts) for file in files} <= on_disk, "each folder is a package"
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT, json.dumps(sorted(wanted))],
        capture_output=True,
        text=True,
        check=False,
        timeout=100,
    )
    assert ended.returncode == 0, ended.stderr
    loaded, unwanted = json.loads(ended.stdout)
    assert unwanted == []
    assert wanted - set(loaded) == set()
    assert sorted(name for name in loaded if name.startswith("radargui.gui")) == []
