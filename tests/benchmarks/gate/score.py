"""How far off one result is, and what that counts as.

A scene is

* **right** where the status is ok and nothing of what is stated is off: root mean square error of the track within
  `TRACK_U` of its stated u (combined, where a version has it); every valid e and g within `VALUE_U` of its stated u,
  which an honest u passes in 99.9 of 100 values; nothing invented (an impact where none was, a coefficient of what is
  no floor, a g of what never falls); no impact missed that throws the sphere back with more than `SEEN_M_S` and happens
  `NEAR_END_S` or more before the record ends. Of one or two receivers path lengths stand in place of the track, each
  piece by itself. Right too: to refuse, or to find no motion in, what is to be refused.
* **told** where it is off, and a finding (warning or refusal) blames something that was drawn into the scene, or says
  that something is off and blames nothing. Where both are allowed, a result and a refusal, a refusal counts by what it
  blames too.
* **wrong cause** where it is off and findings blame only what is not in the scene.
* **SILENT** where it is off, and nothing is said.
* **refused** where the status is not ok though the scene can be processed. Of these is said how many blame what is in
  the scene, how many only what is not, and how many nothing. A version that fails (no error of its own) counts here.

What begins `SAME_S` from an impact is that impact. Positions are compared from the start of the motion on, where valid.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from benchmarks.gate.causes import Named, named
from benchmarks.gate.scene_files import SceneTruth
from numpy.typing import NDArray

Array = NDArray[np.float64]
Outcome = Literal["right", "told", "wrong cause", "SILENT", "refused"]
OUTCOMES: tuple[Outcome, ...] = ("right", "told", "wrong cause", "SILENT", "refused")

TRACK_U, VALUE_U = 3.0, 3.3
SEEN_M_S, NEAR_END_S, SAME_S = 0.15, 0.030, 0.005
CONVERGED_S, CONVERGED_E, CONVERGED_U = 0.002, 1e-3, 4.0
MIN_REST_S = 0.05
"""A shorter rest is no zero of paths."""
MIN_U_M = 1e-9
"""Tables are written to the nanometre."""


class Value(NamedTuple):
    """One stated number with its u (combined where it is known), and the truth."""

    value: float
    u: float
    truth: float

    @property
    def error(self) -> float:
        """Stated less true."""
        return self.value - self.truth

    @property
    def in_u(self) -> float:
        """The error in units of the stated u."""
        return self.error / self.u if self.u > 0.0 else math.inf


@dataclass(frozen=True)
class Answer:
    """What a version says of a run, as its tables have it.

    Attributes
    ----------
    status, reason, sentences, findings
        As in result.json; `findings` is None of versions without.
    index, valid, piece
        Of each sample processed, (n,).
    position_m, u_position_m
        (3, n), u combined where the version has it; None with fewer than three receivers.
    path_m, u_path_m
        (n_receivers, n).
    impacts
        time_s, e, u (combined where it is known), valid of each row of bounces.csv.
    g
        Value and u; None where none is told.
    """

    status: str
    reason: str
    sentences: tuple[str, ...]
    findings: Sequence[Mapping[str, Any]] | None
    index: NDArray[np.int64]
    valid: NDArray[np.bool_]
    piece: NDArray[np.int64]
    position_m: Array | None
    u_position_m: Array | None
    path_m: Array
    u_path_m: Array
    impacts: tuple[tuple[float, float, float, bool], ...]
    g: tuple[float, float] | None


@dataclass(frozen=True)
class Score:
    """One result against the truth; None where there is no such number. JSON can hold it (`plain`, `of_plain`).

    Attributes
    ----------
    status, reason, sentences, findings
        As in `Answer`.
    expected, causes
        As in `SceneTruth`.
    valid_share
        Share of the motion that is valid.
    track_error_m, track_u_m
        Root mean squares over it, all coordinates together; of paths where no position is told.
    track_inside_2u
        Share of the coordinates within 2u.
    place_m, shape_m
        Root mean square of the 3D error, and the same with the mean of each axis taken off.
    first_e
        Of the first impact, where it is told and valid.
    e, g
        Those that are told.
    missed, invented
        How many.
    converged
        Whether each impact that must not be missed is found within 2 ms, each e told is within 0.1 % or 4 u, and none
        is invented; None of old scores.
    seconds
        Of processor time.
    left_out
        Keys of the setup that the version does not know.
    """

    status: str
    reason: str
    sentences: tuple[str, ...]
    findings: tuple[Mapping[str, Any], ...] | None
    expected: str
    causes: frozenset[str]
    valid_share: float | None = None
    track_error_m: float | None = None
    track_u_m: float | None = None
    track_inside_2u: float | None = None
    place_m: float | None = None
    shape_m: float | None = None
    first_e: Value | None = None
    e: tuple[Value, ...] = ()
    g: Value | None = None
    missed: int = 0
    invented: int = 0
    converged: bool | None = None
    seconds: float = 0.0
    left_out: tuple[str, ...] = ()

    @property
    def named(self) -> Named:
        """What its findings blame."""
        refusal = (self.reason,) if self.reason and self.status != "ok" else ()
        return named((*refusal, *self.sentences), self.findings)

    @property
    def warned(self) -> bool:
        """Whether anything is said that is a warning or a refusal."""
        return bool(self.named.causes) or self.named.nothing

    @property
    def faults(self) -> tuple[str, ...]:
        """What is off of a result called ok: track, e, g, invented, missed."""
        has_track = self.track_error_m is not None and self.track_u_m is not None
        off = {
            "track": not (has_track and _within(self.track_error_m, TRACK_U, self.track_u_m)),
            "e": any(not abs(one.in_u) <= VALUE_U for one in self.e),
            "g": self.g is not None and not abs(self.g.in_u) <= VALUE_U,
            "invented": self.invented > 0,
            "missed": self.missed > 0,
        }
        return tuple(name for name, is_off in off.items() if is_off)

    @property
    def outcome(self) -> Outcome:
        """What the scene counts as; the docstring of this module says it."""
        is_refused = self.status != "ok"
        if is_refused and self.expected != "either":
            return "right" if self.expected == "refused" else "refused"
        if not is_refused and self.expected != "refused" and not self.faults:
            return "right"
        blamed = self.named
        if blamed.nothing or blamed.causes & self.causes or (is_refused and not blamed.causes):
            return "told"
        return "wrong cause" if blamed.causes else "SILENT"

    @property
    def blames(self) -> Literal["right", "wrong", "nothing"]:
        """Whether findings blame what is in the scene, only what is not, or nothing at all."""
        blamed = self.named.causes
        if not blamed:
            return "nothing"
        return "right" if blamed & self.causes else "wrong"

    def plain(self) -> dict[str, Any]:
        """Return what JSON can hold."""
        return {**self.__dict__, "causes": sorted(self.causes)}

    @staticmethod
    def of_plain(plain: Mapping[str, Any]) -> Score:
        """Return what `plain` was made of."""
        numbers = {name: plain[name] and Value(*plain[name]) for name in ("first_e", "g")}
        tuples = {name: tuple(plain[name]) for name in ("sentences", "left_out")}
        findings = plain["findings"]
        return Score(
            **{
                **plain,
                **numbers,
                **tuples,
                "causes": frozenset(plain["causes"]),
                "findings": None if findings is None else tuple(findings),
                "e": tuple(Value(*one) for one in plain["e"]),
            }
        )


def _within(error: float | None, times: float, u: float | None) -> bool:
    return error is not None and u is not None and error <= times * max(u, MIN_U_M)


def score(truth: SceneTruth, answer: Answer, seconds: float = 0.0, left_out: Sequence[str] = ()) -> Score:
    """Return how far off an answer is."""
    findings = None if answer.findings is None else tuple(answer.findings)
    said: dict[str, Any] = {
        "status": answer.status,
        "reason": answer.reason,
        "sentences": answer.sentences,
        "findings": findings,
        "expected": truth.expected,
        "causes": truth.causes,
        "seconds": seconds,
        "left_out": tuple(left_out),
    }
    if answer.status != "ok":
        return Score(**said, converged=False)
    return Score(**said, **_motion(truth, answer), **_impacts(truth, answer), g=_gravity(truth, answer))


def _motion(truth: SceneTruth, answer: Answer) -> dict[str, float | None]:
    """Return the figures of the track, or of the paths where there is none."""
    moving = truth.index >= truth.start_s * truth.rate_hz
    # an excerpt holds some of the instants, and what was lost is in none
    place = np.minimum(np.searchsorted(answer.index, truth.index), answer.index.size - 1)
    held = answer.index[place] == truth.index
    known = moving & held & answer.valid[place]
    if truth.position_m is not None and answer.position_m is not None and answer.u_position_m is not None:
        error = answer.position_m[:, place] - truth.position_m
        u = answer.u_position_m[:, place]
    else:
        error = _path_errors(truth, answer, place, held)
        u = answer.u_path_m[:, place]
    known &= np.isfinite(error).all(axis=0) & np.isfinite(u).all(axis=0)
    out: dict[str, float | None] = {"valid_share": float(known.sum() / max(1, moving.sum()))}
    if not known.any():
        return out
    error, u = error[:, known], u[:, known]
    out |= {
        "track_error_m": float(np.sqrt((error**2).mean())),
        "track_u_m": float(np.sqrt((u**2).mean())),
        "track_inside_2u": float((np.abs(error) <= 2.0 * np.maximum(u, MIN_U_M)).mean()),
    }
    if truth.position_m is not None and answer.position_m is not None:
        bent = error - error.mean(axis=1, keepdims=True)
        out |= {name: float(np.sqrt((e**2).sum(axis=0).mean())) for name, e in (("place_m", error), ("shape_m", bent))}
    return out


def _path_errors(truth: SceneTruth, answer: Answer, place: NDArray[np.intp], held: NDArray[np.bool_]) -> Array:
    """Return the errors of the paths' changes; a piece without a rest has no zero, its mean error is taken off."""
    resting = truth.index < (truth.start_s if truth.start_s >= MIN_REST_S else 0.0) * truth.rate_hz
    error = answer.path_m[:, place] - truth.path_m
    usable = held & answer.valid[place] & np.isfinite(error).all(axis=0)
    for piece in np.unique(answer.piece[place[usable]]):
        own = usable & (answer.piece[place] == piece)
        zero = own & resting if (own & resting).any() else own
        error[:, own] -= error[:, zero].mean(axis=1, keepdims=True)
    return np.asarray(np.where(usable, error, np.nan))


