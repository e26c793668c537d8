"""Tests hold what the program does, not how it is made: none imports a private name, few replace a part of it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

TESTS = Path(__file__).parent
REPLACING = {"setattr", "delattr", "setitem", "delitem"}
OWN = ("radargui", "support", "benchmarks")
"""Packages of this repository: what a test replaces is to come from elsewhere."""
STILL_REPLACING = {
    "gate/test_runs.py": 2,
    "gui/conftest.py": 2,
    "gui/test_channels.py": 1,
    "gui/test_newcomer.py": 1,
    "gui/test_ni_window.py": 1,
    "gui/test_opening.py": 3,
    "gui/test_operators.py": 1,
    "gui/test_put_away.py": 3,
    "gui/test_reprocess.py": 1,
    "gui/test_scopes.py": 1,
    "gui/test_series.py": 1,
    "gui/test_sessions.py": 4,
    "gui/test_stories.py": 3,
    "gui/test_transfer.py": 1,
}
"""Files that still replace a part of the program, and how often. The numbers only shrink."""


def sources() -> Iterator[tuple[str, ast.Module]]:
    """Yield each file of the tests, by its place, with its syntax tree."""
    for path in sorted(TESTS.rglob("*.py")):
        yield path.relative_to(TESTS).as_posix(), ast.parse(path.read_text(encoding="utf-8"))


def is_private(name: str) -> bool:
    return any(part.startswith("_") and not part.startswith("__") for part in name.split("."))


def foreign_names(tree: ast.Module) -> set[str]:
    """Return the names that a file imports from other people's packages, which are the outside world."""
    names: set[str] = set()
    for one in ast.walk(tree):
        if isinstance(one, ast.ImportFrom) and (one.module or "").partition(".")[0] not in OWN:
            names |= {alias.asname or alias.name for alias in one.names}
        elif isinstance(one, ast.Import):
            places = [alias.asname or alias.name.partition(".")[0] for alias in one.names]
            names |= {place for place in places if place not in OWN}
    return names


def root_of(node: ast.expr) -> str:
    """Return the name that an expression such as `os.path` begins with; empty where it begins with none."""
    while isinstance(node, ast.Attribute | ast.Call):
        node = node.value if isinstance(node, ast.Attribute) else node.func
    return node.id if isinstance(node, ast.Name) else ""


def replaced_inside(tree: ast.Module) -> list[str]:
    """Return what a file replaces by a fixture's `setattr` and the like, but for the outside world."""
    found, foreign = [], foreign_names(tree)
    for one in ast.walk(tree):
        if not (isinstance(one, ast.Call) and isinstance(one.func, ast.Attribute) and one.func.attr in REPLACING):
            continue
        target = one.args[0]
        if isinstance(target, ast.Constant):
            is_inside = str(target.value).startswith(OWN)
        else:
            is_inside = root_of(target) not in foreign
        if is_inside:
            found.append(ast.unparse(one))
    return found


def test_no_test_imports_a_private_name_of_the_program() -> None:
    found = [
        f"{place}: {node.module}.{alias.name}"
        for place, tree in sources()
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("radargui")
        for alias in node.names
        if is_private(f"{node.module}.{alias.name}")
    ]
    assert found == []


def test_a_test_gives_other_parts_by_parameters_and_replaces_the_outside_world_alone() -> None:
    found = {place: len(replaced) for place, tree in sources() if (replaced := replaced_inside(tree))}
    more = {place: count for place, count in found.items() if count > STILL_REPLACING.get(place, 0)}
    assert more == {}, "give the part by a parameter; only the outside world is replaced"
    fewer = {place: count for place, count in STILL_REPLACING.items() if count > found.get(place, 0)}
    assert fewer == {}, "it has become less: say so in STILL_REPLACING"
