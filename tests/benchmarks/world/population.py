"""Scenes of populations: drops of an ordinary laboratory drawn anew for each, and what its setup says of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from benchmarks.world.drawn_drop import OPTIONS, WAVENUMBER_RAD_M, DrawnDrop, draw_drop
from benchmarks.world.draws import Draws
from benchmarks.world.drop import Drop
from benchmarks.world.effects import EFFECT_OPTIONS, Effects, draw_effects
from benchmarks.world.scene import World, record_of
from benchmarks.world.told import EXACT, Tables, Uncertainties, draw_uncertainties, told
from numpy.typing import NDArray

from radargui.model.recording import Recording

Array = NDArray[np.float64]
Expected = Literal["ok", "refused", "either"]
Key = tuple[int, ...]


@dataclass(frozen=True)
class PopulationRecord:
    """What a program may read, and the truth.

    Attributes
    ----------
    recording
        To be processed.
    position_m
        Of the sphere's centre at the samples of channel 0, shape (3, n); None where there is no one sphere.
    path_m
        Transmitter, sphere, receiver, shape (n_receivers, n).
    impacts
        Time in s, speeds before and after along the normal in m/s, e, and whether on a floor.
    gravity_m_s2
        True acceleration of a fall; None where nothing falls.
    start_s
        When the motion begins.
    expected
        What a program should say.
    drop
        Of a drop: its motion at any time, and the velocities at its impacts.
    """

    recording: Recording
    position_m: Array | None
    path_m: Array
    impacts: tuple[tuple[float, float, float, float, bool], ...]
    gravity_m_s2: float | None
    start_s: float
    expected: Expected
    drop: Drop | None = None


@dataclass(frozen=True)
class PopulationScene:
    """A drawn scene.

    Attributes
    ----------
    name, kind
        Of the scene.
    setup
        As a setup file would hold it.
    causes
        Names of what is there and not exactly stated, which a finding may rightly blame.
    facts
        What was drawn.
    """

    name: str
    kind: str
    setup: Mapping[str, Any]
    causes: frozenset[str]
    facts: Mapping[str, Any]
    made: Callable[[], PopulationRecord] = field(repr=False)

    def record(self) -> PopulationRecord:
        """Return the record: computed anew each time."""
        return self.made()


def modelled(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return drops of a laboratory in which everything is what an estimate can know of."""
    value = Draws(key, held, (*OPTIONS, "exchange"))
    u = draw_statement(value)
    effects = Effects(exchange=bool(value("exchange", lambda _: False)))
    return tuple(
        drop_scene("modelled", value, u, draw_drop(value, u, named, number, effects))
        for number, named in enumerate(names(name, drops))
    )


def laboratory(key: Key, name: str, drops: int, held: Mapping[str, Any]) -> tuple[PopulationScene, ...]:
    """Return drops of a laboratory with what else laboratories have: half of them state it, as far as a setup can."""
    value = Draws(key, held, (*OPTIONS, *EFFECT_OPTIONS))
    u, effects = draw_statement(value), draw_effects(value)
    return tuple(
        drop_scene("laboratory", value, u, draw_drop(value, u, named, number, effects))
        for number, named in enumerate(names(name, drops))
    )


def draw_statement(value: Draws) -> Uncertainties:
    """Return by how much the setup is off: nothing at all in two of five laboratories."""
    return EXACT if value.happens("exact", 0.4) else draw_uncertainties(value)


def names(name: str, drops: int) -> tuple[str, ...]:
    """Return the names of a session's drops."""
    return (name, *(f"{name}-{number}" for number in range(1, drops)))


def drop_scene(kind: str, value: Draws, u: Uncertainties, drawn: DrawnDrop) -> PopulationScene:
    """Return the scene of a drop with a setup that is off by its uncertainties."""
    setup = told(drawn.true, u, value, WAVENUMBER_RAD_M)
    setup = drawn.effects.state(setup, drawn.world.room, drawn.share, value, is_exact=u == EXACT)
    stated = {"exact": u == EXACT, **{f"u_{key}": size for key, size in vars(u).items()}}
    return PopulationScene(
        drawn.world.name,
        kind,
        setup,
        drawn.causes | causes_of(u, drawn.true) | drawn.effects.causes,
        {**drawn.facts, **drawn.effects.facts, **stated, "true": drawn.true},
        lambda: record(drawn.world, setup["daq"]["rate_hz"]),
    )


def causes_of(u: Uncertainties, true: Tables) -> frozenset[str]:
    """Return what a setup with these uncertainties states inexactly or not at all."""
    found = set() if u == EXACT else {"antennas", "release", "polarisation", "sphere", "clock"}
    if u != EXACT and "site" in true:
        found |= {"gravity"}
    if "polarization_deg" not in true["transmitter"]:
        # the sphere counts as a point then
        found |= {"polarisation", "sphere"}
    return frozenset(found if "density_kg_m3" in true["tracer"] else {*found, "drag"})


def record(world: World, stated_rate_hz: float, expected: Expected = "ok") -> PopulationRecord:
    """Return the record of a world in which a sphere falls, and its truth."""
    recording, truth = record_of(world, stated_rate_hz)
    return PopulationRecord(
        recording,
        truth.position_m,
        truth.path_m,
        tuple((one.time_s, one.before_m_s, one.after_m_s, one.e, True) for one in world.drop.impacts),
        world.body.acceleration_m_s2,
        world.drop.start_s,
        expected,
        world.drop,
    )
