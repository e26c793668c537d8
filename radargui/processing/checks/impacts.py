"""What the impacts say: coefficients that disagree, walls met with the floor, a floor that moves or gives way."""

from collections.abc import Sequence

from radargui.model.finding import Finding
from radargui.processing.checks.evidence import Evidence
from radargui.restitution.cross_check import disagreements, floor_and_wall
from radargui.restitution.stopped_fall import braked_without_impact


def coefficients_disagree(evidence: Evidence) -> Sequence[Finding]:
    """Speeds, duration and height of a flight give different coefficients."""
    return disagreements(evidence.bounces)


def wall_at_impact(evidence: Evidence) -> Sequence[Finding]:
    """A wall was met together with the floor."""
    return floor_and_wall(evidence.bounces)


def floor(evidence: Evidence) -> Sequence[Finding]:
    """The impacts do not lie in one plane, or take their time: found while they were judged by it."""
    return evidence.floor


def no_impact(evidence: Evidence) -> Finding | None:
    """The fall ends on some way, not by an impact."""
    return None if evidence.measured is None else braked_without_impact(evidence.bounces, evidence.measured)
