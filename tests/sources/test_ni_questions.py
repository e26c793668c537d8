"""What a driver has forgotten for this process is asked for in another one."""

from __future__ import annotations

import os

import pytest

from radargui.sources.ni.discovery import asked_afresh


def test_a_question_is_asked_in_a_process_that_has_never_asked() -> None:
    asked_in = asked_afresh(eval, "__import__('os').getpid()")
    assert isinstance(asked_in, int)
    assert asked_in != os.getpid()


@pytest.mark.parametrize("device", ["no number", "__import__('os')._exit(3)"])
def test_who_is_told_nothing_there_gets_nothing(device: str) -> None:
    # it raises, or ends with its process
    assert asked_afresh(eval, device) is None
