"""The setup file: read, written, the user's comments kept, faults named."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from radargui.model.errors import SetupError
from radargui.model.setup import MAXIMUM_BYTES, Setup, dump_setup, parse_setup, read_setup, write_setup
from radargui.system.resources import default_setup_path, shipped_setups

TEXT = default_setup_path().read_text(encoding="utf-8")


def with_value(setup: Setup, **tables: dict[str, object]) -> Setup:
    """Return the setup with keys of some tables changed, validated again."""
    document = setup.model_dump(by_alias=True, exclude_unset=True)
    for table, values in tables.items():
        document[table] = {**document.get(table, {}), **values}
    return Setup.model_validate(document)


@pytest.mark.parametrize("path", shipped_setups(), ids=lambda path: path.name)
def test_every_shipped_setup_is_valid_and_survives_a_round_trip(path: Path) -> None:
    setup = read_setup(path)
    assert parse_setup(dump_setup(setup)) == setup
    assert dump_setup(setup, path.read_text(encoding="utf-8")) == path.read_text(encoding="utf-8")


def test_a_save_keeps_the_users_comments_order_and_spelling(tmp_path: Path) -> None:
    path = tmp_path / "lab.toml"
    path.write_text(TEXT.replace("[daq]", "# wired on Monday\n[daq]"), encoding="utf-8")
    setup = with_value(read_setup(path), daq={"rate_hz": 20000.0}, tracer={"diameter_m": 0.008})
    write_setup(setup, path)
    written = path.read_text(encoding="utf-8")
    assert read_setup(path) == setup
    assert "# wired on Monday" in written
    assert "rate_hz = 20000.0                       # per channel" in written
    expected = TEXT.replace("[daq]", "# wired on Monday\n[daq]")
    expected = expected.replace("rate_hz = 33333.0", "rate_hz = 20000.0")
    assert written == expected.replace("diameter_m = 0.010", "diameter_m = 0.008")


def test_a_receiver_added_or_taken_away_leaves_the_others_as_they_were(tmp_path: Path) -> None:
    path = tmp_path / "lab.toml"
    path.write_text(TEXT.replace("azimuth_deg = 90.0", "azimuth_deg = 90.0   # north"), encoding="utf-8")
    three = read_setup(path)
    daq = three.daq.model_copy(update={"channels": None})
    one = three.model_copy(update={"receiver": three.receiver[:1], "daq": daq})
    write_setup(one, path)
    assert read_setup(path) == one
    assert path.read_text(encoding="utf-8").count("[[receiver]]") == 1
    write_setup(three, path)
    assert read_setup(path) == three
    assert "azimuth_deg = 90.0   # north" in path.read_text(encoding="utf-8")


def test_a_file_of_notepad_with_byte_order_mark_and_carriage_returns_is_read(tmp_path: Path) -> None:
    path = tmp_path / "lab.toml"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    assert read_setup(path) == parse_setup(TEXT)


def test_a_file_that_is_absent_or_a_folder_or_not_text_or_huge_is_refused_in_one_line(tmp_path: Path) -> None:
    binary, huge = tmp_path / "binary.toml", tmp_path / "huge.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    huge.write_bytes(b"#" * (MAXIMUM_BYTES + 1))
    for path in (tmp_path / "absent.toml", tmp_path, binary, huge):
        with pytest.raises(SetupError) as caught:
            read_setup(path)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)


def test_a_setup_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(SetupError, match="cannot be written"):
        write_setup(parse_setup(TEXT), tmp_path / "file" / "lab.toml")


def test_a_broken_file_is_replaced_whole(tmp_path: Path) -> None:
    path = tmp_path / "lab.toml"
    path.write_text("[broken", encoding="utf-8")
    write_setup(parse_setup(TEXT), path)
    assert read_setup(path) == parse_setup(TEXT)


LINES = TEXT.splitlines()
VALUES = st.one_of(
    st.floats(),
    st.integers(),
    st.booleans(),
    st.text(max_size=8).map(lambda text: repr(text)),
    st.sampled_from(["[]", "{}", "[1, 2, 3]", "1979-05-27", '"joint"', "nan", "-inf", "1e999", "0x10", ""]),
).map(str)


@st.composite
def disturbed_setups(draw: st.DrawFn) -> str:
    """Return the default setup with some lines given another value, doubled, dropped or replaced by any text."""
    lines = list(LINES)
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(lines) - 1))
        match draw(st.integers(0, 3)):
            case 0:
                lines[place] = lines[place].split("=")[0] + "= " + draw(VALUES)
            case 1:
                lines.insert(place, lines[draw(st.integers(0, len(lines) - 1))])
            case 2:
                lines[place] = ""
            case _:
                lines[place] = draw(st.text(max_size=30))
    return "\n".join(lines)


@settings(max_examples=100, deadline=None)
@given(st.one_of(disturbed_setups(), st.text(max_size=200)))
def test_any_text_is_a_setup_or_one_line_of_setup_error(text: str) -> None:
    try:
        setup = parse_setup(text)
    except SetupError as error:
        assert len(str(error).splitlines()) == 1  # noqa: PT017
    else:
        assert parse_setup(dump_setup(setup)) == setup
