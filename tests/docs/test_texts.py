"""What the texts show is true: every command and block runs, every link inside leads somewhere."""

from __future__ import annotations

import contextlib
import io
import logging
import re
import runpy
import shlex
import shutil
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.small_setups import PLATE

import radargui
from radargui.cli.app import app
from radargui.cli.console import guarded
from radargui.model.setup import changed, dump_setup, parse_setup, read_setup

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.glob("*.md"))
TEXTS = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *PAGES, *sorted((DOCS / "decisions").glob("*.md"))]
QUICK = DOCS / "examples" / "quick.toml"
SESSION = "2026-11-20T15-04-05"
_BLOCK = re.compile(
    r"^(?:<!-- needs: (.+?) -->\n)?( *)```(\w+|\{[\w-]+\})?[^\n]*\n(.*?)^\2```$", re.MULTILINE | re.DOTALL
)


@dataclass(frozen=True)
class Block:
    """What stands between two fences."""

    page: str
    kind: str
    text: str
    needs: str


def blocks(path: Path) -> list[Block]:
    found = _BLOCK.findall(path.read_text(encoding="utf-8"))
    return [Block(path.stem, kind, text, needs) for needs, _, kind, text in found]


ALL = [block for path in (ROOT / "README.md", *PAGES) for block in blocks(path)]


@pytest.fixture(scope="module")
def no_log() -> Iterator[None]:
    """Keep no log of what commands say: one that has a place for it already makes none."""
    kept, root = logging.NullHandler(), logging.getLogger()
    root.addHandler(kept)
    yield
    root.removeHandler(kept)


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory: pytest.TempPathFactory, no_log: None) -> Path:
    """A folder as the texts assume it: a setup, a session, recordings of other programs."""
    folder = tmp_path_factory.mktemp("laboratory")
    setup = changed(read_setup(QUICK), {"processing.correction": "ellipse"})
    (folder / "lab.toml").write_text(dump_setup(setup), encoding="utf-8")
    (folder / "plate.toml").write_text(PLATE, encoding="utf-8")
    with contextlib.redirect_stdout(io.StringIO()):
        arguments = ["record", "--fast", "--setup", str(folder / "lab.toml"), "--runs", "1", "--sample", "steel"]
        assert guarded(app, [*arguments, "--output", str(folder / "first")]) == 0
        (session,) = (folder / "first").iterdir()
        session = session.rename(folder / "first" / SESSION)
        shutil.copytree(session, folder / SESSION)
        shutil.copy(session / "run-0001.h5", folder)
        for kind in ("csv", "mat"):
            assert guarded(app, ["export", str(folder / "run-0001.h5"), "--format", kind, "--output", str(folder)]) == 0
            (folder / f"run-0001.{kind}").rename(folder / f"data.{kind}")
    (folder / "old").mkdir()
    shutil.copy(folder / "data.csv", folder / "old" / "of-last-year.csv")
    recording = radargui.open_run(folder / "run-0001.h5").recording
    np.ascontiguousarray(recording.raw.T, dtype="<i2").tofile(folder / "car.bin")
    return folder


@pytest.fixture
def there(laboratory: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the folder, and nothing of the user's own."""
    folder = Path(shutil.copytree(laboratory, tmp_path / "laboratory"))
    monkeypatch.chdir(folder)
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_, **__: tmp_path / "cache")
    monkeypatch.setattr("platformdirs.user_config_path", lambda *_, **__: tmp_path / "config")
    return folder


def commands(page: str) -> list[str]:
    return [
        line.removeprefix("$ ")
        for block in ALL
        if block.page == page and block.kind == "console" and not block.needs
        for line in block.text.splitlines()
        if line.startswith("$ ")
    ]


