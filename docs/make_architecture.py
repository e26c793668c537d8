"""Draw figures/architecture.svg: the packages and who may import whom, as import-linter holds it.

python docs/make_architecture.py
"""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "figures" / "architecture.svg"
WIDTH, STEP = 10.0, 0.62


def layers() -> list[list[str]]:
    """Return the packages from top to bottom, neighbours that do not know each other on one line."""
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    house = next(one for one in linter["contracts"] if one["type"] == "layers" and "containers" not in one)
    return [[name.strip().removeprefix("radargui.") for name in line.split("|")] for line in house["layers"]]


def meaning(name: str) -> str:
    """Return what a package says of itself: the first sentence of its docstring, at most a line."""
    place = ROOT / "radargui" / name
    file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    said = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return said.partition("\n")[0].partition(";")[0].rstrip(".")


def draw() -> Figure:
    """Return the picture: a box a package, arrows only downwards."""
    rows = layers()
    figure = Figure(figsize=(WIDTH, STEP * len(rows)))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(0.0, WIDTH), ylim=(-STEP * len(rows), 0.0))
    axes.axis("off")
    for row, names in enumerate(rows):
        width = (WIDTH - 0.5) / len(names)
        for column, name in enumerate(names):
            left, top = 0.4 + column * width, -STEP * row - 0.05
            axes.text(left + 0.1, top - 0.2, name, weight="bold", va="center", size=9)
            axes.text(left + 0.1, top - 0.4, _cut(meaning(name), width), va="center", size=6.5)
            axes.add_patch(mpl.patches.Rectangle((left, top - 0.52), width - 0.08, 0.52, fill=False, linewidth=0.8))
    end = {"xy": (0.2, 0.1 - STEP * len(rows)), "xytext": (0.2, -0.1)}
    axes.annotate("", **end, arrowprops={"arrowstyle": "->"})
    axes.text(0.1, -0.5 * STEP * len(rows), "imports", rotation=90, va="center", ha="center", size=7)
    return figure


def _cut(text: str, width: float) -> str:
    most = int(width * 16)
    return text if len(text) <= most else text[: text.rfind(" ", 0, most)] + " …"


if __name__ == "__main__":
    with mpl.rc_context({"svg.hashsalt": "radargui", "svg.fonttype": "none"}):
        draw().savefig(PICTURE, metadata={"Date": None})
