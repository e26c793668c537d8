"""Setups that state the laboratory wrongly: each says what its name says, and the world stays that of the drop."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from benchmarks.world.draw import draw
from benchmarks.world.mistaken.draw import MISTAKEN, mistaken
from benchmarks.world.scene import Scene, make_record
from pydantic import ValidationError

from radargui.model.setup import Setup

QUICK = {"rate_hz": 2000.0, "skew_s": 5e-6, "walls": 0, "floor": 0.0, "skew_in_file": True}
EACH = [f"{name}/{variant}" for name, (_, variants) in MISTAKEN.items() for variant in variants]
REFUSED = {"polarization/receiver", "polarization/transmitter", "skew/sample"}
"""Those that a setup may not say of some drops."""
SEEDS = range(4)


@cache
def told_wrongly(which: str, seed: int = 3, strength: float | None = 1.0) -> Scene:
    return mistaken(which, seed, strength=strength, **QUICK)


@cache
def as_it_is(seed: int = 3) -> Scene:
    return draw(seed, **QUICK)


@cache
def true_codes(seed: int) -> np.ndarray:
    return make_record(as_it_is(seed)).recording.raw


def told(which: str, seed: int = 3, strength: float | None = 1.0) -> Setup:
    return told_wrongly(which, seed, strength).setup


def true(seed: int = 3) -> Setup:
    return as_it_is(seed).setup


def changed(which: str, seed: int = 3, strength: float | None = 1.0) -> dict[str, int]:
    """How many entries of each table differ from the truth, by the table's name."""
    mine, right = (one.model_dump(exclude_unset=True) for one in (told(which, seed, strength), true(seed)))
    tables = sorted(set(mine) | set(right))
    return {name: _different(mine.get(name), right.get(name)) for name in tables if mine.get(name) != right.get(name)}


def _different(mine: object, right: object) -> int:
    if isinstance(mine, tuple) and isinstance(right, tuple):
        return sum(m != r for m, r in zip(mine, right, strict=False)) + abs(len(mine) - len(right))
    return 1


@pytest.mark.parametrize("which", EACH)
def test_the_world_stays_true_and_what_is_told_of_it_is_wrong(which: str) -> None:
    try:
        scene = told_wrongly(which)
    except ValidationError:
        assert which in REFUSED
        return
    plain = as_it_is()
    assert scene.is_mistaken
    assert scene.name == f"{which}-3"
    assert (scene.body, scene.mixers, scene.noise, scene.converter) == (
        plain.body, plain.mixers, plain.noise, plain.converter,
    )  # fmt: skip
    time_s = np.linspace(0.0, scene.drop.duration_s, 50)
    np.testing.assert_array_equal(scene.drop.position(time_s), plain.drop.position(time_s))
    np.testing.assert_array_equal(
        scene.room.received(0, scene.drop.position(time_s)), plain.room.received(0, plain.drop.position(time_s))
    )
    assert scene.setup != plain.setup or scene.disturbances or which in ("floor/level", "skew/none")


@pytest.mark.parametrize("which", ["ghost", "tilt/waves"])
def test_what_is_not_there_is_refused_by_name(which: str) -> None:
    with pytest.raises(ValueError, match="no such"):
        mistaken(which, 0)
    with pytest.raises(ValueError, match="strength"):
        mistaken("tilt", 0, strength=1.5)


@pytest.mark.parametrize(
    ("which", "tables"),
    [
        ("receivers/exchanged", {"receiver": 2}),
        ("receivers/rotated", {"receiver": 3}),
        ("receivers/transmitter", {"receiver": 1, "transmitter": 1}),
        ("azimuth/mirrored", {"receiver": 1}),
        ("azimuth/clockwise", {"receiver": 3}),
        ("azimuth/one", {"receiver": 1}),
        ("azimuth/turned", {"receiver": 3}),
        ("tilt/one", {"receiver": 1}),
        ("tilt/horizon", {"receiver": 3}),
        ("distance/receiver", {"receiver": 1}),
        ("distance/transmitter", {"transmitter": 1}),
        ("distance/all", {"receiver": 3, "transmitter": 1}),
        ("count/forgotten", {"receiver": 3}),
        ("count/copy", {"receiver": 1}),
        ("frequency/off", {"radar": 1}),
        ("clock/off", {"daq": 1}),
        ("sphere/radius", {"tracer": 1}),
        ("release/height", {"tracer": 1}),
        ("floor/tilted", {"floor": 1}),
    ],
)
def test_only_what_is_mistaken_changes(which: str, tables: dict[str, int]) -> None:
    found = changed(which)
    if which == "count/forgotten":  # those behind it move up
        assert set(found) == {"receiver"}
    else:
        assert found == tables


