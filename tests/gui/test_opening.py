"""A session is opened in the background: a slow disk holds up nothing, and the last one asked for is shown."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from support.gui_sessions import make_session

from radargui.gui.control.state import AppState
from radargui.gui.main_window import MainWindow
from radargui.gui.sessions import session_controller
from radargui.session.info import read_info
from radargui.session.lock import owner_of
from radargui.session.session import Session


class SlowDisk:
    """Sessions of some folders are not read before the test lets them; who reads is noted."""

    def __init__(self) -> None:
        self.gates: dict[Path, threading.Event] = {}
        self.threads: set[int] = set()

    def hold(self, path: Path) -> threading.Event:
        return self.gates.setdefault(path, threading.Event())

    def open(self, path: Path, *, write: bool = True) -> Session:
        self.threads.add(threading.get_ident())
        assert self.gates[path].wait(30.0) if path in self.gates else True
        return Session.open(path, write=write)


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Iterator[SlowDisk]:
    slow = SlowDisk()

    class Read(Session):
        open = slow.open

    monkeypatch.setattr(session_controller, "Session", Read)
    listed = Session.run_paths
    monkeypatch.setattr(
        Session,
        "run_paths",
        lambda session, **kind: slow.threads.add(threading.get_ident()) or listed(session, **kind),
    )
    yield slow
    for gate in slow.gates.values():
        gate.set()


@pytest.fixture
def two(tmp_path: Path) -> tuple[Path, Path]:
    folder = tmp_path / "data"
    return make_session(folder, 4, operator="Ada"), make_session(folder, 5, operator="Grace")


def is_open(window: MainWindow) -> str:
    session = window.control.session
    return session.path.name if session is not None else ""


def test_the_window_lives_while_a_session_is_read(
    window: MainWindow, disk: SlowDisk, two: tuple[Path, Path], wait_for: Callable[..., None], qtbot: Any
) -> None:
    gate, opening = disk.hold(two[0]), f"opening {two[0].name}"
    window.sessions.open(two[0])
    assert is_open(window) == ""
    # asked for twice by a hand that sees nothing happen: read once
    window.sessions.open(two[0])
    assert window.jobs.running.count(opening) == 1
    # it draws, takes keys, and does what is asked for
    with qtbot.waitSignal(window._timer.timeout), qtbot.waitSignal(window._timer.timeout):
        window.panels.go_to("session")
    window.session_panel._lines["Sample"].setText("typed meanwhile")
    window.actions_.start.trigger()
    wait_for(lambda: window.control.state is AppState.LIVE)
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running)
    assert is_open(window) == ""

    gate.set()
    wait_for(lambda: not window.jobs.running)
    assert is_open(window) == two[0].name
    assert window.session_panel.details.operator == "Ada"
    assert [one.summary is not None for one in window.runs.model.entries] == [True]
    assert disk.threads
    assert threading.get_ident() not in disk.threads, "the thread that draws waited for the disk"


def test_why_a_session_cannot_be_opened_is_one_sentence(
    window: MainWindow, disk: SlowDisk, tmp_path: Path, wait_for: Callable[..., None]
) -> None:
    window.sessions.open(tmp_path)
    assert window.board.notices == (), "not known before it was read"
    wait_for(lambda: not window.jobs.running)
    (notice,) = window.board.notices
    assert (notice.level, notice.count, notice.details) == ("error", 1, "")
    assert notice.text.startswith(f"{tmp_path} is not a session")
    # and it can be asked for again
    window.sessions.open(tmp_path)
    wait_for(lambda: not window.jobs.running)
    assert window.board.notices[0].count == 2


def test_the_session_asked_for_last_is_shown_whichever_disk_is_faster(
    window: MainWindow, disk: SlowDisk, two: tuple[Path, Path], wait_for: Callable[..., None]
) -> None:
    gate = disk.hold(two[0])
    for path in two:
        window.sessions.open(path)
    wait_for(lambda: is_open(window) == two[1].name)
    gate.set()
    wait_for(lambda: not window.jobs.running)
    assert is_open(window) == two[1].name
    assert window.session_panel.details.operator == "Grace"
    assert owner_of(two[0]) is None, "other programs may write to what is not shown"
    assert window.board.notices == ()
    # back to the first one while the second is read
    disk.gates.clear()
    window.actions_.new_session.trigger()
    gate = disk.hold(two[1])
    for path in (*two[::-1], two[1], two[0]):
        window.sessions.open(path)
    gate.set()
    wait_for(lambda: not window.jobs.running)
    assert is_open(window) == two[0].name
    assert owner_of(two[1]) is None


@pytest.mark.parametrize("instead", ["new session", "cancel"])
def test_a_session_that_is_not_wanted_any_more_is_let_go(
    window: MainWindow, disk: SlowDisk, two: tuple[Path, Path], wait_for: Callable[..., None], instead: str
) -> None:
    gate = disk.hold(two[0])
    window.sessions.open(two[0])
    wait_for(lambda: disk.threads)
    window.actions_.new_session.trigger() if instead == "new session" else window.work.cancel()
    gate.set()
    wait_for(lambda: not window.jobs.running)
    assert is_open(window) == ""
    assert owner_of(two[0]) is None
    assert window.board.notices == ()


def test_runs_that_are_recorded_by_then_go_on_and_that_is_said(
    window: MainWindow, disk: SlowDisk, two: tuple[Path, Path], wait_for: Callable[..., None]
) -> None:
    gate = disk.hold(two[0])
    window.sessions.open(two[0])
    window.actions_.start.trigger()
    gate.set()
    wait_for(lambda: window.board.notices and not window.work.busy)
    assert window.board.notices[0].text == f"{two[0].name} was not opened: stop first, then open it again."
    assert is_open(window) == ""
    window.actions_.stop.trigger()
    wait_for(lambda: not window.control.state.running and not window.jobs.running)
    assert owner_of(two[0]) is None


def test_what_another_program_rejected_meanwhile_is_seen_when_a_session_is_opened_again(
    window: MainWindow, two: tuple[Path, Path], wait_for: Callable[..., None]
) -> None:
    for rejected in ("", "rejected by hand"):
        if rejected:
            session = Session.open(two[0])
            session.reject(two[0] / "run-0001.h5", rejected)
            session.close()
        window.sessions.open(two[0])
        wait_for(lambda: not window.jobs.running)
        assert [one.rejected for one in window.runs.model.entries] == [rejected or None]


def test_what_was_typed_of_a_session_is_written_before_it_is_let_go(
    window: MainWindow, two: tuple[Path, Path], wait_for: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    gate, update = threading.Event(), Session.update

    def late(session: Session, **about: Any) -> None:
        assert gate.wait(30.0)
        update(session, **about)

    monkeypatch.setattr(Session, "update", late)
    window.sessions.open(two[0])
    wait_for(lambda: not window.jobs.running)
    window.session_panel._notes.setPlainText("the last words")
    window.actions_.new_session.trigger()
    wait_for(lambda: len(window.jobs.running) == 2)
    gate.set()
    wait_for(lambda: not window.jobs.running)
    assert read_info(two[0]).notes == "the last words"
    assert owner_of(two[0]) is None
    assert window.board.notices == ()