@pytest.mark.parametrize("page", sorted({block.page for block in ALL if block.kind == "console"}))
def test_the_commands_of_a_page_run_one_after_the_other(
    page: str, there: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for line in commands(page):
        program, verb, *given = shlex.split(line)
        assert program == "radargui", line
        simulated = verb == "record" or "simulated" in given
        if verb == "record" and not {"--setup", "--like", "--file"} & set(given):
            # the shipped setup has a higher rate
            given += ["--setup", "lab.toml"]
        arguments = [str(path) for one in given for path in (sorted(there.glob(one)) if "*" in one else [one])]
        status = guarded(app, [verb, *arguments, *(["--fast"] if simulated else [])])
        assert status == 0, f"{line}\n{capsys.readouterr().err}"


@pytest.mark.parametrize("page", sorted({block.page for block in ALL if block.kind == "python" and not block.needs}))
@pytest.mark.usefixtures("there")
def test_the_python_of_a_page_runs_from_its_first_block_to_its_last(page: str) -> None:
    names: dict[str, Any] = {}
    for block in ALL:
        if block.page == page and block.kind == "python" and not block.needs:
            exec(block.text, names)


@pytest.mark.parametrize("block", [one for one in ALL if one.kind == "toml"], ids=lambda one: one.page)
def test_a_piece_of_a_setup_is_valid_beside_the_rest(block: Block) -> None:
    if "schema = 1" in block.text:
        assert parse_setup(block.text).n_receivers == 3
        return
    given = tomllib.loads(block.text)
    if "project" in given:
        shipped = tomllib.loads((DOCS / "examples" / "plugins" / "pyproject.toml").read_text(encoding="utf-8"))
        assert given["project"] == shipped["project"]
        return
    table = given if all(isinstance(one, dict) for one in given.values()) else {"daq": given}
    changes = {f"{name}.{key}": value for name, keys in table.items() for key, value in keys.items()}
    # a piece that tells the air stands in place of the index
    rest = re.sub(r"^refractive_index.*\n", "", QUICK.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert changed(parse_setup(rest), changes)


def test_every_block_is_of_a_kind_that_is_run_or_of_one_that_is_only_shown() -> None:
    shown = {"text", "{toctree}", "{eval-rst}", "{literalinclude}"}
    older = {("README", ""), ("session-format", ""), ("session-format", "matlab")}
    kinds = {(block.page, block.kind) for block in ALL if block.kind not in shown | {"console", "python", "toml"}}
    assert kinds <= older
    needs = {block.needs for block in ALL} - {""}
    assert needs <= {"a device", "a cluster", "pandas and xarray"}


def slug(heading: str) -> str:
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


@pytest.mark.parametrize("path", TEXTS, ids=lambda path: path.stem)
def test_links_inside_lead_somewhere(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    text = re.sub(r"```.*?```|`[^`\n]*`(?!\])", "", text, flags=re.DOTALL)
    targets = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r'href="([^"]+)"', text)
    for target in targets:
        if "://" in target:
            continue
        name, _, anchor = target.partition("#")
        file = (path.parent / name).resolve() if name else path
        assert file.exists(), f"{path.name}: {target}"
        if anchor:
            headings = re.findall(r"^#+ (.+)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in map(slug, headings), f"{path.name}: {target}"


def test_every_page_is_in_the_contents_once() -> None:
    contents = "\n".join(block.text for block in blocks(DOCS / "index.md"))
    listed = [line for line in contents.splitlines() if line and line[0] not in ":" and "*" not in line]
    assert sorted(listed) == sorted(page.stem for page in PAGES if page.stem != "index")


def test_what_is_written_by_the_program_is_what_it_says_now() -> None:
    run = {name: runpy.run_path(str(DOCS / f"make_{name}.py")) for name in ("command_reference", "setup_reference")}
    # other versions of these word their help otherwise: the text is that of the locked ones
    lock = (DOCS.parent / "packaging" / "requirements.txt").read_text(encoding="utf-8")
    locked = dict(re.findall(r"^(click|rich|typer)==(\S+)", lock, re.MULTILINE))
    assert len(locked) == 3
    if all(metadata.version(name) == version for name, version in locked.items()):
        text = (DOCS / "commands.md").read_text(encoding="utf-8")
        assert text == run["command_reference"]["reference"](), "run docs/make_command_reference.py"
    text = (DOCS / "setup.schema.json").read_text(encoding="utf-8")
    assert text == run["setup_reference"]["schema"](), "run docs/make_setup_reference.py"


def test_each_dependency_is_listed_with_its_use_and_is_imported() -> None:
    made = runpy.run_path(str(DOCS / "make_dependencies.py"))
    allowed, count = made["requirements"](), made["imports"]()
    rows = re.findall(r"^\| ([\w-]+) \| `(.*?)` \| (.+?) \|", (DOCS / "dependencies.md").read_text(), re.MULTILINE)
    assert [(name, versions) for name, versions, _ in rows] == list(allowed.items()), "run docs/make_dependencies.py"
    assert {name: use for name, _, use in rows} == made["USES"]
    assert all(count[made["IMPORTED"].get(name, name)] for name in allowed)


def test_the_picture_of_the_packages_has_each_of_them() -> None:
    picture = (DOCS / "figures" / "architecture.svg").read_text(encoding="utf-8")
    layers = runpy.run_path(str(DOCS / "make_architecture.py"))["layers"]()
    for name in (one for line in layers for one in line):
        assert f">{name}</text>" in picture, "run docs/make_architecture.py"
    packages = {path.parent.name for path in (ROOT / "radargui").glob("*/__init__.py")}
    text = (DOCS / "architecture.md").read_text(encoding="utf-8").replace(":", " ")
    assert [name for name in sorted(packages) if f" {name}/ " not in text] == []
