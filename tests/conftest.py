"""What all tests share: headless Qt, the real recordings, no thread left behind."""

from __future__ import annotations

import gc
import os
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# each process imports all of the tests first: the collector would look through them again and again
gc.disable()
# the tests share the cores already; many small matrices on several threads each would take four times as long
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
# as low as it goes, once for all processes: what the program puts below its window has its turn beside the tests
if hasattr(os, "nice"):
    os.nice(19)
# commands that run with a folder of the test as home would look through all fonts each time
os.environ.setdefault("MPLCONFIGDIR", str(Path(tempfile.gettempdir(), "radargui-tests-matplotlib")))
os.environ.setdefault("PYQTGRAPH_QT_LIB", "PySide6")

# the same examples each time: a suite that fails by chance is not believed when it fails for a reason
settings.register_profile("seeded", derandomize=True, deadline=None, max_examples=50)
settings.load_profile("seeded")


LONG = ("gate", "processing", "gui", "cli")
"""Folders whose files take longest: begun last, one of them would keep one process at work alone."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--hardware", action="store_true", help="run the tests that need a real NI device")
    parser.addoption("--slow", action="store_true", help="run the long tests too: many seeds, walls sought, a cluster")


def pytest_configure(config: pytest.Config) -> None:
    # pytest-xdist would begin with the files of many tests, not with the long ones
    config.option.loadscopereorder = False


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if not config.getoption("--slow"):
        slow = [item for item in items if "slow" in item.keywords]
        items[:] = [item for item in items if "slow" not in item.keywords]
        config.hook.pytest_deselected(items=slow)
    items.sort(key=lambda item: item.path.parent.name not in LONG)
    if config.getoption("--hardware"):
        return
    skip = pytest.mark.skip(reason="needs a real NI device: run with --hardware")
    for item in items:
        if "hardware" in item.keywords:
            item.add_marker(skip)


@pytest.fixture(autouse=True, scope="module")
def collected_in_the_main_thread_only(request: pytest.FixtureRequest) -> Iterator[None]:
    """Collect after each module: a library's thread that finds a dead window's objects would end the whole process."""
    if not gc.get_freeze_count():
        # the libraries: a million objects. Later ones would be kept that a window left behind
        gc.freeze()
    yield
    gc.collect()
    if request.path.parent.name != "gui":
        # what is left is caches and what was imported meanwhile: the next collection need not look at it
        gc.freeze()


def pytest_sessionfinish() -> None:
    """Collect everything: at the interpreter's end windows that nobody could collect would outlive the application."""
    gc.unfreeze()
    gc.collect()


@pytest.fixture
def test_data() -> Path:
    """Folder of the real recordings."""
    folder = os.environ.get("RADARGUI_TEST_DATA", "")
    if not folder or not Path(folder).is_dir():
        pytest.skip("RADARGUI_TEST_DATA is unset: the real recordings are not here")
    return Path(folder)


_LIBRARY_THREADS = ("pytest_timeout", "ThreadPoolExecutor", "grpc", "execnet", "Dummy", "pymain", "asyncio")


@pytest.fixture(autouse=True)
def no_thread_left_running() -> Iterator[None]:
    """Fail a test that leaves a thread running."""
    before = set(threading.enumerate())
    yield
    left = [thread for thread in threading.enumerate() if thread not in before and thread.is_alive()]
    left = [thread for thread in left if not thread.name.startswith(_LIBRARY_THREADS)]
    for thread in left:
        thread.join(timeout=1.0)
    left = [thread.name for thread in left if thread.is_alive()]
    if left:
        pytest.fail(f"threads left running: {left}")
