"""Tables of the command line: nothing of a result is lost where the terminal is narrow, nor on the way to a file."""

from __future__ import annotations

import sys

import pytest

from radargui.cli.bar import show_table

HEADER = ("input", "status", "bounces", "e ± u_e", "results")
FOLDER = "/home/somebody/Documents/RadarGUI/2026-11-23T13-21-58/drops-of-the-afternoon/run-0001"
ROW = ("run-0001", "no motion", "16", "0.80000 ± 0.00020", FOLDER)


def test_a_narrow_terminal_cuts_nothing_off(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    for columns in (120, 80, 60):
        monkeypatch.setenv("COLUMNS", str(columns))
        show_table(HEADER, [ROW])
        lines = capsys.readouterr().out.splitlines()
        # below the header, which is in bold
        rows = lines[next(number for number, line in enumerate(lines) if "─" in line) + 1 :]
        assert max(len(line) for line in rows) <= columns
        words = {word for line in rows for word in line.split()}
        assert words >= {"run-0001", "no", "motion", "16", "0.80000", "±", "0.00020"}
        assert FOLDER in "".join(line.split()[-1] for line in rows if line.strip())


def test_a_row_that_goes_to_a_file_is_one_line_however_long(capsys: pytest.CaptureFixture[str]) -> None:
    deep = "/".join([FOLDER] * 40)
    show_table(HEADER, [(*ROW[:-1], deep)])
    _, _, line = capsys.readouterr().out.splitlines()
    assert line.endswith(deep)
    assert ROW[3] in line
