"""Work in pieces: the same here and in processes of its own; what fails there is said here."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator

import pytest
from support.counting import PARTS, killed_beside, process_of

from radargui.system.cores import Cores, cores, on_cores

PIECES = list(range(PARTS))
HERE = os.getpid()


@pytest.fixture(scope="module")
def apart() -> Iterator[Cores]:
    found = Cores(2)
    # the first time nobody waits for them
    assert [*found.map(process_of, PIECES)] == [(piece, HERE) for piece in PIECES]
    assert found.wait_ready(60.0)
    yield found
    found.close()


def test_other_processes_answer_in_order_and_none_of_it_is_done_here(apart: Cores) -> None:
    pieces, processes = zip(*apart.map(process_of, PIECES[:2]), strict=True)
    assert pieces == (0, 1)
    assert HERE not in processes


def test_a_single_piece_is_not_worth_the_way(apart: Cores) -> None:
    assert [*apart.map(process_of, PIECES[:1])] == [(0, HERE)]


def test_what_fails_in_another_process_is_raised_here_and_the_others_go_on(apart: Cores) -> None:
    with pytest.raises(ZeroDivisionError):
        list(apart.map(process_of, [1, -1]))
    assert HERE not in dict(apart.map(process_of, PIECES)).values()


def test_without_a_word_all_is_done_here() -> None:
    assert cores().count == 0
    assert {process for _, process in cores().map(process_of, list(range(100)))} == {HERE}
    with on_cores(1) as found:
        assert found.count == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no signals there")
def test_once_a_process_is_killed_all_is_done_here() -> None:
    with on_cores(2) as found:
        list(found.map(process_of, PIECES))
        assert found.wait_ready(60.0)
        assert [*found.map(killed_beside, [HERE] * PARTS)] == [HERE] * PARTS
        assert [*found.map(process_of, PIECES)] == [(piece, HERE) for piece in PIECES]


def test_two_cores_are_left_to_the_reader_and_the_window(monkeypatch: pytest.MonkeyPatch) -> None:
    for present, used in ((1, 0), (2, 0), (3, 0), (4, 2), (6, 4), (8, 4), (64, 4), (None, 0)):
        monkeypatch.setattr(os, "cpu_count", lambda present=present: present)
        with on_cores() as found:
            assert found.count == used
            assert cores() is found
    assert cores().count == 0
