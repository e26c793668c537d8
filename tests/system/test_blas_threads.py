"""Linear algebra on one thread while it is asked for, and on as many as before after: in whatever order that ends."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import scipy.linalg  # noqa: F401  loads the second BLAS
from support.changed import changed
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup
from threadpoolctl import threadpool_info, threadpool_limits

from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.processing.process import process
from radargui.system.cores import one_blas_thread

FRESH = """
import json, pickle, sys
from threadpoolctl import threadpool_info
from radargui.processing.process import process

seen = []
def threads(_):
    seen.append([one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"])
with open(sys.argv[1], "rb") as file:
    process(*pickle.load(file), threads)
threads(1.0)
print(json.dumps(seen))
"""


def threads() -> set[int]:
    """How many threads the libraries of linear algebra use now."""
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


def set_threads(number: int) -> None:
    # a thread that ends: a number set in one that lives could be changed by no other
    thread = threading.Thread(target=threadpool_limits, args=(number, "blas"))
    thread.start()
    thread.join()


@pytest.fixture(autouse=True)
def of_two() -> Iterator[None]:
    (before,) = threads()
    set_threads(2)
    yield
    set_threads(before)


def small_run(correction: str) -> tuple[Recording, Setup]:
    setup = changed(quick_setup(), daq={"rate_hz": 2000.0}, processing={"correction": correction})
    return simulate_recording(setup)[0], setup


def test_a_fresh_process_solves_on_one_thread_whatever_is_loaded_later(tmp_path: Path) -> None:
    run = tmp_path / "run.pickle"
    run.write_bytes(pickle.dumps(small_run("adaptive")))
    two = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "2")
    ended = subprocess.run(
        [sys.executable, "-c", FRESH, str(run)],
        env={**os.environ, **two},
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    )
    *seen, after = json.loads(ended.stdout)
    assert {number for one in seen for number in one} == {1}
    # numpy's and scipy's
    assert len(after) >= 2
    assert set(after) == {2}


def test_blocks_that_end_in_any_order_give_back_what_the_first_has_found() -> None:
    for first in (0, 1):
        blocks = [ExitStack(), ExitStack()]
        for block in blocks:
            block.enter_context(one_blas_thread())
        assert threads() == {1}
        blocks[first].close()
        assert threads() == {1}
        blocks[1 - first].close()
        assert threads() == {2}


def test_a_block_within_a_block_that_fails_leaves_the_limit_to_the_outer_one() -> None:
    with one_blas_thread():
        with pytest.raises(ValueError, match="within"), one_blas_thread():
            raise ValueError("within")
        assert threads() == {1}
    assert threads() == {2}
    with pytest.raises(ValueError, match="without"), one_blas_thread():
        raise ValueError("without")
    assert threads() == {2}


def test_two_runs_that_are_processed_at_once_leave_the_callers_threads_as_they_were() -> None:
    run = small_run("published")
    is_within, first_ended = threading.Event(), threading.Event()

    def longer(_: float) -> None:
        is_within.set()
        first_ended.wait(60)

    second = threading.Thread(target=process, args=(*run, longer))

    def begin_second(_: float) -> None:
        if not is_within.is_set():
            second.start()
            is_within.wait(60)

    process(*run, begin_second)
    first_ended.set()
    second.join(60)
    assert threads() == {2}
