"""The world shares no code with the estimate: by its imports, as the contracts of the package hold them for it."""

from __future__ import annotations

import ast
from pathlib import Path

import benchmarks.world

WORLD = Path(benchmarks.world.__file__).parent
ALLOWED = ("benchmarks.world", "radargui.model", "radargui.files")


def imported(file: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: what is imported is named in full"
            names |= {f"{node.module}.{one.name}" for one in node.names}
        elif isinstance(node, ast.Import):
            names |= {one.name for one in node.names}
    return names


def test_the_world_imports_values_and_writers_of_the_program_and_nothing_that_estimates() -> None:
    files = sorted(WORLD.rglob("*.py"))
    found = {(file.relative_to(WORLD).as_posix(), name) for file in files for name in imported(file)}
    ours = {(file, name) for file, name in found if name.split(".")[0] in ("radargui", "benchmarks")}
    allowed = tuple(f"{one}." for one in ALLOWED)
    assert any(name.startswith("radargui.model") for _, name in ours), "the test sees imports"
    assert {(file, name) for file, name in ours if not f"{name}.".startswith(allowed)} == set()
