"""All that can be said of a run, in the order in which it is said."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from radargui.correction.quality import WEAK
from radargui.model.finding import Finding
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.processing.checks import motion, receivers, setup
from radargui.processing.checks.evidence import Evidence

Found = Finding | Iterable[Finding] | None
Check = Callable[[Evidence], Found]

OF_RECORDING: tuple[Callable[[Recording], Found], ...] = (
    receivers.excerpt,
    receivers.no_numbers,
    receivers.samples_lost,
)
BEFORE: tuple[Check, ...] = (
    setup.skew_too_long,
    receivers.clock_wrong,
    receivers.dips_left_out,
)
AFTER: tuple[Check, ...] = (
    motion.on_the_way,
    motion.further_motions,
    receivers.left_out,
    motion.plane_geometry,
    motion.no_position,
    motion.no_rest,
    motion.g_impossible,
    motion.falls_otherwise,
    setup.floor_elsewhere,
    motion.coefficients_disagree,
    motion.wall_at_impact,
    motion.floor,
    motion.no_impact,
    motion.braked,
    receivers.usable,
)


def checks_of(evidence: Evidence) -> tuple[Check, ...]:
    """Return the checks of a run, in order."""
    if evidence.motion.estimate is None:
        return (*BEFORE, motion.setup_contradicted, *AFTER)
    # only who asks for an estimate pays for loading what it is judged by
    from radargui.processing.checks import estimate

    joint = (
        estimate.polarization_off,
        motion.setup_contradicted,
        motion.flights_bend,
        estimate.poorly_determined,
        estimate.no_minimum,
    )
    return (*BEFORE, *joint, *AFTER)


def findings_before(samples: Recording, stated: Setup) -> tuple[Finding, ...]:
    """Return what is said of samples and setup before anything is measured."""
    found = [*(check(samples) for check in OF_RECORDING), *(check(stated) for check in setup.OF_SETUP)]
    return tuple(_flat(found))


def findings_of(evidence: Evidence) -> tuple[Finding, ...]:
    """Return all that is said of a measured run; what refuses it first."""
    before = findings_before(evidence.recording, evidence.part.whole_setup)
    found = [*before, *_flat(check(evidence) for check in checks_of(evidence))]
    # what noise explains is not blamed on reflectors or the floor first: a stable order
    found.sort(key=lambda one: (one.severity != "refuse", one.code != WEAK))
    return (*receivers.rejected(evidence), *found)


def _flat(found: Iterable[Found]) -> Iterator[Finding]:
    for one in found:
        if isinstance(one, Finding):
            yield one
        elif one is not None:
            yield from one
