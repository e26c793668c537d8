"""Rates over fresh scenes: right, told, wrong cause, SILENT, refused; coverage, errors, times; versions compared.

python3 packaging/dev.py bench population [--kind modelled laboratory ...] [-n 100] [--seed S] [--hold floor=0.95 ...]
python3 packaging/dev.py bench population --drops 10 -n 20           sessions of drops with one set of antennas
python3 packaging/dev.py bench population -n 300 --compare 8b9a5cd   the same scenes on another version, and a verdict
python3 packaging/dev.py bench population --set 'processing.correction="flights"'   as this setup asks
python3 packaging/dev.py bench population -n 24 --write FOLDER       scenes as files, for tests
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterable
from pathlib import Path

from benchmarks.gate.runs import ONE_THREAD, Population, kept_numbers, scores_of
from benchmarks.gate.score import Score
from benchmarks.gate.tables import Scenes, compared, comparison, tables
from benchmarks.gate.versions import ROOT, Version, version_of
from benchmarks.world.kinds import KINDS


def main() -> int:
    """Parse the command line, run, print; 1 where it is not shown to be not worse."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", nargs="+", choices=KINDS, default=["modelled"])
    parser.add_argument("-n", type=int, default=100, help="scenes of each kind, or sessions")
    parser.add_argument("--seed", type=int, help="left out: the hash of the last commit")
    parser.add_argument("--hold", nargs="+", default=[], metavar="NAME=VALUE", help="held instead of drawn, TOML")
    parser.add_argument("--set", nargs="+", default=[], metavar="KEY=VALUE", dest="asked", help="of the setup, TOML")
    parser.add_argument("--drops", type=int, default=0, metavar="K", help="sessions of so many drops each")
    parser.add_argument("--version", metavar="GITREF", help="a commit instead of the checkout as it is")
    parser.add_argument("--compare", metavar="GITREF", help="the same scenes on this commit too")
    parser.add_argument("--jobs", type=int, default=1, metavar="J", help="processes")
    parser.add_argument("--kept", action="store_true", help="only those of the scenes whose scores are there already")
    parser.add_argument("--write", type=Path, metavar="FOLDER", help="only draw: a folder a scene, below this one")
    parser.add_argument("--only", type=int, nargs="+", metavar="NUMBER", help="these scenes, with all that is said")
    options = parser.parse_args()
    os.environ.update(ONE_THREAD)
    seed = _seed() if options.seed is None else options.seed
    held, asked = (tomllib.loads("\n".join(lines)) for lines in (options.hold, options.asked))
    numbers = options.only or range(options.n)
    if options.write:
        print(f"seed {seed}")
        for kind in options.kind:
            _write(Population(kind, seed, held, options.drops, asked), numbers, options.write / kind)
        return 0
    versions = [version_of(options.version)]
    if options.compare:
        versions.append(version_of(options.compare))
    print(
        f"seed {seed}, version {' and '.join(one.name for one in versions)}, linear algebra on one thread", flush=True
    )
    found: dict[Version, dict[str, Scenes]] = {version: {} for version in versions}
    begin = time.monotonic()
    for kind in options.kind:
        population = Population(kind, seed, held, options.drops, asked)
        rows: dict[Version, list[list[Score]]] = {version: [] for version in versions}
        chosen = kept_numbers(population, versions, numbers) if options.kept else numbers
        for number, by_version in scores_of(population, versions, chosen, options.jobs):
            for version, scores in by_version.items():
                rows[version].append(scores)
                _print(kind, number, version, scores, whole=options.only is not None)
        for version in versions:
            found[version] |= _rows(kind, rows[version], options.drops)
    print(f"\n{(time.monotonic() - begin) / 60.0:.0f} minutes")
    for version in versions:
        print(f"\n{version.name}\n\n{tables(found[version])}")
    if not options.compare:
        return 0
    new, old = versions
    each = {name: compared(scenes, found[old][name]) for name, scenes in found[new].items()}
    print(f"\n{comparison(each, new.name, old.name)}")
    return int(any(one.fails for one in each.values()))


def _seed() -> int:
    """Return the hash of the last commit as a number."""
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, check=True, text=True).stdout
    return int(head[:8], 16)


def _write(population: Population, numbers: Iterable[int], folder: Path) -> None:
    """Write scenes as files: run.h5 and setup.toml as a user has them, the truth beside."""
    for number in numbers:
        place = folder / f"{number:03d}"
        place.mkdir(parents=True)
        population.write(number, place)


def _rows(kind: str, scenes: list[list[Score]], drops: int) -> dict[str, Scenes]:
    """Return the rows of a kind: all of it, and of sessions the first and the last drop by themselves."""
    rows: dict[str, Scenes] = {kind: scenes}
    for drop in (1, drops) if drops > 1 else ():
        rows[f"{kind}, drop {drop}"] = [[session[drop - 1]] for session in scenes]
    return rows


def _print(kind: str, number: int, version: Version, scores: list[Score], *, whole: bool) -> None:
    """Print a line for each scene, and what was said of one that is not right."""
    for drop, one in enumerate(scores, 1):
        name = f"{kind} {number}" + (f".{drop}" if len(scores) > 1 else "")
        off = f" off: {', '.join(one.faults)}" if one.status == "ok" and one.faults else ""
        print(f"{version.name} {name:18s} {one.outcome:11s} {one.status}{off} {one.seconds:.1f} s", flush=True)
        if whole or one.outcome != "right":
            print(f"    drawn: {', '.join(sorted(one.causes)) or 'nothing'}")
            for sentence in (one.reason, *one.sentences):
                if sentence:
                    print(f"    {sentence}")
            for unknown in one.named.unknown:
                print(f"    stands in no table of causes: {unknown}")
        if whole:
            values = {name: value for name, value in one.__dict__.items() if name not in ("sentences", "reason")}
            print(f"    {values}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
