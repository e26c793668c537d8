"""Populations of what goes wrong, of what does not fall, of one receiver, of what is no motion at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from benchmarks.world.broken.drops import drop_setup
from benchmarks.world.broken.garbage import GARBAGE, make_garbage
from benchmarks.world.disturbed.draw import DISTURBED
from benchmarks.world.disturbed.strength import Case
from benchmarks.world.draw import MOTIONS, OPTIONS as COURSE_OPTIONS, draw
from benchmarks.world.drawn_drop import OPTIONS, WAVENUMBER_RAD_M, WEAK_DB, DrawnDrop, draw_drop
from benchmarks.world.draws import Draws
from benchmarks.world.generic.draw import draw_scene
from benchmarks.world.generic.motion import GRAVITY_M_S2
from benchmarks.world.generic.scene import make_record as make_generic
from benchmarks.world.mistaken.draw import MISTAKEN, filled_in
from benchmarks.world.one_receiver.generator import KINDS as ONE_RECEIVER, make_scene, scene_kind
from benchmarks.world.population import Expected, Key, PopulationRecord, PopulationScene, causes_of, names, record
from benchmarks.world.scene import make_record
from benchmarks.world.told import EXACT, Tables, Uncertainties, draw_uncertainties, told
from numpy.typing import NDArray

Array = NDArray[np.float64]

MISTAKES = tuple(f"{name}/{variant}" for name, (_, variants) in MISTAKEN.items() for variant in variants)
DISTURBANCES = tuple(f"{name}/{variant}" for name, (_, variants) in DISTURBED.items() for variant in variants)
OTHER_MOTIONS = tuple(one for one in MOTIONS if one != "drop")

_MISTAKEN_CAUSES = {
    "receivers": {"antennas", "wiring"}, "wires": {"wiring"}, "sign": {"sign", "wiring"}, "azimuth": {"antennas"},
    "tilt": {"antennas"}, "distance": {"antennas"}, "polarization": {"polarisation"}, "count": {"antennas", "wiring"},
    "frequency": {"wavelength"}, "air": {"wavelength"}, "clock": {"clock"}, "skew": {"skew"},
    "sphere": {"sphere", "drag"}, "release": {"release"}, "floor": {"floor", "tilt"},
}  # fmt: skip
_DISTURBED_CAUSES = {
    "mains": {"hum"}, "dip": {"dip"}, "gap": {"gap"}, "steps/contact": {"contact"}, "steps/lost": {"contact"},
    "steps/jump": {"wavelength", "offsets"}, "steps/drift": {"wavelength", "offsets"}, "steps/gain": {"offsets"},
    "steps/supply": {"offsets"}, "hand": {"motion"}, "person": {"motion"}, "fan": {"motion"}, "second": {"motion"},
    "swing": {"motion"}, "shock": {"antennas", "motion"}, "steps/slip": {"gap", "clock"},
}  # fmt: skip
_LEAVES_ENOUGH = ("dip", "gap", "mains")
"""Disturbances that leave a drop that can be processed; the rest may be refused."""
_ONE_RECEIVER_CAUSES = {
    "hum": {"hum"}, "only hum": {"hum"}, "tone": {"disturbance"}, "only tone": {"disturbance"}, "fading": {"dip"},
    "second target": {"motion"}, "clipped": {"offsets"}, "mixture": {"hum", "disturbance", "dip", "motion"},
}  # fmt: skip


def mistaken(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return drops of the first kind whose setup states something wrongly; the mistakes take turns.

    Held beside a drop's values: `which` of `MISTAKES`, and its `strength`, 0 to 1.
    """
    value = Draws(key, {"exact": True, "told": True, **held}, (*OPTIONS, "which", "strength"))
    which = str(value("which", lambda _: MISTAKES[key[1] % len(MISTAKES)]))
    if which.startswith("skew"):
        # where all channels are sampled at once the skew cannot be mistaken
        value.held.setdefault("multiplexed", True)
    mistake, _, variant = which.partition("/")
    u = _uncertainties(value)

    def scene(number: int, named: str) -> PopulationScene:
        drawn = draw_drop(value, u, named, number)
        tables = told(drawn.true, u, value, WAVENUMBER_RAD_M)
        strength = value.between("strength", 0.0, 1.0)
        sheet = filled_in(drawn.world, tables, mistake, variant, value.rng(f"mistaken {mistake}"), strength)
        causes = _MISTAKEN_CAUSES[mistake] | ({"sphere"} if which == "polarization/left-out" else set())
        world = replace(
            drawn.world,
            skew_in_file=sheet.skew_in_file,
            disturbances=() if sheet.wiring is None else (sheet.wiring,),
        )
        tables = sheet.tables
        receivers = sorted(sheet.chosen[1:]) if which in ("count/forgotten", "count/absent") else None
        receivers = [*sorted(sheet.chosen), sheet.chosen[0]] if which == "count/copy" else receivers

        def made() -> PopulationRecord:
            found = record(world, tables["daq"]["rate_hz"], "either")
            if receivers is None:
                return found
            # too few receivers tell no place
            place = found.position_m if len(receivers) > len(world.mixers) else None
            return replace(found, position_m=place, path_m=found.path_m[receivers])

        return _scene("mistaken", drawn, u, tables, causes, {"which": which, "strength": strength}, made)

    return tuple(scene(*one) for one in enumerate(names(name, drops)))


