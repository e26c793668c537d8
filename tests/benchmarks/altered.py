"""The real recordings altered in ways whose effect on the truth is known: which are silently wrong?

python3 packaging/dev.py bench altered [--count 100] [--seed N] [--correction adaptive] [--only K ...]

Each is one of the real recordings after one to three alterations: a part of it, backwards, at a lower rate, with noise,
drift, hum, another mixer or fewer bits added, after a rest. None makes a moving target out of a resting one, and where
the path is known before it is known after.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from benchmarks.real import CORRECTIONS, scene_of
from benchmarks.scoring.budget import timed
from benchmarks.scoring.one_receiver import judge
from benchmarks.scoring.real_truth import SOURCES, Known, Source, known_of, read
from benchmarks.world.one_receiver.scene import MIN_FRINGES, MIN_S as MIN_KNOWN_S, runs
from scipy import signal

from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation, Recording, iq_names

MIN_S = 0.4
"""A part that is cut out is at least this long: some hundred fringes of the cars, one stroke of the plate."""


@dataclass(frozen=True, slots=True)
class Altered:
    """Volts of I and Q, shape (2, n_samples), their rate and what is known of each sample."""

    volts: FloatArray
    rate_hz: float
    known: Known

    def sliced(self, part: slice) -> Altered:
        """Return a part, or all backwards."""
        one = self.known
        return Altered(self.volts[:, part], self.rate_hz, Known(one.path_m[part], one.judged[part], one.absent[part]))

    @property
    def time_s(self) -> FloatArray:
        """From the first sample, shape (n_samples,)."""
        return np.arange(self.volts.shape[1]) / self.rate_hz

    @property
    def swing_v(self) -> FloatArray:
        """Standard deviation of each channel, shape (2, 1)."""
        return np.asarray(self.volts.std(axis=1, keepdims=True))


def cut(one: Altered, rng: np.random.Generator) -> Altered:
    """A part from anywhere."""
    n = one.volts.shape[1]
    size = min(n, max(round(MIN_S * one.rate_hz), round(n * rng.uniform(0.05, 0.6))))
    first = int(rng.integers(0, n - size + 1))
    return one.sliced(slice(first, first + size))


def backwards(one: Altered, rng: np.random.Generator) -> Altered:
    """Time runs the other way: what drove away comes back."""
    return one.sliced(slice(None, None, -1))


def slower(one: Altered, rng: np.random.Generator) -> Altered:
    """Fewer samples a second, low-passed before; not below 3 kS/s, where the fastest walker would alias."""
    most = int(one.rate_hz // 3000.0)
    if most < 2:
        return one
    step = int(rng.integers(2, min(most, 10) + 1))
    taps = signal.firwin(16 * step + 1, 0.9 / step)
    volts = signal.oaconvolve(np.pad(one.volts, ((0, 0), (8 * step, 8 * step)), mode="edge"), taps[None], mode="valid")
    return replace(replace(one, volts=volts).sliced(slice(None, None, step)), rate_hz=one.rate_hz / step)


def noisier(one: Altered, rng: np.random.Generator) -> Altered:
    """White noise 5 to 25 dB below the whole signal."""
    level = one.swing_v * 10.0 ** (-rng.uniform(5.0, 25.0) / 20.0)
    return replace(one, volts=one.volts + level * rng.standard_normal(one.volts.shape))


def drifting(one: Altered, rng: np.random.Generator) -> Altered:
    """An offset and a slow wander as large as the signal."""
    t = one.time_s[None] / one.time_s[-1]
    turns, phase = rng.uniform(0.2, 1.5, (2, 1)), rng.uniform(0.0, 2.0 * np.pi, (2, 1))
    wander = rng.uniform(-2.0, 2.0, (2, 1)) + rng.uniform(0.0, 1.0, (2, 1)) * np.sin(2.0 * np.pi * turns * t + phase)
    return replace(one, volts=one.volts + one.swing_v * wander)


def humming(one: Altered, rng: np.random.Generator) -> Altered:
    """50 Hz and two harmonics, up to the signal's size."""
    t, volts = one.time_s[None], one.volts
    for order, most in ((1, 1.0), (3, 0.4), (5, 0.2)):
        size, phase = rng.uniform(0.0, most, (2, 1)), rng.uniform(0.0, 2.0 * np.pi, (2, 1))
        volts = volts + one.swing_v * size * np.sin(2.0 * np.pi * 50.0 * order * t + phase)
    return replace(one, volts=volts)


def mixed(one: Altered, rng: np.random.Generator) -> Altered:
    """Another mixer behind the first; both together stay within 0.6-1.6 and 40 degrees for all but the cars."""
    gain, angle = np.exp(rng.uniform(-0.2, 0.2)), np.radians(rng.uniform(-12.0, 12.0))
    i, q = one.volts
    return replace(one, volts=np.stack([i, gain * (q * np.cos(angle) + i * np.sin(angle))]))


