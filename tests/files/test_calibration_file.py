"""A calibration in its file, and the setup that refers to it."""

from __future__ import annotations

import json
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.calibrations import MADE_AT, antenna_names, calibration_of, u_of
from support.small_setups import quick_setup
from support.words import words

from radargui.experiment.calibrating import free_path, write_calibration
from radargui.model.assumed import uncertain_inputs
from radargui.model.calibrated_setup import calibrated, changes_since, edited_since, too_old
from radargui.model.calibration import Calibration, calibration_text, parse_calibration, read_calibration
from radargui.model.errors import FileError, SetupError
from radargui.model.setup import changed, dump_setup, parse_setup, read_setup, write_setup

SETUP = quick_setup()


def same(a: Calibration, b: Calibration) -> bool:
    arrays = ("before", "values", "u_before", "covariance")
    whole = all(np.array_equal(getattr(a, key), getattr(b, key), equal_nan=True) for key in arrays)
    plain = ("names", "undetermined", "verdict", "reason", "origin", "notes")
    return whole and all(getattr(a, key) == getattr(b, key) for key in plain) and repr(a.residuals) == repr(b.residuals)


numbers = st.floats(-1e3, 1e3)


@settings(max_examples=30, deadline=None)
@given(st.data())
def test_what_is_read_is_what_was_written(data: st.DataObject) -> None:
    n = len(antenna_names(SETUP))
    root = np.array(data.draw(st.lists(numbers, min_size=n, max_size=n)))
    made = replace(
        calibration_of(SETUP, covariance=np.outer(root, root) + np.eye(n)),
        values=np.array(data.draw(st.lists(numbers, min_size=n, max_size=n))),
        reason=data.draw(st.text(st.characters(exclude_categories=["Cs"]), max_size=30)),
        notes=tuple(data.draw(st.lists(st.text(st.characters(exclude_categories=["Cs"])), max_size=2))),
        u_before=np.full(n, np.nan),
    )
    assert same(parse_calibration(calibration_text(made), "it"), made)


@settings(max_examples=60, deadline=None)
@given(place=st.integers(0, 4000), put=st.sampled_from([b"", b"\xff", b"{", b'"x"', b"1e999", b"null", b"[" * 9]))
def test_a_damaged_file_is_refused_in_one_sentence_or_says_the_same_kind_of_thing(place: int, put: bytes) -> None:
    whole = calibration_text(calibration_of(SETUP)).encode()
    broken = whole[: place % len(whole)] + put + whole[place % len(whole) + 1 :]
    said = ""
    try:
        found = parse_calibration(broken.decode("utf-8", errors="replace"), "it.json")
        # a letter of a text or a digit of a number: it still fits together
        assert found.covariance.shape == (len(found.names),) * 2
    except FileError as error:
        said = str(error)
    assert not said or ("it.json" in said and "\n" not in said)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"schema": 2}, "newer version"),
        ({"schema": "1"}, "schema"),
        ({"covariance": [[1.0]]}, "10 rows and columns"),
        ({"values": [1.0]}, "10 rows and columns"),
        ({"verdict": "splendid"}, "verdict"),
        ({"colour": 1}, "colour"),
        ({"before": []}, "one number for each name"),
    ],
)
def test_what_no_calibration_can_say_is_refused_by_name(change: dict[str, object], said: str) -> None:
    text = json.dumps(json.loads(calibration_text(calibration_of(SETUP))) | change)
    with pytest.raises(FileError, match=said):
        parse_calibration(text, "it")


def test_a_covariance_that_none_can_have_is_refused() -> None:
    covariance = np.diag(u_of(antenna_names(SETUP)) ** 2)
    covariance[0, 1] = covariance[1, 0] = 1.5 * 0.3**2
    with pytest.raises(FileError, match="variance below 0"):
        calibration_text(calibration_of(SETUP, covariance=covariance))


def test_an_older_file_is_kept_unless_asked_otherwise(tmp_path: Path) -> None:
    old, new = calibration_of(SETUP), calibration_of(SETUP, shift_u=2.0)
    path = free_path(tmp_path, MADE_AT)
    assert path.name == "calibration-2025-11-03.json"
    write_calibration(path, old)
    with pytest.raises(FileError, match="there already"):
        write_calibration(path, new)
    assert same(read_calibration(path), old)
    assert free_path(tmp_path, MADE_AT).name == "calibration-2025-11-03-2.json"
    write_calibration(path, new, force=True)
    assert same(read_calibration(path), new)


