"""The mapping that a user chose is offered again for files with the same names."""

from __future__ import annotations

from pathlib import Path

import pytest

from radargui.experiment.importing import MAX_PATTERNS, MapMemory
from radargui.files.reading import parse_channel_map
from radargui.files.signals import ChannelInfo


def infos(*names: str) -> tuple[ChannelInfo, ...]:
    return tuple(ChannelInfo(name, 10) for name in names)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """The memory's file, in a folder that is not there yet."""
    return tmp_path / "config" / "maps.json"


def variables(memory: MapMemory, *names: str) -> tuple[str, list[str]]:
    guess = memory.guess(infos(*names))
    assert guess.channel_map is not None
    return guess.basis, [entry.variable for entry in guess.channel_map.entries]


def test_a_choice_is_remembered_for_the_pattern_of_names_only(path: Path) -> None:
    MapMemory(path).remember(infos("run 1/a", "run 1/b"), parse_channel_map("I1=run 1/b,Q1=run 1/a"))
    assert variables(MapMemory(path), "run 2/a", "run 2/b") == ("remembered", ["run 2/b", "run 2/a"])
    assert variables(MapMemory(path), "a", "c") == ("order", ["a", "c"])


def test_the_latest_choice_counts_and_the_oldest_is_forgotten(path: Path) -> None:
    memory = MapMemory(path)
    for number in range(MAX_PATTERNS + 3):
        memory.remember(infos(f"a{number}", "b"), parse_channel_map(f"I1=b,Q1=a{number}"))
    memory.remember(infos("a9", "b"), parse_channel_map("I1=a9,Q1=b"))
    assert variables(memory, "a9", "b") == ("remembered", ["a9", "b"])
    assert variables(memory, "a0", "b")[0] == "order"
    assert variables(memory, "a202", "b")[0] == "remembered"


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b"[" * 100_000,
        b'{"schema": 2, "maps": {}}',
        b'{"schema": 1, "maps": {"[\\"a\\", \\"b\\"]": [0, 1.0]}}',
        b'{"schema": 1, "maps": {"[\\"a\\", \\"b\\"]": [0, 0]}}',
        b'{"schema": 1, "maps": {"[\\"a\\", \\"b\\"]": [0, -1]}}',
        b'{"schema": 1, "maps": {"[\\"a\\", \\"b\\"]": [true, 1]}}',
        b"\xff\xfe\x00",
    ],
)
def test_a_damaged_memory_is_set_aside_and_stops_nothing(path: Path, content: bytes) -> None:
    path.parent.mkdir()
    path.write_bytes(content)
    memory = MapMemory(path)
    assert variables(memory, "a", "b") == ("order", ["a", "b"])
    assert path.with_name("maps.json.damaged").read_bytes() == content
    memory.remember(infos("a", "b"), parse_channel_map("I1=b,Q1=a"))
    assert variables(memory, "a", "b") == ("remembered", ["b", "a"])


def test_a_place_that_is_not_there_is_not_believed(path: Path) -> None:
    path.parent.mkdir()
    path.write_text('{"schema": 1, "maps": {"[\\"a\\", \\"b\\"]": [0, 7]}}', encoding="utf-8")
    assert variables(MapMemory(path), "a", "b") == ("order", ["a", "b"])


def test_a_folder_that_cannot_be_written_stops_nothing(tmp_path: Path) -> None:
    (tmp_path / "config").write_text("a file", encoding="utf-8")
    memory = MapMemory(tmp_path / "config" / "maps.json")
    memory.remember(infos("a", "b"), parse_channel_map("I1=b,Q1=a"))
    assert variables(memory, "a", "b")[0] == "order"
