"""Versions of the program: the checkout as it is, or any commit, each with a tree of its own to be run from."""

from __future__ import annotations

import hashlib
import io
import os
import subprocess
import sys
import tarfile
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
KEPT = ROOT / "build" / "population"
"""Trees and results: git ignores them."""
PROGRAM = ("radargui", "resources")
"""What makes a version: tests and words beside these change no result."""


@dataclass(frozen=True)
class Version:
    """A version of the program.

    Attributes
    ----------
    name
        Short hash of the commit, with a plus where the checkout was changed since.
    key
        Of what the program consists of: two commits that differ in tests alone share their results.
    folder
        Its tree.
    """

    name: str
    key: str
    folder: Path


def version_of(reference: str | None = None) -> Version:
    """Return a commit's version, or that of the checkout as it is now, with its tree written out.

    Parameters
    ----------
    reference
        Whatever git takes for a commit; None: the checkout, changes and new files included.

    Raises
    ------
    SystemExit
        Git knows no such commit.
    """
    commit = reference or "HEAD"
    known = subprocess.run(
        ["git", "rev-parse", "--verify", "--quiet", f"{commit}^{{commit}}"], cwd=ROOT, capture_output=True, check=False
    )
    if known.returncode:
        sys.exit(f"git knows no commit {commit}")
    name = _git("rev-parse", "--short=7", f"{commit}^{{commit}}").strip()
    tree = f"{commit}^{{tree}}" if reference else _tree_of_checkout()
    parts = [_git("rev-parse", f"{tree}:{part}" if not reference else f"{commit}:{part}").strip() for part in PROGRAM]
    if not reference and parts != [_git("rev-parse", f"HEAD:{part}").strip() for part in PROGRAM]:
        name += "+"
    key = hashlib.sha256("".join(parts).encode()).hexdigest()[:12]
    return Version(name, key, _written(tree, KEPT / "versions" / key))


def _tree_of_checkout() -> str:
    """Return a tree object of the checkout's program, through an index of its own."""
    with tempfile.TemporaryDirectory() as folder:
        index = {"GIT_INDEX_FILE": str(Path(folder, "index"))}
        _git("read-tree", "HEAD", **index)
        _git("add", "--all", "--", *PROGRAM, **index)
        return _git("write-tree", **index).strip()


def _written(tree: str, folder: Path) -> Path:
    if not folder.is_dir():
        folder.parent.mkdir(parents=True, exist_ok=True)
        archive = subprocess.run(
            ["git", "archive", "--format=tar", tree, *PROGRAM], cwd=ROOT, capture_output=True, check=True
        ).stdout
        with tempfile.TemporaryDirectory(dir=folder.parent) as fresh, tarfile.open(fileobj=io.BytesIO(archive)) as tar:
            # whole or not at all: what was interrupted is no version
            whole = Path(fresh, "whole")
            tar.extractall(whole, filter="data")
            try:
                whole.rename(folder)
            except OSError:
                # another run that was started with this one was faster
                if not folder.is_dir():
                    raise
    return folder


def _git(*arguments: str, **environment: str) -> str:
    return subprocess.run(
        ["git", *arguments], cwd=ROOT, env={**os.environ, **environment}, capture_output=True, check=True, text=True
    ).stdout