def test_a_receiver_at_the_transmitters_place_keeps_the_place_of_each_antenna() -> None:
    def places(setup: Setup) -> list[tuple[float, ...]]:
        out = [setup.transmitter.place_m]
        for one in setup.receiver:
            tilt, azimuth = np.radians(one.tilt_deg), np.radians(one.azimuth_deg)
            way = (np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt))
            out.append(tuple(one.distance_m * np.array(way)))
        return sorted(out)

    mine, right = told("receivers/transmitter"), true()
    np.testing.assert_allclose(places(mine), places(right), atol=1e-12)
    assert mine.transmitter.position_m is not None


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("which", "sizes"),
    [
        ("distance/all", (0.1, 0.1)),
        ("distance/centimetres", (99.0, 99.0)),
        ("distance/feet", (2.2808, 2.2809)),
        ("frequency/off", (0.05, 0.05)),
        ("clock/off", (0.02, 0.02)),
        ("clock/half", (0.5, 0.5)),
        ("clock/double", (1.0, 1.0)),
        ("sphere/radius", (0.5, 0.5)),
        ("sphere/double", (1.0, 1.0)),
    ],
)
def test_the_mistake_has_its_size(which: str, sizes: tuple[float, float], seed: int) -> None:
    def value(setup: Setup) -> float:
        name = which.split("/")[0]
        return {
            "distance": setup.transmitter.distance_m or 0.0,
            "frequency": setup.radar.frequency_hz,
            "clock": setup.daq.rate_hz,
            "sphere": setup.tracer.diameter_m,
        }[name]

    off = abs(value(told(which, seed)) / value(true(seed)) - 1.0)
    assert sizes[0] - 1e-9 <= off <= sizes[1] + 1e-9


def rows(which: str, seed: int = 3) -> tuple[Scene, np.ndarray, np.ndarray]:
    """The drop and its codes, as they are called and as they are."""
    scene = told_wrongly(which, seed)
    return scene, make_record(scene).recording.raw, true_codes(seed)


def test_wires_bring_the_channels_of_others() -> None:
    _, antennas, right = rows("wires/antennas")
    moved = [k for k in range(6) if np.any(antennas[k] != right[k])]
    assert len(moved) == 4
    np.testing.assert_array_equal(antennas[moved[:2]], right[moved[2:]])
    _, pair, _ = rows("wires/pair")
    first, second = (k for k in range(6) if np.any(pair[k] != right[k]))
    assert (first % 2, second) == (0, first + 1)
    np.testing.assert_array_equal(pair[[first, second]], right[[second, first]])
    _, neighbours, _ = rows("wires/next")
    first, second = (k for k in range(6) if np.any(neighbours[k] != right[k]))
    assert (first % 2, second) == (1, first + 1)
    _, shifted, _ = rows("wires/shifted")
    np.testing.assert_array_equal(shifted, np.roll(right, -1, axis=0))
    _, inverted, _ = rows("wires/inverted")
    (which,) = (k for k in range(6) if np.any(inverted[k] != right[k]))
    np.testing.assert_array_equal(inverted[which], -right[which])
    _, half, _ = rows("wires/half")
    np.testing.assert_allclose(half, right / 2.0, atol=0.51)


def test_a_receiver_is_forgotten_absent_imagined_or_there_twice() -> None:
    shapes = {}
    for variant in ("forgotten", "absent", "imagined", "copy"):
        scene, raw, right = rows(f"count/{variant}")
        shapes[variant] = (scene.setup.n_receivers, raw.shape[0])
        if variant == "copy":
            twin = scene.setup.receiver.index(scene.setup.receiver[3])
            assert twin < 3
            np.testing.assert_array_equal(raw[6:], right[2 * twin : 2 * twin + 2])
            np.testing.assert_array_equal(raw[:6], right)
        if variant == "absent":
            kept = [true().receiver.index(one) for one in scene.setup.receiver]
            np.testing.assert_array_equal(raw, right[[2 * k + part for k in kept for part in range(2)]])
    assert shapes == {"forgotten": (2, 6), "absent": (2, 4), "imagined": (4, 6), "copy": (4, 8)}


def test_the_clock_of_the_file_is_the_one_that_is_told_and_skew_is_then_the_setups_alone() -> None:
    record = make_record(mistaken("clock/double", 3, **QUICK))
    assert record.recording.digitisation.sample_rate_hz == 4000.0
    for variant, skew_s in (("none", 0.0), ("double", 1e-5)):
        record = make_record(mistaken(f"skew/{variant}", 3, **QUICK))
        assert record.recording.digitisation.channel_skew_s is None
        assert record.scene.setup.daq.channel_skew_s == pytest.approx(skew_s)
