"""Damaged and hostile files: refused in one line, or read right; nothing else happens."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from support.file_samples import read_all_channels
from support.hostile.attack import TESTS, attack
from support.hostile.victims import VICTIMS

from radargui.files.formats import SUFFIXES, list_channels
from radargui.files.reading import parse_channel_map
from radargui.model.errors import FileError, RadarGuiError, SetupError, UsageError
from radargui.model.setup import parse_setup, validate_setup

N_INPUTS = 250
"""The benchmark hostile reads 5,000."""
SEED = 20_261_120


def refused_in_one_line(error: RadarGuiError) -> None:
    assert "\n" not in str(error)
    assert len(str(error)) < 2000


def test_damaged_files_of_every_kind_are_refused_in_one_line_or_read_right() -> None:
    toll = attack(SEED, N_INPUTS)
    assert toll.bad == []
    assert toll.n_inputs == N_INPUTS
    assert {kind for kind, _ in toll.counts} == set(VICTIMS)
    assert sum(number for (_, outcome), number in toll.counts.items() if outcome == "refused") > N_INPUTS / 4


def test_what_claims_terabytes_nests_without_end_or_points_elsewhere_is_refused_at_once(tmp_path: Path) -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "support.hostile.claims_child", str(tmp_path)],
        capture_output=True,
        encoding="utf-8",
        timeout=100,
        check=False,
        env={**os.environ, "PYTHONPATH": str(TESTS), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    )
    told = [json.loads(line) for line in ended.stdout.splitlines()]
    assert ended.returncode == 0, ended.stderr
    assert len(told) > 20
    # The library reads what is there, and that is right.
    accepted = [(name, text) for name, outcome, text, _ in told if outcome != "refused"]
    assert accepted == [("tdms_of_a_terabyte", "")]
    assert [text for _, _, text, _ in told if "\n" in text or "memory" in text] == []
    # the longest sound file takes 23 thousand calls of functions; what walks through a terabyte takes thousands of them
    assert {name: calls for name, _, _, calls in told if calls > 100_000} == {}


@settings(deadline=None, max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from(SUFFIXES), st.binary(max_size=300), st.booleans())
@pytest.mark.filterwarnings("ignore")
def test_any_bytes_under_any_name_are_refused_or_read(
    tmp_path: Path, suffix: str, content: bytes, with_magic: bool
) -> None:
    magic = {".h5": b"\x89HDF\r\n\x1a\n", ".tdms": b"TDSm", ".sigmf-meta": b'{"global": ', ".csv": b"I1,Q1\n1,2\n"}
    path = tmp_path / f"a{suffix}"
    path.write_bytes((magic.get(suffix, b"") if with_magic else b"") + content)
    try:
        list_channels(path)
        read_all_channels(path)
    except FileError as error:
        refused_in_one_line(error)


@settings(deadline=None, max_examples=50)
@given(st.text(max_size=80) | st.text("IQ12=:,./\\ abc", max_size=40))
def test_any_text_as_channel_map_is_refused_or_complete_pairs(text: str) -> None:
    try:
        found = parse_channel_map(text)
    except UsageError as error:
        refused_in_one_line(error)
    else:
        assert len(found.entries) % 2 == 0


def test_a_receiver_of_five_thousand_digits_is_no_channel_map() -> None:
    with pytest.raises(UsageError) as refusal:
        parse_channel_map(f"I{'9' * 5000}=x,Q1=y")
    assert "\n" not in str(refusal.value)


@settings(deadline=None, max_examples=50)
@given(st.text(max_size=200) | st.text("[]{}=\"'.#\n ae1_-", max_size=60))
def test_any_text_as_setup_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(SetupError) as refusal:
        parse_setup(text)
    refused_in_one_line(refusal.value)


LEAVES: st.SearchStrategy[Any] = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9)
TREES = st.recursive(LEAVES, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=9), inner))
TABLES = ("schema", "radar", "transmitter", "receiver", "tracer", "floor", "daq", "recording", "processing")


@settings(deadline=None, max_examples=50, suppress_health_check=[HealthCheck.too_slow])
@given(st.dictionaries(st.sampled_from(TABLES) | st.text(max_size=9), TREES, max_size=6))
def test_any_values_as_setup_are_refused_in_one_line(document: dict[str, Any]) -> None:
    sound = {"schema": 1, "radar": {}, "transmitter": {"distance_m": 1.0}}
    sound["receiver"] = [{"tilt_deg": 1.0, "azimuth_deg": 2.0, "distance_m": 1.0}]
    try:
        validate_setup({**sound, **document})
    except RadarGuiError as error:
        refused_in_one_line(error)
