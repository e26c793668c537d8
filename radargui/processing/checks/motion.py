"""What is said of the motion: how it was found, and where it begins."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from radargui.model.finding import Finding, warn
from radargui.processing.checks.evidence import Evidence


def on_the_way(evidence: Evidence) -> Iterator[Finding]:
    """Yield what was found while it was measured: echoes lost, a correction that does not stand, a rest that drifts."""
    return (_of_all(one, evidence.part.receivers) for one in evidence.motion.findings)


def _of_all(finding: Finding, receivers: Sequence[int]) -> Finding:
    """Return what is found of one of some receivers with its number among all."""
    facts = {name: _of_all(one, receivers) if isinstance(one, Finding) else one for name, one in finding.facts.items()}
    receiver = None if finding.receiver is None else receivers[finding.receiver - 1] + 1
    return replace(finding, receiver=receiver, facts=facts)


def further_motions(evidence: Evidence) -> Iterator[Finding]:
    """Yield each other motion of a record of which one drop is measured, from its rest."""
    for begin_s, end_s in evidence.part.further:
        yield warn("further_motion", begin_s=begin_s, end_s=end_s)


def plane_geometry(evidence: Evidence) -> Finding | None:
    """The antennas were taken as infinitely far away."""
    track = evidence.measured
    return warn("plane_geometry") if track is not None and track.geometry == "plane" else None


def no_position(evidence: Evidence) -> Finding | None:
    """Path lengths are known, and tell no position."""
    known, track = evidence.motion.paths.valid.all(axis=0), evidence.motion.track
    if evidence.is_refused or track is None or not known.any():
        return None
    return None if (known & np.isfinite(track.u_position_m)).any() else warn("no_position")


def no_rest(evidence: Evidence) -> Finding | None:
    """It begins without a rest."""
    if evidence.track is None or evidence.segment.has_rest:
        return None
    # with a gap before it even the release is no assumption that one could make
    return warn("no_rest_after_gap" if evidence.part.begins_after_gap else "no_rest")
