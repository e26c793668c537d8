"""A law of one's own for e against the impact speed: a line."""

from __future__ import annotations

from radargui.restitution.speed_models import SpeedModel

LINE = SpeedModel(
    title="line",
    equation="e = e0 - b v",
    source="",
    parameters=(("e0", ""), ("b", "s/m")),
    e=lambda v, e0, b: e0 - b * v,
    start=lambda e: (e, 0.0),
)
