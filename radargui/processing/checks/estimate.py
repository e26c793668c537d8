"""What speaks against an estimate that fits its signals.

Method 6, Hardly known.
"""

from radargui.estimation.doubts import doubt, hardly_known, turned_polarisation
from radargui.model.finding import Finding, warn
from radargui.model.setup import Setup
from radargui.processing.checks.evidence import Evidence
from radargui.processing.measured_motion import MeasuredMotion


def polarization_off(evidence: Evidence) -> Finding | None:
    """The sphere scatters as it cannot, and no place of the setup explains it."""
    estimate, flights = evidence.motion.estimate, evidence.motion.flights
    if estimate is None or flights.is_explained:
        return None
    return turned_polarisation(estimate.chosen.solution)


def no_minimum(evidence: Evidence) -> Finding | None:
    """The rounds ended where the chosen model has no minimum."""
    estimate = evidence.motion.estimate
    return None if estimate is None or estimate.chosen.solution.settled else warn("no_minimum")


def poorly_determined(evidence: Evidence) -> Finding | None:
    """The search was ended; or, where nothing else is said, mirrors are missing or the place is hardly known."""
    estimate, flights = evidence.motion.estimate, evidence.motion.flights
    if estimate is None:
        return None
    if estimate.chosen.ended_early:
        return warn("search_ended_early")
    if flights.bent is not None or flights.cause is not None or polarization_off(evidence) is not None:
        return None
    unseen = doubt(estimate.chosen.solution, estimate.onset_s, evidence.setup, flights.bias_deviations)
    return unseen or hardly_known(estimate, evidence.setup, evidence.motion.changes)


def is_blamed(motion: MeasuredMotion, setup: Setup) -> bool:
    """Return whether what was measured is refused or bent, or says of setup or reflectors that they are wrong."""
    estimate, flights = motion.estimate, motion.flights
    if motion.rejected.any() or flights.bent is not None or flights.cause is not None:
        return True
    if estimate is None:
        return bool(motion.findings)
    solution = estimate.chosen.solution
    unseen = turned_polarisation(solution) or doubt(solution, estimate.onset_s, setup, flights.bias_deviations)
    return (unseen or hardly_known(estimate, setup, motion.changes)) is not None


def gained_by_polarization(motion: MeasuredMotion) -> float:
    """Return by how much chi-square is less where the polarisation that is blamed is freed; 0 where none is."""
    turned = None if motion.estimate is None else turned_polarisation(motion.estimate.chosen.solution)
    # d^2 / (s^2 - u^2) is what a Gaussian prior of deviation s costs that is missed by d with u left
    return 0.0 if turned is None else float(turned.facts["deviations"]) ** 2
