"""The staged file: to HDF5 it is a file, on the disk it goes from one whole state to the next."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st
from support.failing_disk import FailingDisk

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
    disk = FailingDisk(monkeypatch)
    staged = StagedFile(tmp_path / "file")
    staged.write(b"first state")
    staged.commit()
    staged.seek(0)
    staged.write(b"second state, longer")
    disk.left = failing_call - 1
    with pytest.raises(OSError, match="No space"):
        staged.commit()
    assert (tmp_path / "file").read_bytes() == b"first state"
    with pytest.raises(OSError, match="No space"):
        staged.commit()
    staged.seek(0)
    assert staged.read() == b"second state, longer"
    staged.close()


def test_an_automatic_one_goes_to_the_disk_by_itself_and_keeps_its_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk, much = FailingDisk(monkeypatch), bytes(17_000_000)
    staged = StagedFile(tmp_path / "file", automatic=True)
    staged.write(much)
    assert (tmp_path / "file").stat().st_size == len(much)
    disk.left = 0
    staged.write(much)
    staged.write(b" and still more")
    with pytest.raises(OSError, match="No space"):
        staged.commit()
    staged.close()
