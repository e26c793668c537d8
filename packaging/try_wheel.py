"""Try the wheel in an empty environment: it holds all resources, and a stranger's first commands work. Run by name.

python packaging/try_wheel.py [--from-source]     --from-source: the wheel is built again from the source distribution
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MADE = ROOT / "dist" / "wheel"
NEEDED = ("resources/setups/default.toml", "resources/help/index.html", "resources/window/words.toml", "py.typed")


def main() -> int:
    """Install and try."""
    pattern = "*.tar.gz" if "--from-source" in sys.argv else "*.whl"
    (package,) = MADE.glob(pattern)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        venv.create(folder / "venv", with_pip=True)
        programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}

        def call(*words: object, cwd: Path = folder) -> str:
            program, *arguments = map(str, words)
            ended = subprocess.run(
                [programs / program, *arguments], cwd=cwd, env=kept, capture_output=True, encoding="utf-8", check=False
            )
            if ended.returncode:
                sys.exit(f"FAILED: {words}\n{ended.stdout}{ended.stderr}")
            return ended.stdout

        install, lock = ("python", "-m", "pip", "install", "--quiet"), ROOT / "packaging" / "requirements.txt"
        call(*install, "--require-hashes", "--only-binary", ":all:", "-r", lock)
        call(*install, "--no-deps", "--no-build-isolation", package)
        shown = call("python", "-c", "import radargui, pathlib; print(pathlib.Path(radargui.__file__).parent)")
        installed = Path(shown.strip())
        missing = [name for name in NEEDED if not (installed / name).is_file()]
        shipped = [path.relative_to(ROOT) for path in (ROOT / "resources").rglob("*.*")]
        missing += [str(path) for path in shipped if not (installed / path).is_file()]
        if missing:
            sys.exit(f"FAILED: not in {package.name}: {missing}")
        call("radargui", "record", "--fast", "--setup", ROOT / "docs" / "examples" / "quick.toml", "--output", "data")
        (session,) = (folder / "data").iterdir()
        call("radargui", "report", session)
        script = "import radargui, sys; print(radargui.process(radargui.open_run(sys.argv[1])).status)"
        if call("python", "-c", script, session / "run-0001.h5").strip() != "ok":
            sys.exit("FAILED: import radargui")
        print(f"{package.name}: all good")
    return 0


if __name__ == "__main__":
    sys.exit(main())
