"""Loading everything but the window loads no Qt, and everything but the NI source no NI package."""

from __future__ import annotations

import json
import subprocess
import sys

SCRIPT = """
import importlib, json, pkgutil, sys
import radargui
left_out = ("radargui.gui", "radargui.sources.ni", "radargui.__main__")
names = [radargui.__name__]
for module in pkgutil.walk_packages(radargui.__path__, "radargui.", onerror=lambda name: None):
    if not module.name.startswith(left_out):
        importlib.import_module(module.name)
        names.append(module.name)
tops = {name.partition(".")[0] for name in sys.modules}
print(json.dumps([len(names), sorted(tops & {"PySide6", "pyqtgraph", "OpenGL", "nidaqmx", "grpc"})]))
"""


def test_all_packages_but_the_window_load_without_qt_and_without_nis_package() -> None:
    ended = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True, timeout=100)
    count, loaded = json.loads(ended.stdout)
    assert count > 100
    assert loaded == []