def disturbed(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return drops of the first kind with something else in the room or in the front end; disturbances take turns.

    Held beside a drop's values: `which` of `DISTURBANCES`, and its `strength`, 0 to 1.
    """
    value = Draws(key, {"exact": True, **held}, (*OPTIONS, "which", "strength"))
    which = str(value("which", lambda _: DISTURBANCES[key[1] % len(DISTURBANCES)]))
    disturbance, _, variant = which.partition("/")
    u = _uncertainties(value)

    def scene(number: int, named: str) -> PopulationScene:
        drawn = draw_drop(value, u, named, number)
        tables = told(drawn.true, u, value, WAVENUMBER_RAD_M)
        strength = value.between("strength", 0.0, 1.0)
        case = Case(drawn.world, value.drop(number).rng(f"disturbed {disturbance}"), strength)
        world = replace(drawn.world, disturbances=DISTURBED[disturbance][0](case, variant))
        causes = {"disturbance"} | _DISTURBED_CAUSES.get(which, _DISTURBED_CAUSES.get(disturbance, set()))
        facts = {"which": which, "strength": strength}
        rate_hz = tables["daq"]["rate_hz"]
        expected: Expected = "ok" if disturbance in _LEAVES_ENOUGH else "either"
        return _scene("disturbed", drawn, u, tables, causes, facts, lambda: record(world, rate_hz, expected))

    return tuple(scene(*one) for one in enumerate(names(name, drops)))


def _uncertainties(value: Draws) -> Uncertainties:
    return EXACT if value.happens("exact", 1.0) else draw_uncertainties(value)


def _scene(
    kind: str, drawn: DrawnDrop, u: Uncertainties, tables: Tables, causes: set[str], facts: dict[str, Any],
    made: Callable[[], PopulationRecord],
) -> PopulationScene:  # fmt: skip
    return PopulationScene(
        drawn.world.name, kind, tables, drawn.causes | causes_of(u, drawn.true) | frozenset(causes),
        {**drawn.facts, **facts, "exact": u == EXACT, "true": drawn.true}, made,
    )  # fmt: skip


def motions(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return a motion that is no plain drop; the motions take turns.

    Held beside the values of `draw.OPTIONS`: `which` of `OTHER_MOTIONS`, and `exact`.
    """
    _one_drop("motions", drops)
    value = Draws(key, held, (*COURSE_OPTIONS, "which", "exact"))
    which = str(value("which", lambda _: OTHER_MOTIONS[key[1] % len(OTHER_MOTIONS)]))
    is_exact = value.happens("exact", 0.4)
    values = {one: held[one] for one in held if one not in ("which", "exact")}
    scene = draw(_number(key), "exact" if is_exact else "drawn", motion=which, **values)
    there = {
        "floor": bool(scene.room.mirrors), "walls": len(scene.room.mirrors) > 1, "tilt": bool(scene.facts["tilt"]),
        "crosstalk": scene.converter.crosstalk > 0.0, "signal": scene.snr_db < WEAK_DB, "motion": True,
        "release": which == "loose",
    }  # fmt: skip
    causes = frozenset(one for one, is_there in there.items() if is_there)
    if not is_exact:
        causes |= {"antennas", "release", "sphere", "polarisation", "clock", "wavelength", "tilt"}
    setup = scene.setup.model_dump(mode="json", by_alias=True, exclude_unset=True)

    def made() -> PopulationRecord:
        found = make_record(replace(scene, name=name))
        sides = tuple(
            (float(one), float("nan"), float("nan"), float("nan"), False)
            for one in np.asarray(scene.facts.get("side_impacts", ())) + scene.drop.start_s
        )
        floors = tuple((one.time_s, one.before_m_s, one.after_m_s, one.e, True) for one in scene.drop.impacts)
        return PopulationRecord(
            found.recording, found.truth.position_m, found.truth.path_m, tuple(sorted(floors + sides)),
            scene.body.acceleration_m_s2 if scene.falls else None, scene.drop.start_s, "ok",
        )  # fmt: skip

    facts = {**scene.facts, "which": which, "exact": is_exact, "snr_db": scene.snr_db}
    return (PopulationScene(name, "motions", setup, causes, facts, made),)


def one_receiver(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return a target before one radar with one receiver: cars, plates, walkers; the kinds take turns.

    Held: `which` of the kinds.
    """
    _one_drop("one-receiver", drops)
    which = str(Draws(key, held, ("which",))("which", lambda _: scene_kind(key[1])))
    if which not in ONE_RECEIVER:
        raise ValueError(f"no such kind of one receiver: {which}; there are {', '.join(ONE_RECEIVER)}")
    scene = make_scene(key[0], key[1], which)
    setup = scene.setup.model_dump(mode="json", by_alias=True, exclude_unset=True)
    causes = _ONE_RECEIVER_CAUSES.get(which, set()) | (set() if scene.knowable.all() else {"signal"})
    recording = replace(scene.recording, name=name)
    path_m = np.array([scene.echoes[0].path_m]) if scene.echoes else np.zeros((1, recording.n_samples))
    moved = np.flatnonzero(np.abs(path_m[0] - path_m[0, 0]) > 1e-5)
    start_s = moved[0] / recording.digitisation.sample_rate_hz if moved.size else 0.0
    made = PopulationRecord(recording, None, path_m, (), None, float(start_s), scene.expected)
    facts = {"which": which, "expected": scene.expected, "knowable": float(scene.knowable.mean())}
    return (PopulationScene(name, "one-receiver", setup, frozenset(causes), facts, lambda: made),)


def garbage(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return six channels in which there is no sphere; the kinds take turns. Held: `which` of them."""
    _one_drop("garbage", drops)
    which = str(Draws(key, held, ("which",))("which", lambda _: tuple(GARBAGE)[key[1] % len(GARBAGE)]))
    if which not in GARBAGE:
        raise ValueError(f"no such garbage: {which}; there are {', '.join(GARBAGE)}")
    setup = drop_setup(3).model_dump(mode="json", by_alias=True, exclude_unset=True)

    def made() -> PopulationRecord:
        recording = replace(make_garbage(_number(key), which), name=name)
        return PopulationRecord(recording, None, np.zeros((3, recording.n_samples)), (), None, 0.0, "refused")

    causes = frozenset({"wiring", "signal", "disturbance", "motion"})
    return (PopulationScene(name, "garbage", setup, causes, {"which": which}, made),)


def generic(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return a motion before receivers whose bias and amplitude are smooth functions of position, whatever makes them.

    Held: `motion`, and the values of `scenes.draw_scene`.
    """
    _one_drop("generic", drops)
    scene = draw_scene(_number(key), "generic", **held)
    setup = scene.setup.model_dump(mode="json", by_alias=True, exclude_unset=True)

    def made() -> PopulationRecord:
        found, motion = make_generic(scene), scene.motion
        speeds = [(one.time_s, -float(one.before_m_s[2]), float(one.after_m_s[2])) for one in motion.impacts]
        impacts = tuple((time_s, before, after, after / before, True) for time_s, before, after in speeds)
        gravity = GRAVITY_M_S2 if any(one in scene.name for one in ("drop", "bed")) else None
        return PopulationRecord(
            replace(found.recording, name=name), found.truth.position_m, found.truth.path_m, impacts, gravity,
            motion.motion_start_s, "ok",
        )  # fmt: skip

    causes = frozenset({"offsets", "floor", "walls"} | ({"signal"} if scene.snr_db < WEAK_DB else set()))
    facts = {"snr_db": scene.snr_db, "rate_hz": scene.rate_hz, "skew_s": scene.skew_s, "motion": scene.name}
    return (PopulationScene(name, "generic", setup, causes, facts, made),)


def _one_drop(kind: str, drops: int) -> None:
    if drops != 1:
        raise ValueError(f"{kind} has no sessions of drops")


def _number(key: Key) -> int:
    """Return one number for generators that start from one."""
    return int(np.random.SeedSequence(key).generate_state(1, np.uint64)[0])
