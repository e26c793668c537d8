"""What a finding blames: causes by code where a version has codes, else by the sentences that it says.

A finding may leave open which of several causes it is, and names them all then; one that only says that something is
off (a misfit, a widened uncertainty) names none.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

Causes = frozenset[str]


def _set(names: str) -> Causes:
    return frozenset(names.split())


REFLECTORS = _set("floor walls plate container holder")
"""Whatever sends the wave back beside the sphere."""
STATED = _set("antennas horns release wavelength polarisation sphere clock gravity tilt wiring sign")
"""Whatever a setup can say wrongly."""
CHANGES = _set("disturbance offsets dip contact hum gap")
"""Whatever happens in the room or the front ends while the sphere moves."""

NOTHING: Causes = frozenset()
_BENT = {"reflector": REFLECTORS | STATED, "setup": STATED, "change": REFLECTORS | STATED | CHANGES}
"""What bent flights are guessed to come from."""
_CODES: Mapping[Causes, str] = {
    NOTHING: """
        stored excerpt_processed results_damaged off_circle signal_not_described few_samples_valid residuals_above_noise
        no_doppler_line nothing_moves tones_only joint_stopped joint_not_used flights_stand entry_pulled
        joint_rejected estimate_impossible needs_three_receivers
        joint_needs_three_receivers misfit_too_large search_too_long no_solution front_ends_differ gain_changed
        quadrature_changed plane_geometry flights_not_fitted flights_bend flights_unsteady setup_contradicted
        receiver_left_out dip_left_out arc_too_short no_flights flights_not_begun flights_lost rebound_unexplained
        flight_lost flights_explain_little flights_need_three_receivers flights_end_early""",
    _set("signal"): "noise_too_high signal_low",
    _set("signal offsets"): "samples_clipped some_samples_clipped",
    _set("signal contact"): "samples_no_numbers channels_never_change",
    _set("signal motion"): "motion_below_fringe few_extremes fringe_unsure",
    _set("signal dip contact motion"): "echo_rarely_followed path_begins_late echo_lost",
    _set("wiring contact"): "antenna_off channel_off channel_dead channel_open",
    _set("wiring"): """
        signal_on_both cable_on_both pair_of_two_motions pair_not_in_quadrature pair_without_phase mixer_impossible""",
    _set("wiring sign"): "phase_reversed phase_sign_wrong receivers_backwards",
    _set("walls offsets") | STATED: "flights_misfit",
    REFLECTORS | _set("horns"): "strong_floor",
    _set("wiring antennas clock sphere disturbance signal"): "no_single_body",
    _set("contact dip disturbance"): "noise_in_bursts",
    _set("contact dip disturbance gap"): "dip_unexplained",
    _set("disturbance harmonics hum floor walls plate"): "several_frequencies",
    _set("hum disturbance"): "tones_in_receiver",
    _set("offsets hum disturbance"): "phase_led_astray",
    REFLECTORS | _set("offsets disturbance harmonics"): "echo_of_another",
    REFLECTORS: "search_ended_early no_minimum",
    REFLECTORS | _set("signal offsets"): "wall_unseen",
    REFLECTORS | _set("motion"): "mirror_too_strong",
    REFLECTORS | _set("signal motion polarisation sphere"): "position_hardly_known",
    _set("gap"): "samples_lost",
    _set("gap motion"): "no_rest_after_gap",
    _set("motion"): """
        no_rest starts_in_motion further_motion floor_gives_way floor_moves fall_ends_softly fall_without_rebound
        landed_dead""",
    _set("motion walls"): "wall_at_impact",
    _set("motion tilt"): "impacts_off_plane",
    _set("tilt drag motion"): "e_disagrees",
    _set("disturbance offsets motion"): "rest_drifts",
    _set("clock wavelength gravity"): "clock_wrong falls_otherwise",
    STATED | REFLECTORS: "g_impossible flights_pulled",
    _set("drag sphere"): "flights_braked",
    _set("release"): "release_assumed",
    _set("antennas release"): "setup_differs antenna_moved",
    _set("antennas"): "antenna_far angles_in_radians no_position not_as_calibrated",
    _set("wavelength"): "index_of_vacuum",
    _set("tilt floor"): "floor_upside_down",
    _set("floor release"): "floor_above_release floor_elsewhere",
    _set("skew clock"): "skew_too_long",
    _set("polarisation antennas wiring sphere"): "polarization_off",
}
CAUSES_OF_CODE: Mapping[str, Causes] = {code: causes for causes, codes in _CODES.items() for code in codes.split()}
"""By code; what depends on a finding's facts is added to it (`causes_of_finding`)."""

