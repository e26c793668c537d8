"""The method and the code name each other: symbols lead to what there is, docstrings to what is written."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "radargui"
TEXT = (ROOT / "docs" / "method.md").read_text(encoding="utf-8")
SYMBOLS = (ROOT / "docs" / "symbols.md").read_text(encoding="utf-8")
MAX_WORDS = 7000
ESTIMATION = ("adaptive/", "forward/", "solve/", "select/", "posterior/")
SECTIONS = {int(one): text for one, text in re.findall(r"^## (\d) (.*?)(?=^## |\Z)", TEXT, re.MULTILINE | re.DOTALL)}


def rows() -> list[tuple[list[str], list[Path]]]:
    """Names and modules of each symbol."""
    found: list[tuple[list[str], list[Path]]] = []
    for line in re.findall(r"^\| (?!symbol)(.*) \|$", SYMBOLS, re.MULTILINE):
        _, names, modules, _ = re.split(r"(?<!\\) \| ", line)
        found.append((re.findall(r"`(.+?)`", names), [module(one) for one in re.findall(r"`(.+?)`", modules)]))
    return found


def module(name: str) -> Path:
    return PACKAGE / "estimation" / name if name.startswith(ESTIMATION) else PACKAGE / name


@cache
def defined(path: Path) -> frozenset[str]:
    """Every name that a module makes: functions, classes, their fields, constants, parameters."""
    out: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            out.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            out.add(node.id)
        elif isinstance(node, ast.arg):
            out.add(node.arg)
    return frozenset(out)


def headings(section: int) -> str:
    """The words under which something stands: the section's own, those of its parts, and what is in bold."""
    text = SECTIONS[section]
    parts = re.findall(r"^### (.+)$|\*\*(.+?)\*\*", text, re.MULTILINE)
    return "\n".join([text.splitlines()[0], *(one or other for one, other in parts)]).lower()


def test_each_name_of_the_tables_is_in_the_modules_beside_it() -> None:
    assert len(rows()) > 80
    for names, modules in rows():
        there = frozenset[str]().union(*map(defined, modules))
        for name in names:
            assert set(name.strip(".").split(".")) <= there, f"{name}: {[one.name for one in modules]}"


def test_no_text_and_no_docstring_tells_of_a_single_seed() -> None:
    for path in (*(ROOT / "docs").glob("*.md"), *PACKAGE.rglob("*.py")):
        found = re.search(r"seeds? \d{2,}|laboratory \d{4,}", path.read_text(encoding="utf-8"))
        assert not found, f"{path}: {found}"


def test_each_symbol_leads_to_a_word_of_the_method() -> None:
    for section, words in re.findall(r" \| (\d)(?:, (.+?))? \|$", SYMBOLS, re.MULTILINE):
        for word in filter(None, words.split("; ")):
            assert word.lower() in headings(int(section)), f"{section}, {word}"


def test_the_method_is_short_enough_to_be_read() -> None:
    assert len(TEXT.split()) <= MAX_WORDS


def test_each_module_that_the_method_names_is_there() -> None:
    named = {one for one in re.findall(r"`([a-z_]+/[a-z_/]+\.py)`", TEXT) if not one.startswith("tests/")}
    for name in named:
        assert module(name).exists(), name


def test_each_step_of_the_architecture_is_a_name_of_the_file_beside_it() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    steps = re.findall(r"^\| \d+ \| .*\| `(.+?)` \| `(.+?)` \|$", text, re.MULTILINE)
    beside = re.findall(r"`([a-z_/]+\.py)`\s\(`(\w+)`[,)]", text)
    assert len(steps) > 50
    for file, name in [*steps, *beside]:
        assert set(name.split(".")) <= defined(PACKAGE / file), f"{file}: {name}"


def test_contributing_names_files_that_are_there() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for name in re.findall(r"`((?:radargui|docs|resources|tests|packaging)/[\w/.-]+)`", text):
        assert (ROOT / name).exists(), name


@pytest.mark.parametrize("package", sorted(one.name for one in PACKAGE.iterdir() if (one / "__init__.py").exists()))
def test_where_a_docstring_points_something_stands(package: str) -> None:
    for path in (PACKAGE / package).rglob("*.py"):
        text = re.sub(r"\s+(?:# )?", " ", path.read_text(encoding="utf-8"))
        for first, second, words in re.findall(r"\b[Mm]ethod (\d)(?:(?: and|,) (\d))?(?:, ([\w' -]+))?", text):
            assert {int(one) for one in (first, second) if one} <= set(SECTIONS), f"{path}: {first}"
            for word in filter(None, words.split(" and ") if words else ()):
                assert word.strip().lower() in headings(int(second or first)), f"{path}: method {first}, {word}"
