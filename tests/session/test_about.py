"""The text of a bug report."""

from __future__ import annotations

import pytest

from radargui.session.about import without_folders


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("cannot read /mnt/group/project x.h5", "cannot read …/project x.h5"),
        (r"C:\Users\ada\lab\run.h5: no such file", "…/run.h5: no such file"),
        (r'file = "D:\\lab\\ada\\server.pem"', 'file = "…/server.pem"'),
        (r"\\server\share\ada\run.h5", "…/run.h5"),
        ('File "/usr/lib/python3/site-packages/radargui/gui/app.py", line 3', 'File "…/app.py", line 3'),
        ("200 kS/s of 1/f noise, I/Q and m/s, 2026/11/21", "200 kS/s of 1/f noise, I/Q and m/s, 2026/11/21"),
        ("https://semver.org/spec", "https://semver.org/spec"),
    ],
)
def test_paths_lose_their_folders_and_nothing_else_is_changed(text: str, shown: str) -> None:
    assert without_folders(text, {}) == shown