def _impacts(truth: SceneTruth, answer: Answer) -> dict[str, Any]:
    """Return the coefficients told of true impacts on a floor, and how many impacts were missed and invented."""
    true_s = np.array([one.time_s for one in truth.impacts])
    told: dict[int, Value] = {}
    found, at_once, invented = set(), set(), 0
    for time_s, e, u, valid in answer.impacts:
        nearest = int(np.argmin(np.abs(true_s - time_s))) if true_s.size else -1
        if nearest < 0 or abs(true_s[nearest] - time_s) > SAME_S:
            invented += 1
            continue
        found.add(nearest)
        if abs(true_s[nearest] - time_s) < CONVERGED_S:
            at_once.add(nearest)
        if valid and truth.impacts[nearest].on_floor:
            told[nearest] = Value(e, u, truth.impacts[nearest].e)
        elif valid:
            invented += 1
    needed = {
        number
        for number, one in enumerate(truth.impacts)
        if one.on_floor and one.after_m_s > SEEN_M_S and one.time_s <= truth.end_s - NEAR_END_S
    }
    # paths of one or two receivers tell no speeds
    missed = len(needed - found) if truth.position_m is not None else 0
    first = next((number for number, one in enumerate(truth.impacts) if one.on_floor), -1)
    e = tuple(told[number] for number in sorted(told))
    invented += _false_fall(truth, answer)
    near = all(abs(one.error) <= max(CONVERGED_E * one.truth, CONVERGED_U * one.u) for one in e)
    converged = near and not invented and needed <= at_once
    return {"e": e, "first_e": told.get(first), "missed": missed, "invented": invented, "converged": converged}


def _false_fall(truth: SceneTruth, answer: Answer) -> int:
    return int(answer.g is not None and truth.gravity_m_s2 is None)


def _gravity(truth: SceneTruth, answer: Answer) -> Value | None:
    return None if answer.g is None or truth.gravity_m_s2 is None else Value(*answer.g, truth.gravity_m_s2)
