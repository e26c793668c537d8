"""The staged file: to HDF5 it is a file, on the disk it goes from one whole state to the next."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from radargui.files import staged_file
from radargui.files.staged_file import StagedFile

_STEP = st.one_of(
    st.tuples(st.just("write"), st.integers(0, 60), st.binary(min_size=1, max_size=30)),
    st.tuples(st.just("read"), st.integers(0, 60), st.integers(0, 40)),
    st.tuples(st.just("truncate"), st.integers(0, 60), st.none()),
    st.tuples(st.just("commit"), st.none(), st.none()),
)


@settings(max_examples=60, deadline=None)
@given(st.lists(_STEP, max_size=30))
def test_it_behaves_as_a_file_in_memory_and_the_disk_holds_the_last_commit(
    tmp_path_factory: pytest.TempPathFactory, steps: list[tuple[str, int, object]]
) -> None:
    path = tmp_path_factory.mktemp("staged") / "file"
    model, committed = io.BytesIO(), b""
    staged = StagedFile(path)
    for what, place, value in steps:
        if what == "commit":
            staged.commit()
            committed = model.getvalue()
        elif what == "truncate":
            staged.truncate(place)
            content = model.getvalue()[:place].ljust(place, b"\0")
            model = io.BytesIO(content)
        elif what == "write":
            for file in (staged, model):
                file.seek(place)
                file.write(value)
        else:
            staged.seek(place)
            model.seek(place)
            assert staged.read(value) == model.read(value)
        assert staged.seek(0, 2) == len(model.getvalue())
        assert path.read_bytes() == committed
    staged.close()


@pytest.mark.parametrize("failing_call", [1, 2])
def test_a_commit_that_fails_leaves_the_file_as_it_was_and_fails_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing_call: int
) -> None:
    staged = StagedFile(tmp_path / "file")
    staged.write(b"first state")
    staged.commit()
    staged.seek(0)
    staged.write(b"second state, longer")
    put, calls = StagedFile._put, []

    def failing(self: StagedFile, place: int, data: bytes) -> None:
        calls.append(place)
        if len(calls) == failing_call:
            put(self, place, data[:3])
            raise OSError(28, "No space left on device")
        put(self, place, data)

    monkeypatch.setattr(StagedFile, "_put", failing)
    with pytest.raises(OSError, match="No space"):
        staged.commit()
    monkeypatch.undo()
    assert (tmp_path / "file").read_bytes() == b"first state"
    with pytest.raises(OSError, match="No space"):
        staged.commit()
    staged.seek(0)
    assert staged.read() == b"second state, longer"
    staged.close()


def test_an_automatic_one_goes_to_the_disk_by_itself_and_keeps_its_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(staged_file, "_LARGEST_STAGE", 10)
    staged = StagedFile(tmp_path / "file", automatic=True)
    staged.write(b"twelve bytes")
    assert (tmp_path / "file").read_bytes() == b"twelve bytes"

    def failing(self: StagedFile, place: int, data: bytes) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(StagedFile, "_put", failing)
    staged.write(b" and twelve more")
    staged.write(b" and still more")
    with pytest.raises(OSError, match="No space"):
        staged.commit()
    staged.close()
