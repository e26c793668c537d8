"""packaging/dev.py: the standard library alone brings up the checkout, and says what is missing."""

from __future__ import annotations

import ast
import importlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGING = ROOT / "packaging"
LOST = {"libnowhere.so.9": "libnowhere9"}
MODULES = ("dev", "environment", "locking", "packages", "qt_libraries")


@pytest.fixture
def dev(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The script dev.py as a module in an empty checkout with locks; neither it nor its neighbours stay loaded."""
    folder = tmp_path / "packaging"
    folder.mkdir()
    for name in MODULES:
        shutil.copy(PACKAGING / f"{name}.py", folder)
    for name in ("pyproject.toml", "packaging/requirements.txt", "packaging/requirements-dev.txt"):
        (tmp_path / name).write_text(name, encoding="utf-8")
    monkeypatch.syspath_prepend(str(folder))
    dev = importlib.import_module("dev")
    python = dev.environment.tool("python")
    python.parent.mkdir(parents=True)
    python.write_text("", encoding="utf-8")
    yield dev
    for name in MODULES:
        sys.modules.pop(name, None)


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Commands that would have been run; each succeeds, none is run."""
    seen: list[list[str]] = []

    def fake_run(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        seen.append(command)
        return subprocess.CompletedProcess(command, 0)

    monkeypatch.setattr(subprocess, "run", fake_run)
    return seen


SHARED = "radargui.system.qt_libraries"
SCRIPTS = (*(PACKAGING / f"{name}.py" for name in MODULES), ROOT.joinpath(*SHARED.split(".")).with_suffix(".py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.parent.name + "/" + script.stem)
def test_dev_imports_the_standard_library_alone(script: Path) -> None:
    tree = ast.parse(script.read_text(encoding="utf-8"))
    imported = {
        (node.module if isinstance(node, ast.ImportFrom) else alias.name) or ""
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    tops = {module.partition(".")[0] for module in imported - {SHARED}}
    assert tops <= sys.stdlib_module_names | set(MODULES)


def test_an_old_python_is_told_so_before_anything_else() -> None:
    trick = "import sys; sys.version_info = (3, 9, 2); import runpy; runpy.run_path(sys.argv[1], run_name='__main__')"
    ended = subprocess.run(
        [sys.executable, "-c", trick, str(PACKAGING / "dev.py"), "run"], capture_output=True, text=True, check=False
    )
    assert ended.returncode == 1
    assert "needs Python 3.11 or later" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_without_venv_it_says_what_to_install(
    dev: ModuleType, tmp_path: Path, calls: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    dev.environment.tool("python").unlink()
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(SystemExit, match="apt-get install -y python3-venv"):
        dev.environment.ensure("run")
    assert not calls


def test_the_first_start_installs_with_hashes_and_the_second_installs_nothing(
    dev: ModuleType, tmp_path: Path, calls: list[list[str]]
) -> None:
    dev.environment.ensure("run")
    installs = [" ".join(call) for call in calls if "install" in call]
    assert len(installs) == 2
    assert "--require-hashes" in installs[0]
    assert str(tmp_path / "packaging" / "requirements.txt") in installs[0]
    assert "--no-deps --no-build-isolation -e" in installs[1]
    calls.clear()
    dev.environment.ensure("run")
    assert not calls


@pytest.mark.parametrize("works", [True, False])
def test_the_locked_uv_installs_and_pip_where_it_cannot(
    dev: ModuleType, tmp_path: Path, calls: list[list[str]], monkeypatch: pytest.MonkeyPatch, works: bool
) -> None:
    uv = "uv==1.0 \\\n    --hash=sha256:00 \\\n    --hash=sha256:01\n"
    (tmp_path / "packaging" / "requirements-dev.txt").write_text(
        f"a==1 \\\n    --hash=sha256:02\n{uv}v==1\n", encoding="utf-8"
    )
    once, asked = subprocess.run, list[str]()

    def run(command: list[str], **options: object) -> subprocess.CompletedProcess[str]:
        if command[-1].endswith("uv.txt"):
            asked.append(Path(command[-1]).read_text(encoding="utf-8"))
        once(command, **options)
        return subprocess.CompletedProcess(command, int(command[0] == str(dev.environment.tool("uv")) and not works))

    monkeypatch.setattr(subprocess, "run", run)
    dev.environment.ensure("run")
    assert asked == [uv.rstrip()]
    installs = [call for call in calls if str(tmp_path / "packaging" / "requirements.txt") in call]
    assert all("--require-hashes" in call for call in installs)
    names = ["uv"] if works else ["uv", "python"]
    assert [call[0] for call in installs] == [str(dev.environment.tool(name)) for name in names]


def test_the_environment_for_tests_serves_for_running_but_not_the_other_way(
    dev: ModuleType, tmp_path: Path, calls: list[list[str]]
) -> None:
    dev.environment.ensure("run")
    calls.clear()
    dev.environment.ensure("dev")
    assert calls
    calls.clear()
    dev.environment.ensure("run")
    dev.environment.ensure("dev")
    assert not calls


@pytest.mark.parametrize("name", ["packaging/requirements-dev.txt", "pyproject.toml"])
def test_a_changed_lock_or_project_file_installs_again(
    dev: ModuleType, tmp_path: Path, calls: list[list[str]], name: str
) -> None:
    dev.environment.ensure("dev")
    calls.clear()
    (tmp_path / name).write_text("changed", encoding="utf-8")
    dev.environment.ensure("dev")
    assert calls


def test_a_damaged_stamp_counts_as_none(dev: ModuleType, tmp_path: Path, calls: list[list[str]]) -> None:
    for content in ("{", "[]", json.dumps({"run": "other"})):
        dev.environment.STAMP.write_text(content, encoding="utf-8")
        calls.clear()
        dev.environment.ensure("run")
        assert calls


def test_a_failed_installation_leaves_no_stamp(dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(command, 1 if "install" in command else 0)

    monkeypatch.setattr(subprocess, "run", fail)
    with pytest.raises(SystemExit, match="failed with status 1"):
        dev.environment.ensure("run")
    assert not dev.environment.STAMP.exists()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="system libraries come with Qt elsewhere")
class TestSystemLibraries:
    """What Qt loads from the system, on Linux."""

    def test_nothing_missing_is_silent(self, dev: ModuleType, calls: list[list[str]]) -> None:
        dev.qt_libraries.ensure({"libc.so.6": "libc6"})
        assert not calls

    def test_a_user_gets_the_exact_command(
        self, dev: ModuleType, calls: list[list[str]], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(os, "geteuid", lambda: 1000)
        monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}")
        with pytest.raises(SystemExit, match="sudo apt-get update && sudo apt-get install -y libnowhere9"):
            dev.qt_libraries.ensure(LOST)
        assert not calls

    def test_root_on_debian_gets_them_installed_after_an_update(
        self, dev: ModuleType, calls: list[list[str]], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(os, "geteuid", lambda: 0)
        monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}")
        with pytest.raises(SystemExit, match="still missing: libnowhere"):
            dev.qt_libraries.ensure(LOST)
        assert [call[1] for call in calls] == ["update", "install"]
        assert calls[1][-1] == "libnowhere9"

    def test_without_apt_get_the_libraries_are_named(
        self, dev: ModuleType, calls: list[list[str]], monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(shutil, "which", lambda name: None)
        with pytest.raises(SystemExit, match="libnowhere"):
            dev.qt_libraries.ensure(LOST)
        assert not calls

    def test_a_display_is_x11_or_wayland(self, dev: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.delenv("DISPLAY", raising=False)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        assert not dev.qt_libraries.has_display()
        monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
        assert dev.qt_libraries.has_display()


@pytest.mark.skipif(os.name == "nt", reason="a script stands for Python")
def test_run_without_a_display_says_so_and_does_the_job_headless(
    dev: ModuleType,
    tmp_path: Path,
    calls: list[list[str]],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    python, told = dev.environment.tool("python"), tmp_path / "told"
    python.write_text(f'#!/bin/sh\necho "$@" >> "{told}"\necho "Session: there"\n', encoding="utf-8")
    python.chmod(0o755)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert dev.main(["run", "--output", "here"]) == 0
    assert "No display" in capfd.readouterr().out
    record, report = told.read_text(encoding="utf-8").splitlines()
    assert record == "-m radargui record --runs 3 --fast --output here"
    assert report == "-m radargui report there"


def test_the_windows_package_is_started_where_it_is_built() -> None:
    assert "try_frozen.py" in (PACKAGING / "packages.py").read_text(encoding="utf-8")
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    job = workflow.partition("  frozen-windows:")[2].partition("\n\n")[0]
    assert "runs-on: windows" in job
    assert "run: python packaging/dev.py freeze" in job


def test_an_unknown_verb_or_benchmark_is_wrong_usage(
    dev: ModuleType, calls: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert dev.main(["frobnicate"]) == 2
    assert dev.main([]) == 2
    assert dev.main(["bench", "nothing-like-it"]) == 2
    assert not calls
    assert "run, test, coverage, lint, bench, lock" in capsys.readouterr().err


def test_the_check_of_a_bare_machine_calls_the_readmes_test_command_and_lint() -> None:
    script = ROOT / ".ci" / "run"
    text = script.read_text(encoding="utf-8")
    command = "python3 packaging/dev.py test"
    assert command in text
    assert command in (ROOT / "README.md").read_text(encoding="utf-8")
    assert "python3 packaging/dev.py lint" in text
    assert os.name == "nt" or os.access(script, os.X_OK)
