"""The lines and the table of the laboratory's scores."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from benchmarks.scoring.laboratory import Array, Figure, Score
from benchmarks.scoring.verdict import wrong, wrong_in_silence
from benchmarks.world.scene import Scene

LOUD_DB = 30.0
"""The bars hold for scenes of this and more; the others are reported."""


def line(scene: Scene, one: Score) -> str:
    """Return what came of one scene."""
    converter = scene.converter
    is_apart = bool(scene.disturbances) or scene.is_mistaken
    facts = " ".join(f"{key} {value}" for key, value in scene.facts.items())
    return (
        f"{one.scene:16s} {one.stated:15s} {scene.snr_db:3.0f} dB {converter.rate_hz / 1e3:4.1f}k "
        f"{1e6 * converter.skew_s:4.1f}us {facts} | 3D {_plain(one.rms_3d_mm, 4)} mm "
        f"in2u {_plain(one.inside_2u, 2)}/{_plain(one.inside_2u_combined, 2)} "
        f"|err|/u {_pooled([one.error_over_u])}/{_pooled([one.error_over_u_combined])} "
        f"missed {one.missed} false {one.false} e {_figure(one.first_e)} g {_figure(one.g)} by {one.used} "
        f"warnings {len(one.warnings)}{_moved(one) if one.motion != 'drop' or is_apart else ''}"
        f"{_off(one) if is_apart else ''}{' SILENT' if one.silent else ''} {one.seconds:.1f} s"
    )


def _off(one: Score) -> str:
    """Return what is wrong with a drop that was disturbed or stated wrongly, and whether nothing was said of it."""
    found = ", ".join(wrong(one))
    return f" off: {found}{' IN SILENCE' if wrong_in_silence(one) else ''}" if found else ""


def _moved(one: Score) -> str:
    """Return what matters of a motion that is no drop."""
    return (
        f" {one.status} largest {_plain(one.largest_over_u, 1)} u known {_plain(one.known_share, 2)} "
        f"far off {_plain(one.far_share, 2)}{' WRONG' if one.wrong else ''}{' NO FALL' if one.false_fall else ''}"
        f" e worst {_plain(one.worst_e_in_u, 1)} u baseless {one.baseless_e}{' E WRONG' if one.wrong_e else ''}"
    )


def table(scores: Iterable[Score]) -> str:
    """Return a row for each kind of setup, loud scenes and quiet ones apart."""
    found = list(scores)
    rows = []
    for stated in dict.fromkeys(one.stated for one in found):
        for loud in (True, False):
            part = [one for one in found if one.stated == stated and (one.snr_db >= LOUD_DB) == loud]
            if part:
                rows.append(f"{stated} {'from' if loud else 'below'} {LOUD_DB:.0f} dB, n {len(part)}:\n{_row(part)}")
    return "\n".join(rows)


def _row(part: list[Score]) -> str:
    e, g = [one for score in part for one in score.e], [score.g for score in part if score.g is not None]
    level, leaning = (
        [one.first_e.error_percent for one in part if one.first_e is not None and one.leaning == leans]
        for leans in (False, True)
    )
    return (
        f"  median/worst: 3D mm {_spread([one.rms_3d_mm for one in part])}, "
        f"first e % {_spread(level)} level, {_spread(leaning)} leaning, "
        f"g % {_spread([one.error_percent for one in g])}\n"
        f"  inside 2u statistical: track {_mean([one.inside_2u for one in part])}, e {_share(e)}, g {_share(g)}; "
        f"combined: track {_mean([one.inside_2u_combined for one in part])}, "
        f"e {_share(e, combined=True)}, g {_share(g, combined=True)}\n"
        f"  |error|/u pooled, median {_pooled([one.error_over_u for one in part])}, "
        f"combined {_pooled([one.error_over_u_combined for one in part])} (honest: 0.67); "
        f"missed {sum(one.missed for one in part)} false {sum(one.false for one in part)}; "
        f"warned {sum(bool(one.warnings) for one in part)} of {len(part)}; "
        f"silent {_named([one.scene for one in part if one.silent])}; {_other_motions(part)}"
        f"without track {sum(one.rms_3d_mm is None for one in part)}\n"
        f"  processor s median/worst {_spread([one.seconds for one in part], 1)}, "
        f"in all {sum(one.seconds for one in part):.0f}"
    )


def _other_motions(part: list[Score]) -> str:
    if all(one.motion == "drop" for one in part):
        return ""
    largest = [one.largest_over_u for one in part]
    return (
        f"wrong {_named([one.scene for one in part if one.wrong])}; largest u {_spread(largest, 1)}; "
        f"g of no fall {_named([one.scene for one in part if one.false_fall])}; "
        f"wrong e {_named([one.scene for one in part if one.wrong_e])}; "
        f"not ok {_named([one.scene for one in part if one.status != 'ok'])}; "
    )


def _named(scenes: list[str]) -> str:
    return ", ".join(scenes) or "none"


def _spread(values: list[float | None], digits: int = 4) -> str:
    known = np.abs([v for v in values if v is not None])
    return f"{np.median(known):.{digits}f}/{known.max():.{digits}f}" if known.size else "-"


def _pooled(ratios: list[Array | None]) -> str:
    known = [one for one in ratios if one is not None]
    return f"{np.median(np.concatenate(known)):.2f}" if known else "-"


def _mean(values: list[float | None]) -> str:
    known = [v for v in values if v is not None]
    return f"{np.mean(known):.3f}" if known else "-"


def _share(figures: list[Figure], *, combined: bool = False) -> str:
    known = [one.in_combined if combined else one.in_u for one in figures]
    inside = [abs(v) < 2.0 for v in known if v is not None]
    return f"{sum(inside)}/{len(inside)}" if inside else "-"


def _figure(one: Figure | None) -> str:
    return "-" if one is None else f"{one.error_percent:+.4f} % ({one.in_u:+.1f} u)"


def _plain(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