_SENTENCES: tuple[tuple[str, Causes], ...] = (
    # flights and setup
    (r"likely a reflector that is not in the model", REFLECTORS),
    (r"a setup that is wrong by more than it says", STATED),
    (r"something that changed during the motion", CHANGES),
    (r"^flights and g contradict the setup.*(receiver\[|transmitter|calibration)", _set("antennas horns polarisation")),
    (r"^flights and g contradict the setup.*release_position", _set("release holder")),
    (r"^flights and g contradict the setup.*receivers are exchanged", _set("wiring")),
    (r"^flights and g contradict the setup.*(antennas stand elsewhere)", _set("antennas horns")),
    (r"^g came out as", STATED | REFLECTORS),
    (r"^g differs from the site's", _set("antennas horns gravity wavelength clock")),
    (r"touched the floor with its centre at", _set("floor release")),
    (r"the flights are braked more than", _set("drag sphere")),
    (r"the sphere scatters as if .*polarization_deg", _set("polarisation antennas wiring sphere")),
    (r"an impact may be missing, the floor not level, or air drag strong", _set("tilt drag motion")),
    # reflectors
    (r"the search for walls was ended", REFLECTORS),
    (r"likely reflectors that were not found, or a lost fringe", REFLECTORS | _set("signal offsets")),
    (r"a mirror was found that would send back", REFLECTORS | _set("motion")),
    (r"the position is only known to .*what reflects beside the motion", REFLECTORS | _set("signal motion")),
    (r"a metal sphere counts as a point", _set("polarisation sphere")),
    # what was stated and no laboratory has
    (r"\.distance_m = .*no echo of a small sphere", _set("antennas")),
    (r"tilt_deg are .*radians", _set("antennas")),
    (r"radar\.refractive_index = .*vacuum", _set("wavelength")),
    (r"floor\.normal points down", _set("tilt floor")),
    (r"floor\.height_m = .*is not below", _set("floor release")),
    (r"gives no tracer\.release_position_m", _set("release")),
    (r"do not fit into a sample", _set("skew clock")),
    (r"not as calibrated|calibration of .* (is .* days old|does not hold)|has no date", _set("antennas")),
    (r"the receivers stand so that their path lengths tell no position", _set("antennas")),
    # wires and signs
    (r"all phases turn as if the sphere fell upwards", _set("sign wiring")),
    (r"its phase turns as if the sphere fell upwards", _set("sign wiring")),
    (r"all phases turn with .* times the acceleration", _set("clock wavelength")),
    (r"swapped cables, antennas elsewhere", _set("wiring antennas clock disturbance signal")),
    (r"one (cable|signal) on both|do not belong together|not a pair|keep no phase to each other", _set("wiring")),
    (r"no mixer has a gain ratio", _set("wiring")),
    (r"the mixer is dead|the channel is dead|a cable is off", _set("wiring contact")),
    (r"I and Q are exchanged", _set("wiring sign")),
    # signals
    (r"clipped", _set("signal offsets")),
    (r"noise of .* fringes cannot be counted|low signal-to-noise ratio", _set("signal")),
    (r"less than (one|half a|about two) fringe|tracer moves less than", _set("signal motion")),
    (r"which fringe it is", _set("signal motion")),
    (r"the echo is (known from|lost too often)|the echo was lost", _set("signal dip contact motion")),
    (r"(a contact|a cable) is loose|white noise that comes and goes", _set("contact dip disturbance")),
    (r"what no motion of the sphere does", _set("contact dip disturbance gap")),
    (r"more than one (frequency at a time|thing moves)", _set("disturbance harmonics hum floor walls plate")),
    (r"a second reflection or an offset that drifts", REFLECTORS | _set("offsets disturbance harmonics")),
    (r"an offset, a hum or another target leads it", _set("offsets hum disturbance")),
    (r"all paths change alike", _set("disturbance offsets motion")),
    (r"no numbers, and left out", _set("contact signal")),
    (r"samples of each channel were lost", _set("gap")),
    (r"begins right after lost samples", _set("gap motion")),
    (r"there is no rest before the motion|starts in motion", _set("motion")),
    # impacts
    (r"a wall was met", _set("motion walls")),
    (r"the floor moves|the floor gives way|the fall ends (softly|without a rebound)", _set("motion")),
    (r"the impacts lie up to .* off one plane", _set("motion tilt")),
    # what names nothing
    (r"the flights (bend by more|fit worse)", _set("")),
    (r"residuals above the noise", _set("")),
    (r"leave the circle by", _set("")),
    (r"the model does not describe the signal", _set("")),
    (r"of the samples are valid", _set("")),
    (r"(joint|adaptive) correction (does not stand|cannot be made|was stopped)|published one was used", _set("")),
    (r"the flights could not be fitted", _set("")),
    (r"about the front ends is not used", _set("")),
    (r"plane geometry takes the antennas", _set("")),
    (r"s are processed|are shown: nothing moves", _set("")),
    (r"no Doppler frequency stands out|do not move more than their noise", _set("")),
    (r"nothing but a hum|moves the voltages", _set("")),
)  # fmt: skip
_PATTERNS = tuple((re.compile(pattern, re.DOTALL), causes) for pattern, causes in _SENTENCES)


