"""Names are the field's: one class of a name, and no word that no textbook has."""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

MODULES = sorted((Path(__file__).resolve().parents[1] / "radargui").rglob("*.py"))
NO_WORDS = {
    *("border", "ground", "pose", "repose", "road", "standing", "told", "tell", "tells", "teller", "desk"),
    *("mend", "mends", "mended", "doubted", "home", "law"),
}


def made(path: Path) -> Iterator[tuple[str, int]]:
    """Every name that a module gives, and its line: classes, functions, arguments, variables, fields."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name, node.lineno
        elif isinstance(node, ast.arg):
            yield node.arg, node.lineno
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id, node.lineno
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.attr, node.lineno


def test_no_two_classes_have_one_name() -> None:
    classes = Counter(
        node.name
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
    )
    assert [name for name, count in classes.items() if count > 1] == []


def test_names_are_words_of_the_field() -> None:
    for path in MODULES:
        for name, line in made(path):
            words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower().split("_")
            assert not NO_WORDS & set(words), f"{path}:{line}: {name}"
