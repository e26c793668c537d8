"""One door to the checkout and what is made of it. Needs Python 3.11 or later and nothing else.

python3 packaging/dev.py run [--headless [--output DIR]]   the window; without a display three simulated drops
python3 packaging/dev.py test [PYTEST ARGUMENTS]           the whole test suite
python3 packaging/dev.py coverage [PYTEST ARGUMENTS]       the same, and the lines outside the window it does not reach
python3 packaging/dev.py lint                              ruff, formatting, types, layers
python3 packaging/dev.py bench [NAME [ARGUMENTS]]          one benchmark; without a name the list of them
python3 packaging/dev.py lock [--upgrade]                  the hashed lock anew, after a change of dependencies
python3 packaging/dev.py docs                              the help that F1 opens and the static site, build/help
python3 packaging/dev.py wheel                             wheel and source distribution, tried in an empty environment
python3 packaging/dev.py freeze                            the frozen folder dist/radargui, tried
python3 packaging/dev.py audit                             known vulnerabilities of the locked packages (network)
python3 packaging/dev.py bounds oldest|newest              the tests with the oldest, the newest allowed dependencies
"""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

if sys.version_info < (3, 11):
    sys.exit(f"RadarGUI needs Python 3.11 or later; this is Python {sys.version.split()[0]} ({sys.executable}).")

import environment
import locking
import packages
import qt_libraries

ROOT = environment.ROOT
BENCHMARKS = ROOT / "tests" / "benchmarks"


def run(arguments: list[str]) -> int:
    """Open the window, or do the same job headless where there is no display."""
    if "--headless" not in arguments and qt_libraries.has_display():
        qt_libraries.ensure(qt_libraries.WINDOW)
        python = environment.ensure("run")
        code = _call([str(python), "-m", "radargui", *arguments])
        if code < 0:
            print(
                "The window could not start. Without a display: python3 packaging/dev.py run --headless",
                file=sys.stderr,
            )
        return 1 if code < 0 else code
    if "--headless" in arguments:
        print("Doing the job headless: three simulated drops.", flush=True)
    else:
        print("No display here: doing the same job headless, three simulated drops.", flush=True)
    python = str(environment.ensure("run"))
    output = [argument for argument in arguments if argument != "--headless"]
    session, code = _record([python, "-m", "radargui", "record", "--runs", "3", "--fast", *output])
    return code or _call([python, "-m", "radargui", "report", session])


def _record(command: list[str]) -> tuple[str, int]:
    """Run a recording, pass on what it prints, and return the session folder it names and its status."""
    session = ""
    utf8 = {**_environment(), "PYTHONIOENCODING": "utf-8"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, encoding="utf-8", env=utf8) as process:
        for line in process.stdout or ():
            print(line, end="", flush=True)
            if line.startswith("Session: "):
                session = line.removeprefix("Session: ").strip()
    return session, process.returncode


def test(arguments: list[str], *prefix: str) -> int:
    """Run the test suite on three processes, since tests wait, too; arguments go to pytest."""
    qt_libraries.ensure(qt_libraries.OFFSCREEN)
    python = environment.ensure("dev")
    alone = any(argument.startswith(("-n", "--pdb", "--numprocesses", "--collect-only")) for argument in arguments)
    # a file stays together: its shared window or estimate is made once. A process that crashes ends the run: with
    # another in its place pytest-xdist 3.8 hands out what was done already, and waits for it for ever
    parallel = [] if alone else ["-n", "3", "--dist", "loadfile", "--max-worker-restart", "0"]
    return _call([str(python), "-m", *prefix, "pytest", *parallel, *arguments], cwd=ROOT)


def coverage(arguments: list[str]) -> int:
    """Run the tests and list the lines outside the window that they do not reach, in processes they start too."""
    measured = [str(environment.ensure("dev")), "-m", "coverage"]
    _call([*measured, "erase"], cwd=ROOT)
    failed = test(arguments, "coverage", "run", "-m")
    return _call([*measured, "combine", "--quiet"], cwd=ROOT) or _call([*measured, "report"], cwd=ROOT) or failed


def lint(arguments: list[str]) -> int:
    """Check style, formatting, types and layers; all four, whatever the first says."""
    if arguments:
        sys.exit("lint takes no arguments")
    environment.ensure("dev")
    checks = (["ruff", "check"], ["ruff", "format", "--check"], ["mypy"], ["lint-imports"])
    failed = []
    for name, *options in checks:
        print(f"== {name} {' '.join(options)}".rstrip(), flush=True)
        if _call([str(environment.tool(name)), *options], cwd=ROOT):
            failed.append(name)
    print(f"lint: {', '.join(failed)} failed" if failed else "lint: all good", flush=True)
    return int(bool(failed))


def bench(arguments: list[str]) -> int:
    """Run one benchmark, or list them."""
    found = {path.stem: path for path in sorted(BENCHMARKS.glob("*.py")) if not path.stem.startswith("_")}
    if not arguments or arguments[0] not in found:
        for name, path in found.items():
            print(f"{name:20} {path.read_text(encoding='utf-8').partition(chr(10))[0].strip(chr(34))}")
        if arguments:
            print(f"There is no benchmark {arguments[0]!r}.", file=sys.stderr)
        elif not found:
            print("There is no benchmark yet.")
        return 2 if arguments else 0
    python = environment.ensure("dev")
    return _call([str(python), str(found[arguments[0]]), *arguments[1:]], PYTHONPATH=str(ROOT / "tests"))


def lock(arguments: list[str]) -> int:
    """Write the hashed locks anew; `--upgrade` takes the newest versions instead of those locked now."""
    environment.ensure("dev")
    return locking.lock(arguments)


def _environment(**extra: str) -> dict[str, str]:
    # without bytecode each of the tests' hundred processes would compile the program anew
    dropped = ("PYTHONHOME", "PYTHONPATH", "PYTHONDONTWRITEBYTECODE")
    kept = {name: value for name, value in os.environ.items() if name not in dropped}
    return {**kept, **extra}


def _call(command: list[str], cwd: Path | None = None, **extra: str) -> int:
    with subprocess.Popen(command, cwd=cwd, env=_environment(**extra)) as process:
        while True:
            try:
                return process.wait()
            except KeyboardInterrupt:
                continue  # the program got it too and ends in its own way, with its files closed


VERBS = {"run": run, "test": test, "coverage": coverage, "lint": lint, "bench": bench, "lock": lock}
VERBS |= {
    one.__name__: one for one in (packages.docs, packages.wheel, packages.freeze, packages.audit, packages.bounds)
}


def main(arguments: list[str]) -> int:
    """Run one verb and return the exit status."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a code page of Windows lacks some signs of the tables
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(__doc__)
        return 0 if arguments else 2
    if arguments[0] not in VERBS:
        print(f"{arguments[0]!r} is not one of {', '.join(VERBS)}.", file=sys.stderr)
        return 2
    try:
        return VERBS[arguments[0]](arguments[1:])
    except KeyboardInterrupt:
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
