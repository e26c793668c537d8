"""Write what a report says of one run: words, tables, then figures."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import isfinite

from radargui.model.drop import restitution_words
from radargui.model.rounding import UNKNOWN, alone, plain, quantity
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import budget_rows, variance_shares
from radargui.model.words import percent, sentence, written_time
from radargui.report.content import Chapter, Content, Facts, Grid, Note, Picture, Plots
from radargui.report.run_facts import RunFacts


def run_section(run: RunFacts, setup: Setup) -> Chapter:
    """Return all that is said of one run, with pages of figures; of a run that failed it says why."""
    if run.failure:
        return Chapter(_title(run), (Note(f"No result: {run.failure}", warning=True),))
    return Chapter(_title(run), _words(run), _pictures(run, setup))


_MAX_IMPACTS, _MAX_LETTERS = 6, 300
"""On the page of a run; more stands in the tables."""


def run_page(run: RunFacts) -> Chapter:
    """Return one page about a run: what it gave, in small print, and its figures."""
    if run.failure or run.curves is None:
        return Chapter(_title(run), (Note(f"No result: {run.failure or 'no samples'}", warning=True),))
    # matplotlib is loaded only where a report is made: the window shows the same words without it
    from radargui.report.run_figures import fall_figure, iq_figure

    recorded = filter(None, (_when(run), run.origin or run.device or run.source.file, _samples(run)))
    rows = dict(_result_rows(run)) | {"Recorded": "; ".join(recorded)}
    shown = replace(run, bounces=replace(run.bounces, impacts=run.bounces.impacts[:_MAX_IMPACTS]))
    more, lost = len(run.bounces.impacts) - _MAX_IMPACTS, sum(gap.count for gap in run.gaps)
    warnings = [*run.warnings, *([f"{lost} samples were lost."] if lost else [])]
    further = [Note(f"{more} more impact{'s are' if more > 1 else ' is'} in report.csv.")] if more > 0 else []
    blocks: list[Content] = [
        Facts(tuple((name, _cut(value)) for name, value in rows.items() if value)),
        *_refusal(run),
        *(replace(block, title="") for block in _impacts(shown) if isinstance(block, Grid)),
        *further,
        *(replace(block, title="") for block in _quality(run) if isinstance(block, Grid)),
        *([Note(_cut(" ".join(map(sentence, warnings))), warning=True)] if warnings else []),
    ]
    iq = Picture("I and Q", partial(iq_figure, run.curves))
    fall = Picture("Phase and height", partial(fall_figure, run.curves)) if run.curves.has_phase else None
    blocks.append(Plots((iq, fall) if fall else (iq,), fitted=True))
    screen = (*_words(run), Plots((fall or iq,)))
    return Chapter(_title(run), tuple(blocks), run.added, small=True, screen=screen)


def _cut(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _MAX_LETTERS else f"{line[: _MAX_LETTERS - 1]}…"


def _title(run: RunFacts) -> str:
    mark = f" ({run.said})" if run.status != "ok" or run.source.mark or run.preliminary else ""
    return f"Run {run.name.removeprefix('run-')}{mark}"


def _when(run: RunFacts) -> str:
    return written_time(run.started_at, "%Y-%m-%d %H:%M:%S %z", run.started_at).rstrip()


def _samples(run: RunFacts) -> str:
    return f"{run.n_samples} of each channel in {plain(run.duration_s, 4, 's')} at {run.rate_hz:.7g} Hz"


def _words(run: RunFacts) -> tuple[Content, ...]:
    rows = dict(_result_rows(run)) | {
        "Recorded": _when(run) or UNKNOWN,
        "Source": run.source.badge,
        "Replay of": run.source.file,
        "Samples": _samples(run),
        "Imported from": run.origin,
        "Device": run.device or ("" if run.origin else UNKNOWN),
    }
    # what speaks against the figures stands before them: below it is out of sight on a small screen
    blocks = [*_refusal(run), *(Note(sentence(text), warning=True) for text in run.warnings)]
    if run.site_check and run.site_check.agrees is False:
        blocks.append(Note("g is not that of the site: see “g against the site”.", warning=True))
    return *blocks, Facts.of(rows), *_impacts(run), *_quality(run), *_gaps(run), *_calibration(run)


def _refusal(run: RunFacts) -> Iterator[Content]:
    if run.status == "rejected":
        yield Note("Rejected: no position, e or g of this run is valid.", warning=True)


def _result_rows(run: RunFacts) -> Iterator[tuple[str, str]]:
    """Yield what came out of it: what is looked for first, how it was found last."""
    yield "Result", " – ".join(part for part in (run.said, run.reason) if part)
    if run.status == "no_motion":
        return
    if run.figure("e") is not None:
        yield "e of the first impact", restitution_words(run.figures)
    elif run.bounces.impacts:
        yield "e of the first impact", "not valid"
    yield from _fall_rows(run)
    yield "Correction, geometry", f"{run.correction or UNKNOWN}, {run.geometry or UNKNOWN}"
    yield "Decided", " ".join(run.decisions)


def _fall_rows(run: RunFacts) -> Iterator[tuple[str, str]]:
    fall, name = run.bounces.free_fall, "First fall" if run.from_rest else "Flight before the first impact seen"
    if fall is None:
        yield name, "none that can be fitted"
        return
    combined = run.figure("u_g_combined_m_s2")
    if combined is not None:
        yield "g (combined u)", quantity(fall.g_m_s2, combined, "m/s²")
    yield "g (statistical u)", quantity(fall.g_m_s2, fall.u_g_m_s2, "m/s²")
    yield "g against the site", run.site_check.compared if run.site_check else ""
    span = f"{fall.first_time_s - run.zero_s:.4f} s to {fall.last_time_s - run.zero_s:.4f} s after {run.since}"
    release = f"from a height of {plain(fall.release_height_m, 5, 'mm', 1e3)}, fitted {span}"
    drop = f"{plain(fall.drop_height_m, 5, 'mm', 1e3)} " if isfinite(fall.drop_height_m) else ""
    yield name, f"{drop}{release}"
    yield "Residual of the fit", f"{plain(fall.residual_rms_m, 3, 'µm', 1e6)} rms"


def _impacts(run: RunFacts) -> Iterator[Content]:
    # without a track nobody looked for one
    if not run.bounces.impacts and run.geometry:
        yield Note("No impact was found.")
    rows = (
        {
            "impact": str(number),
            f"time after {run.since} / s": f"{impact.time_s - run.zero_s:.5f}",
            "speed before / (m/s)": plain(impact.speed_before_m_s, 5),
            "speed after / (m/s)": plain(impact.speed_after_m_s, 5),
            "e": quantity(impact.e, impact.u_stated),
            "statistical u": plain(impact.u_e, 2),
            # no digits beyond those that the fit supports
            "e of times alone": quantity(impact.e_times, impact.u_e_times),
            "e of flight time": alone(impact.e_flight_time, impact.u_stated),
            "e of height": alone(impact.e_height, impact.u_stated),
            "valid": "yes" if impact.valid else "no",
            "method": impact.method,
        }
        for number, impact in enumerate(run.bounces.impacts, 1)
    )
    if run.bounces.impacts:
        yield Grid.of(rows, "Impacts", left=(0, 9, 10))
        yield from _oblique(run)


def _oblique(run: RunFacts) -> Iterator[Content]:
    """Yield where and under which angle the sphere hit, where the estimate knows."""
    if not any(isfinite(impact.angle_deg) for impact in run.bounces.impacts):
        return
    rows = (
        {
            "impact": str(number),
            **{
                f"{axis} / mm": alone(1e3 * place, 1e3 * impact.u_position_m)
                for axis, place in zip("xyz", (impact.x_m, impact.y_m, impact.z_m), strict=True)
            },
            "angle / °": quantity(impact.angle_deg, impact.u_angle_deg),
            "along the floor / (m/s)": plain(impact.vt_before_m_s, 3),
            "after / (m/s)": plain(impact.vt_after_m_s, 3),
            "e_t": quantity(impact.e_t, impact.u_e_t),
            "μ": quantity(impact.mu, impact.u_mu),
        }
        for number, impact in enumerate(run.bounces.impacts, 1)
    )
    yield Grid.of(rows, "Where and how it hit", left=(0,))
    yield Note(
        "Velocities are of the centre: e_t is not the restitution of the point that touches; the apparent friction μ "
        "is a lower bound of the coefficient where the sphere does not slide throughout."
    )


def _quality(run: RunFacts) -> Iterator[Content]:
    if not run.channels:
        return
    rows = (
        {
            "receiver": channel.name,
            "SNR / dB": plain(channel.snr_db, 3),
            "circularity": plain(channel.circularity, 2),
            "image rejection / dB": plain(channel.image_rejection_db, 3),
            "fringes": plain(channel.fringes, 3),
            "valid": _percent(channel.fraction_valid),
            "clipped": _percent(channel.fraction_clipped),
            "gain Q/I": quantity(channel.gain_ratio, channel.u_gain_ratio),
            "quadrature / °": quantity(channel.quadrature_error_deg, channel.u_quadrature_error_deg),
            "verdict": channel.verdict,
        }
        for channel in run.channels
    )
    yield Grid.of(rows, "Quality of the receivers", left=(0, 9))
    said = " ".join((run.reason, *run.warnings))
    yield from (Note(f"Receiver {one.name}: {one.reason}") for one in run.channels if one.reason not in said)


def _percent(share: float | None) -> str:
    return UNKNOWN if share is None else f"{100.0 * share:.3g} %"


def _gaps(run: RunFacts) -> Iterator[Content]:
    if not run.gaps or not run.rate_hz:
        return
    rate = run.rate_hz
    rows = (
        {
            f"from / s after {run.since}": f"{gap.first_index / rate - run.zero_s:.5f}",
            "samples of each channel": str(gap.count),
            "length / ms": plain(gap.count / rate, 3, scale=1e3),
            "reason": gap.reason or UNKNOWN,
        }
        for gap in run.gaps
    )
    yield Grid.of(rows, "Lost samples", left=(3,))


def _calibration(run: RunFacts) -> Iterator[Content]:
    if run.uncertainty_budget is None:
        return
    header, *rows = budget_rows(run.uncertainty_budget)
    yield Grid(header, tuple(rows), "Standard uncertainties", left=(0,))
    shares = [
        f"{name}: " + ", ".join(f"{share} {percent(part)}" for share, part in variance_shares(line).items())
        for name, line in (("e", run.uncertainty_budget.e), ("g", run.uncertainty_budget.g_m_s2))
        if variance_shares(line)
    ]
    if shares:
        yield Note(f"Shares of the squares. {'; '.join(shares)}.")
    if run.uncertainty_budget.assumed:
        said = ", ".join(f"{key} {plain(u, 2)}" for key, u in run.uncertainty_budget.assumed.items())
        yield Note(f"Assumed, because the setup does not say: {said}.")


def _pictures(run: RunFacts, setup: Setup) -> tuple[Picture, ...]:
    curves = run.curves
    if curves is None:
        return run.added
    # matplotlib is loaded only where a report is made: the window shows the same words without it
    from radargui.report.run_figures import motion_page, paths_page, signals_page, steps_page, track_page

    pictures = [Picture("raw and corrected IQ" if run.correction else "raw IQ", partial(signals_page, curves))]
    if any(receiver.steps for receiver in curves.receivers):
        pictures.append(Picture("steps of the published correction", partial(steps_page, curves)))
    if curves.has_phase:
        pictures.append(Picture("phase and path length", partial(paths_page, curves)))
    if curves.track is not None and curves.track.places_m.size:
        pictures.append(Picture("track", partial(track_page, curves, curves.track, setup.floor.height_m)))
    if curves.motion is not None:
        pictures.append(Picture("velocity and acceleration", partial(motion_page, curves, curves.motion)))
    return (*pictures, *run.added)
