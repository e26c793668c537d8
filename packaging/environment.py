"""The checkout's own environment .venv: made once, filled from the hashed lock, left alone while that stays."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
STAMP = VENV / "radargui-stamp.json"
LOCKS = {
    "run": ROOT / "packaging" / "requirements.txt",
    "dev": ROOT / "packaging" / "requirements-dev.txt",  # holds all of the other, at the same versions
    "package": ROOT / "packaging" / "requirements-package.txt",  # what help, packages and audits are made with
}


def tool(name: str) -> Path:
    """Return the path of a program in the environment."""
    return VENV / ("Scripts" if os.name == "nt" else "bin") / (name + (".exe" if os.name == "nt" else ""))


def ensure(kind: str) -> Path:
    """Return the environment's Python, after installing the lock `kind` (run, dev or package) where it is not yet.

    Raises
    ------
    SystemExit
        The environment cannot be made, or a package cannot be installed.
    """
    python = tool("python")
    wanted = fingerprint(kind)
    stamp = _read_stamp() if python.exists() else {}
    if wanted in stamp.values():
        return python
    _make(python)
    print(f"Installing the locked packages into {VENV} (once; a minute or two)", flush=True)
    quiet = [] if sys.stdout.isatty() else ["--quiet"]
    pip = [str(python), "-m", "pip", "--disable-pip-version-check", "--no-input", "install", *quiet]
    locked = ["--require-hashes", "--only-binary", ":all:", "-r"]
    by_uv = ["pip", "install", "--compile-bytecode", *quiet, "--python", str(python)]
    if not _by_uv([*pip, *locked], [*by_uv, *locked, str(LOCKS[kind])]):
        _run([*pip, *locked, str(LOCKS[kind])])
    _run([*pip, "--no-deps", "--no-build-isolation", "-e", str(ROOT)])
    # the locks hold the same versions: what was installed by another one is still there
    installed = {name: value for name, value in _read_stamp().items() if name in LOCKS and value == fingerprint(name)}
    installed |= {kind: wanted, "run": fingerprint("run")}
    STAMP.write_text(json.dumps(installed, indent=2), encoding="utf-8")
    return python


def _by_uv(pip: list[str], arguments: list[str]) -> bool:
    """Install with uv in a tenth of pip's time; False where it cannot: indexes and proxies that pip knows, it does not.

    The hashes of the lock say which files are right, wherever they come from.
    """
    own, cache = VENV / "uv.txt", VENV / "uv-cache"
    lines = re.search(r"^uv==.*(?:\n .*)*", LOCKS["dev"].read_text(encoding="utf-8"), re.MULTILINE)
    if lines is None:
        return False
    own.write_text(lines[0], encoding="utf-8")
    # beside the packages the files of the cache are linked, not copied
    settings = {**os.environ, "UV_CACHE_DIR": str(cache), "UV_HTTP_TIMEOUT": "20", "UV_NATIVE_TLS": "1"}
    commands = ([*pip, str(own)], [str(tool("uv")), *arguments])
    quiet = not sys.stdout.isatty()
    done = all(
        subprocess.run(one, check=False, cwd=ROOT, env=settings, capture_output=quiet).returncode == 0
        for one in commands
    )
    shutil.rmtree(cache, ignore_errors=True)
    own.unlink()
    return done


def fingerprint(kind: str) -> str:
    """Return what the installed environment depends on as one text: lock, project file, place of the checkout."""
    digest = hashlib.sha256(str(ROOT).encode())
    for path in (LOCKS[kind], ROOT / "pyproject.toml"):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _read_stamp() -> dict[str, str]:
    try:
        stamp = json.loads(STAMP.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return stamp if isinstance(stamp, dict) else {}


def _make(python: Path) -> None:
    if _works(python):
        return
    if not (importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip")):
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        sys.exit(
            "This Python comes without venv and ensurepip. On Debian or Ubuntu install them with:\n"
            "  sudo apt-get update && sudo apt-get install -y python3-venv\n"
            f"(python{version}-venv where this is not the system's own Python), then start again."
        )
    print(f"Making {VENV} with Python {sys.version.split()[0]}", flush=True)
    _run([sys.executable, "-m", "venv", "--clear", str(VENV)])


def _works(python: Path) -> bool:
    if not python.exists():
        return False
    return subprocess.run([str(python), "-m", "pip", "--version"], capture_output=True, check=False).returncode == 0


def _run(command: list[str]) -> None:
    if code := subprocess.run(command, check=False, cwd=ROOT).returncode:
        sys.exit(f"This failed with status {code}: {' '.join(command)}")
