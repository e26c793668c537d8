"""The computer is kept awake while runs are recorded or waited for; where it cannot be, the operator is told."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

import pytest
from support.controlled_source import ControlledSource
from support.inhibitor import HANGS, REFUSES, inhibitor
from support.simulated_setup import simulated_setup

from radargui.experiment.awake import kept_awake
from radargui.experiment.event import Event, EventKind, ExperimentState
from radargui.experiment.series import Experiment
from radargui.model.errors import SourceError
from radargui.session.session import Session
from radargui.sources.simulated.model import SimulatedSource

NOW = datetime.fromisoformat("2026-11-20T15:04:05+01:00")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="the stand-ins are shell scripts")


@pytest.mark.parametrize(("system", "name"), [("linux", "systemd-inhibit"), ("darwin", "caffeinate")])
def test_sleep_is_held_off_inside_and_let_go_after(
    system: str, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = inhibitor(tmp_path / "bin", name=name)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=os.pathsep)
    with kept_awake(system=system) as why:
        assert why == ""
        held = log.read_text(encoding="utf-8")
        assert "released" not in held
    assert ("--what=sleep:idle --mode=block" if system == "linux" else "-i ") in held
    assert log.read_text(encoding="utf-8").endswith("released\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (REFUSES, "Failed to inhibit: Access denied"),
        ("#!/bin/sh\nexit 1\n", "systemd-inhibit refused it"),
        (HANGS, "systemd-inhibit does not answer"),
    ],
)
def test_who_refuses_is_told(text: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    inhibitor(tmp_path / "bin", text)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"), prepend=os.pathsep)
    with kept_awake(system="linux", answer_s=0.3) as why:
        assert why == said
    with kept_awake(system="linux", answer_s=0.3, reports=False) as why:
        assert why == ""


def test_where_nothing_can_hold_it_off_that_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with kept_awake(system="linux") as why:
        assert why == "systemd-inhibit cannot be started: No such file or directory"
    with kept_awake(system="freebsd14") as why:
        assert why == "how to is not known for this system"


class Kernel32:
    """Of Windows: answers with the state before, 0 where it refuses."""

    def __init__(self, *, grants: bool = True) -> None:
        self.asked: list[int] = []
        self._grants = grants

    def SetThreadExecutionState(self, flags: object) -> int:  # noqa: N802 - its name
        self.asked.append(flags.value)  # type: ignore[attr-defined]
        return -0x80000000 if self._grants else 0


def test_windows_is_asked_for_this_thread_until_it_is_told_otherwise() -> None:
    kernel = Kernel32()
    with kept_awake(system="win32", kernel=kernel) as why:
        assert why == ""
        assert kernel.asked == [0x80000001]
    assert kernel.asked == [0x80000001, 0x80000000]
    with kept_awake(system="win32", kernel=Kernel32(grants=False)) as why:
        assert why == "Windows refused it"


@pytest.mark.parametrize("fails", [False, True])
def test_a_series_is_awake_from_the_first_wait_to_the_last_result(fails: bool, tmp_path: Path) -> None:
    events: list[Event | str] = []

    @contextmanager
    def awake_meanwhile() -> Iterator[str]:
        events.append("awake")
        yield "nobody holds it off"
        events.append("may sleep")

    setup = simulated_setup(settle_s=0.2)
    source = ControlledSource(opening_error=SourceError("It is off")) if fails else SimulatedSource(setup)
    session = Session.create(tmp_path, setup, now=NOW)
    experiment = Experiment(
        setup, lambda _: source, session, listener=events.append, live=False, patient=True, awake=awake_meanwhile
    )
    with suppress(SourceError):
        list(experiment.record(1))
    said = [event for event in events if isinstance(event, Event)]
    assert events[0] == "awake"
    assert said[0].kind is EventKind.WARNING
    assert said[0].message == (
        "This computer may fall asleep before the last run has ended (nobody holds it off). "
        "Switch that off in its power settings."
    )
    assert experiment.state is (ExperimentState.FAILED if fails else ExperimentState.DONE)
    assert events.index("may sleep") >= len(events) - 2, "its result is there, or it has failed"