def coarser(one: Altered, rng: np.random.Generator) -> Altered:
    """Six to nine bits over the range that is used."""
    step = np.ptp(one.volts) / 2.0 ** rng.integers(6, 10)
    return replace(one, volts=np.round(one.volts / step) * step)


def rested(one: Altered, rng: np.random.Generator) -> Altered:
    """It stands for a while where it then begins, with the noise of 1 % of the signal."""
    count = round(rng.uniform(0.2, 1.0) * one.rate_hz)
    held = one.volts[:, :1] + 0.01 * one.swing_v * rng.standard_normal((2, count))
    known = one.known
    still = np.full(count, known.judged[0])
    return Altered(
        np.concatenate([held, one.volts], axis=1),
        one.rate_hz,
        Known(
            np.concatenate([np.full(count, known.path_m[0]), known.path_m]),
            np.concatenate([still, known.judged]),
            np.concatenate([np.zeros(count, dtype=np.bool_), known.absent]),
        ),
    )


ALTERATIONS: tuple[Callable[[Altered, np.random.Generator], Altered], ...] = (
    cut,
    backwards,
    rested,  # before what is there at rest too
    slower,
    noisier,
    drifting,
    humming,
    mixed,
    coarser,
)


def altered(folder: Path, seed: int, number: int) -> tuple[str, str, Altered]:
    """Return the name of a recording, what was done to it, and what came out."""
    rng = np.random.default_rng([seed, number])
    name = str(rng.choice(list(SOURCES)))
    recording = read(folder, name)
    source = SOURCES[name]
    known = known_of(name, recording, 299_792_458.0 / source.frequency_hz)
    one = Altered(recording.volts(), recording.digitisation.sample_rate_hz, known)
    chosen = sorted(rng.choice(len(ALTERATIONS), size=int(rng.integers(1, 4)), replace=False))
    for place in chosen:
        one = ALTERATIONS[place](one, rng)
    return name, ", ".join(ALTERATIONS[place].__name__ for place in chosen), one


def seen_moving(one: Altered, source: Source) -> bool:
    """Whether one stretch in which the path is known is long enough and goes far enough to be found by anybody."""
    far_m = MIN_FRINGES * 299_792_458.0 / source.frequency_hz
    return any(
        b - a >= MIN_KNOWN_S * one.rate_hz and np.ptp(one.known.path_m[a:b]) >= far_m for a, b in runs(one.known.judged)
    )


def main() -> int:
    """Print a line for each and the sums; 1 where one is silently wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=int.from_bytes(os.urandom(2), "big"))
    parser.add_argument("--only", type=int, nargs="+")
    parser.add_argument("--correction", choices=CORRECTIONS, default="adaptive")
    parser.add_argument("--limit-s", type=float, default=60.0)
    options = parser.parse_args()
    folder = Path(os.environ.get("RADARGUI_TEST_DATA", ""))
    if not (folder / "radar-24ghz").is_dir():
        print("RADARGUI_TEST_DATA does not name the folder of the real recordings.", file=sys.stderr)
        return 2
    print(f"seed {options.seed}, {options.correction}")
    wrong, right, seconds = [], 0, []
    numbers = options.only or range(options.count)
    for number in numbers:
        name, how, one = altered(folder, options.seed, number)
        recording = Recording(name, np.ascontiguousarray(one.volts), Digitisation(iq_names(1), one.rate_hz))
        source = replace(SOURCES[name], gain_ratio=None, quadrature_error_deg=None)
        scene = scene_of(name, source, recording, one.known, options.correction)
        result, processor_s = timed(recording, scene.setup, options.limit_s)
        seconds.append(processor_s)
        if isinstance(result, str):
            print(f"{number:4} {name:14} {processor_s:6.1f} s  {how}: {result[:100]}", flush=True)
            continue
        verdict = judge(scene, result, processor_s)
        # "no motion" is wrong where a target is seen moving for long enough (rule in robust_scenes/scene.py)
        is_wrong = bool(verdict.wrong) and (
            source.truth == "still" or result.status == "ok" or seen_moving(one, source)
        )
        right += verdict.right
        wrong += [number] if is_wrong else []
        outcome = f"WRONG: {verdict.wrong}" if is_wrong else "right" if verdict.right else "not wrong"
        shares = f"valid {verdict.valid_share:.2f} right {verdict.right_share:.2f}"
        print(
            f"{number:4} {name:14} {processor_s:6.1f} s {verdict.status:9} {outcome}; {shares}; {how}; "
            f"{verdict.reason[:60]}",
            flush=True,
        )
    print(f"silently wrong {len(wrong)} of {len(numbers)} ({wrong}), right {right}; longest {max(seconds):.1f} s")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