class Named(NamedTuple):
    """What findings blame.

    Attributes
    ----------
    causes
        All of them together.
    nothing
        Whether one of them only says that something is off.
    unknown
        Sentences and codes that stand in no table here.
    """

    causes: Causes
    nothing: bool
    unknown: tuple[str, ...]


def causes_of_sentence(sentence: str) -> Causes | None:
    """Return what a sentence blames; None where no pattern knows it."""
    found = [causes for pattern, causes in _PATTERNS if pattern.search(sentence)]
    return frozenset().union(*found) if found else None


def causes_of_finding(finding: Mapping[str, Any]) -> Causes | None:
    """Return what a finding blames by its code and its facts; None where the table has no such code."""
    causes, facts = CAUSES_OF_CODE.get(finding["code"]), finding.get("facts") or {}
    if causes is None:
        return None
    place = str(facts.get("place", ""))
    more = [_BENT.get(str(facts.get("guess")), NOTHING)]
    if finding["code"] == "setup_contradicted":
        named_places = f"{place} {facts.get('others', '')} {facts.get('what', '')}"
        more += [
            _set("antennas horns polarisation")
            if re.search(r"receiver|transmitter|calibration", named_places)
            else NOTHING,
            _set("release holder") if "release_position" in named_places else NOTHING,
            _set("sphere") if "diameter" in named_places else NOTHING,
            _set("wiring") if facts.get("beside") == "exchanged" else NOTHING,
        ]
    if finding["code"] == "flights_misfit" and facts.get("is_strong"):
        more.append(_set("floor plate"))
    if finding["code"] == "off_circle" and facts.get("weak"):
        more.append(_set("signal"))
    # one may only pass on why something could not be done
    if isinstance(facts.get("cause"), Mapping):
        more.append(causes_of_finding(facts["cause"]) or NOTHING)
    return causes.union(*more)


def named(sentences: Iterable[str], findings: Sequence[Mapping[str, Any]] | None) -> Named:
    """Return what is blamed by the findings of a result, where its version has them, else by its sentences.

    Parameters
    ----------
    sentences
        Warnings, and the reason of a refusal.
    findings
        As in result.json, each with `code` and `severity`; None of versions without.
    """
    if findings is None:
        each = [(sentence, causes_of_sentence(sentence)) for sentence in sentences]
    else:
        serious = [one for one in findings if one["severity"] != "info"]
        each = [(one["code"], causes_of_finding(one)) for one in serious]
    known = [causes for _, causes in each if causes is not None]
    return Named(
        frozenset().union(*known),
        any(not causes for causes in known) or len(known) < len(each),
        tuple(text for text, causes in each if causes is None),
    )
