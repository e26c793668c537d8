"""Scores scenes with whatever version of the program is on its path: a folder a line in, a score a line out.

Before the folder stands whether it is the first of a session or a single scene (`first`), or not (`next`).

python3 -m benchmarks.gate.worker, with the version's tree first on PYTHONPATH. It imports only what the version makes
public, and what tables and result.json promise where the public names of an older version do not have it yet.
"""

from __future__ import annotations

import importlib
import json
import math
import os
import pkgutil
import sys
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from copy import deepcopy
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.gate.scene_files import RUN, SceneTruth, read_plain_setup, read_truth
from benchmarks.gate.score import Answer, score
from pydantic import ValidationError

import radargui

_UNKNOWN_KEY = ("extra_forbidden", "unexpected_keyword_argument")
NEVER_IMPORTED = ("gui", "cli", "__main__")
"""Of a version's packages: a result needs none of them."""


def setup_of_version(tables: Mapping[str, Any]) -> tuple[radargui.Setup, tuple[str, ...]]:
    """Return the setup without the keys that this version does not know, and which these are.

    Raises
    ------
    ValidationError
        What is left over is no setup.
    """
    tables, left_out = deepcopy(dict(tables)), []
    while True:
        try:
            return radargui.Setup.model_validate(tables), tuple(left_out)
        except ValidationError as error:
            unknown = [one["loc"] for one in error.errors() if one["type"] in _UNKNOWN_KEY]
            if not unknown:
                raise
            for place in unknown:
                _remove(tables, place)
                left_out.append(".".join(map(str, place)))


def _remove(tables: Any, place: tuple[int | str, ...]) -> None:
    *way, key = place
    for part in way:
        # a union names its alternatives in between, which are no keys
        with suppress(KeyError, IndexError, TypeError):
            tables = tables[part]
    del tables[key]


def process(folder: Path, session: list[radargui.Result] | None = None) -> dict[str, Any]:
    """Return the score of the scene in a folder, as JSON holds it; its result is added to those of its session.

    A version that knows of sessions is told what came before in this one.
    """
    truth, session = read_truth(folder), [] if session is None else session
    try:
        setup, left_out = setup_of_version(read_plain_setup(folder))
    except ValidationError as error:
        said = "; ".join(f"{'.'.join(map(str, one['loc']))}: {one['msg']}" for one in error.errors())
        return score(truth, _refusal(said)).plain()
    try:
        run = radargui.open_run(folder / RUN, setup=setup)
        begin = time.process_time()
        known = {"session": session} if "session" in signature(radargui.process).parameters else {}
        result = radargui.process(run, **known)
        session.append(result)
        seconds = time.process_time() - begin
    except radargui.RadarGuiError as error:
        return score(truth, _refusal(str(error)), left_out=left_out).plain()
    return score(truth, answer_of(result, truth), seconds, left_out).plain()


def _refusal(reason: str, status: str = "rejected") -> Answer:
    nothing = np.zeros(0)
    index = nothing.astype(np.int64)
    return Answer(status, reason, (), None, index, index.astype(bool), index, None, None, nothing, nothing, (), None)


def answer_of(result: radargui.Result, truth: SceneTruth) -> Answer:
    """Return what a result says; arrays are of the samples that were processed."""
    findings = getattr(result, "findings", getattr(result.details, "findings", None))
    said: dict[str, Any] = {
        "status": str(result.status),
        "reason": str(result.reason or ""),
        "sentences": tuple(map(str, result.warnings)),
        "findings": None if findings is None else tuple(_finding(one) for one in findings),
    }
    if said["status"] != "ok":
        return Answer(**{**_refusal("").__dict__, **said})
    has_track = truth.path_m.shape[0] >= 3 and len(result.path_m) >= 3
    return Answer(
        **said,
        index=np.round(result.time_s * truth.rate_hz).astype(np.int64),
        valid=np.asarray(result.valid, dtype=bool),
        piece=_pieces(result),
        position_m=result.position_m if has_track else None,
        u_position_m=_first_known(result.u_position_combined_m, result.u_position_m) if has_track else None,
        path_m=result.path_m,
        u_path_m=result.u_path_m,
        impacts=tuple((one.time_s, one.e, _u(one.u_e_combined, one.u_e), bool(one.valid)) for one in result.bounces),
        g=_gravity(result),
    )


def _finding(one: Any) -> dict[str, Any]:
    """Return a finding as result.json has it; facts that are findings stay such."""
    facts = {name: _finding(fact) if hasattr(fact, "code") else fact for name, fact in one.facts.items()}
    plain = {"code": one.code, "severity": one.severity, "receiver": one.receiver, "facts": facts}
    return dict(json.loads(json.dumps(plain, default=str)))


def _u(combined: float | None, statistical: float) -> float:
    return statistical if combined is None or not math.isfinite(combined) else combined


def _first_known(combined: Any, statistical: Any) -> Any:
    return np.where(np.isfinite(combined), combined, statistical)


def _pieces(result: radargui.Result) -> Any:
    piece = result.piece if hasattr(result, "piece") else result.details.paths.piece
    return np.zeros(result.time_s.size, dtype=np.int64) if piece is None else np.asarray(piece)


def _gravity(result: radargui.Result) -> tuple[float, float] | None:
    fall = result.free_fall
    if fall is None or not math.isfinite(fall.g_m_s2):
        return None
    budget = result.uncertainty_budget if hasattr(result, "uncertainty_budget") else result.details.uncertainty_budget
    return fall.g_m_s2, _u(budget and budget.g_m_s2.combined, fall.u_g_m_s2)


def import_all() -> None:
    """Import what the first result would load, so that its time is that of the work."""
    for package in radargui.__path__:
        for one in _modules(package, "radargui."):
            # a plug-in's or a device's library may not be there
            with suppress(ImportError):
                importlib.import_module(one)


def _modules(folder: str, prefix: str) -> Iterable[str]:
    for one in pkgutil.iter_modules([folder], prefix):
        if one.name.removeprefix("radargui.") not in NEVER_IMPORTED:
            yield one.name
            if one.ispkg:
                yield from _modules(str(Path(folder, one.name.rpartition(".")[2])), f"{one.name}.")


def main() -> None:
    """Answer until the input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # what libraries print is no answer
    os.dup2(2, 1)
    import_all()
    print(json.dumps({"program": radargui.__file__}), file=answers, flush=True)
    session: list[radargui.Result] = []
    for line in sys.stdin:
        follows, _, folder = line.rstrip("\n").partition(" ")
        if follows == "first":
            session.clear()
        print(json.dumps(process(Path(folder), session)), file=answers, flush=True)


if __name__ == "__main__":
    main()
