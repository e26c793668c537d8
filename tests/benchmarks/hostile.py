"""Hostile input: 5,000 damaged files of every kind must be refused in one line or read right."""

from __future__ import annotations

import argparse
import sys
import time

from support.hostile.attack import attack

PIECE = 1000


def main() -> int:
    """Read the files, print a table by kind, and return 1 where one was neither refused nor read right."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", help="one kind of file only")
    options = parser.parse_args()
    begin = time.monotonic()
    counts, bad = {}, []
    for first in range(options.seed, options.seed + options.count, PIECE):
        toll = attack(first, min(PIECE, options.seed + options.count - first), options.kind)
        for key, number in toll.counts.items():
            counts[key] = counts.get(key, 0) + number
        bad += toll.bad
    print(f"{'kind':22}{'refused':>9}{'read':>9}{'bad':>9}")
    for kind in sorted({kind for kind, _ in counts}):
        print(f"{kind:22}" + "".join(f"{counts.get((kind, outcome), 0):9}" for outcome in ("refused", "read", "bad")))
    print(f"{sum(counts.values())} inputs in {time.monotonic() - begin:.0f} s, {len(bad)} bad")
    for one in bad:
        print(one)
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