def test_a_setup_file_refers_to_its_calibration_and_carries_it_along(tmp_path: Path) -> None:
    path, made = tmp_path / "lab.toml", calibration_of(SETUP, shift_u=1.0)
    write_calibration(tmp_path / "c.json", made)
    setup = calibrated(SETUP, made, tmp_path / "c.json")
    assert setup.receiver[0].tilt_deg == pytest.approx(SETUP.receiver[0].tilt_deg + 0.3)
    assert setup.receiver[1].u_azimuth_deg == 0.3
    assert setup.transmitter.u_distance_m == 0.002
    write_setup(setup, path)
    text = path.read_text(encoding="utf-8")
    assert 'file = "c.json"' in text
    assert "covariance" not in text
    read = read_setup(path)
    assert read.calibration == setup.calibration
    # a run keeps the whole of it: without the file, it is still known
    (tmp_path / "c.json").unlink()
    assert parse_setup(dump_setup(read)).calibration.content == setup.calibration.content
    with pytest.raises(SetupError, match=r"lab\.toml: calibration\.file: .*c\.json cannot be read"):
        read_setup(path)
    write_setup(read, path)
    assert read_setup(path).calibration.content == setup.calibration.content


def test_a_value_edited_afterwards_is_named_and_keeps_its_own_u(tmp_path: Path) -> None:
    setup = calibrated(SETUP, calibration_of(SETUP), tmp_path / "c.json")
    assert edited_since(setup) is None
    inputs = {one.key for one in uncertain_inputs(setup)}
    assert "calibration[10]" in inputs
    assert not any(key.startswith(("receiver", "transmitter")) for key in inputs)
    plain = setup.model_dump(by_alias=True)
    plain["receiver"][1]["tilt_deg"] += 1.0
    other = type(setup).model_validate(plain)
    assert words(edited_since(other)).startswith("not as calibrated 3 November 2025: receiver[2].tilt_deg = ")
    inputs = {one.key for one in uncertain_inputs(other)}
    assert "receiver[2].tilt_deg" in inputs
    assert "receiver[1].tilt_deg" not in inputs


def test_a_transmitter_off_the_axis_gets_a_position(tmp_path: Path) -> None:
    names = tuple(f"transmitter.position_m.{axis}" for axis in "xyz")
    made = replace(
        calibration_of(SETUP),
        names=names,
        values=np.array([0.01, -0.02, 0.7]),
        before=np.array([0.0, 0.0, 0.7]),
        u_before=np.full(3, 1e-3),
        covariance=np.diag([1e-6, 4e-6, 1e-6]),
    )
    setup = calibrated(SETUP, made, tmp_path / "c.json")
    assert setup.transmitter.position_m == (0.01, -0.02, 0.7)
    assert setup.transmitter.distance_m is None
    assert setup.transmitter.u_distance_m == 0.002
    assert edited_since(setup) is None
    assert not any(one.key == "transmitter.distance_m" for one in uncertain_inputs(setup))


def test_the_age_counts_to_the_day_asked_about(tmp_path: Path) -> None:
    setup = calibrated(SETUP, calibration_of(SETUP), tmp_path / "c.json")
    made = datetime.fromisoformat(MADE_AT)
    assert too_old(setup, made.replace(year=2026, month=11, day=3)) == ""
    assert "is 366 days old, more than calibration.max_age_days = 365" in too_old(setup, made.replace(2026, 11, 4))
    chosen = changed(setup, {"calibration.max_age_days": 400.0})
    assert too_old(chosen, made.replace(2026, 11, 4)) == ""
    assert too_old(SETUP, made) == ""


def test_old_and_new_are_compared_in_units_of_their_combined_u() -> None:
    changes = changes_since(calibration_of(SETUP), calibration_of(SETUP, shift_u=2.0))
    assert [one.in_u for one in changes] == pytest.approx([2.0 / np.sqrt(2.0)] * 10)
    assert (changes[2].name, changes[2].unit, changes[2].difference) == ("receiver.1.distance_m", "mm", "+4.0")
