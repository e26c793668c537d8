"""The report's first section: who, when, all runs in one table, statistics and figure of the series, setup."""

import math
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from radargui import __version__
from radargui.geometry.path_length import condition_number, place_antennas, t_matrix
from radargui.model.calibrated_setup import (
    CORRELATED,
    calibration_words,
    correlations,
    edited_since,
    setup_key,
    unit_of,
    value_at,
)
from radargui.model.drop import gravity_words, restitution_words
from radargui.model.radar import Transmitter
from radargui.model.rounding import UNKNOWN, plain, quantity
from radargui.model.setup import Setup
from radargui.processing.locate import LEAST_RECEIVERS
from radargui.report.document import Chapter, Content, Facts, Grid, Note, Picture
from radargui.report.run_section import RunFacts, all_simulated
from radargui.report.sheet import RECEIVER_COLOURS, add_axes, legend, new_page
from radargui.restitution.series import series_of
from radargui.session.info import SessionInfo


def session_section(info: SessionInfo, runs: Sequence[RunFacts], made_at: str) -> Chapter:
    """Return the section about the session as a whole."""
    imported = bool(runs) and all(run.origin for run in runs)
    simulated = all_simulated(runs)
    versions = ", ".join(f"{name} {text}" for name, text in info.versions.items())
    rows = {
        "Session": info.name,
        "Begun": info.created_at,
        "Operator": info.operator,
        "Sample": info.sample,
        "Target": info.target,
        "Notes": info.notes,
        "Calibration": ", ".join(filter(None, (info.calibration.origin, info.calibration.made_at))),
        "Imported with" if imported else "Recorded with": versions,
        "Report": f"made {made_at} with radargui {__version__}, as all its results",
    }
    notes = tuple((entry.at.replace("T", " ")[:19], entry.text) for entry in info.journal)
    blocks: list[Content] = [Facts(tuple((name, said or UNKNOWN) for name, said in rows.items()))]
    if notes:
        blocks.append(Facts(notes, title="Noted meanwhile"))
    if not runs:
        blocks.append(Note("This session holds no run.", warning=True))
    else:
        if preliminary := ", ".join(run.name for run in runs if run.preliminary):
            said = f"Preliminary, because the correction was stopped before it ended: {preliminary}."
            blocks.append(Note(f"{said} radargui batch makes up for it.", warning=True))
        blocks += [_summary(runs), *_statistics(runs)]
    blocks += _setup_blocks(info.setup, recorded=not imported and not simulated, simulated=simulated)
    return Chapter(
        f"Session {info.name}{', simulated' if simulated else ''}",
        tuple(blocks),
        speed_picture({run.name: [run] for run in runs}),
    )


def _summary(runs: Sequence[RunFacts]) -> Grid:
    rows = (
        {
            "drop": run.label,
            "run": run.name,
            "drop height / mm": plain(run.figure("drop_height_m"), 4, scale=1e3),
            "impact speed / (m/s)": plain(run.figure("impact_speed_m_s"), 4),
            "e": restitution_words(run.figures),
            "g / (m/s²)": gravity_words(run.figures),
            "impacts": str(len(run.bounces.impacts)) if run.figures else UNKNOWN,
            "verdict": run.said,
        }
        for run in runs
    )
    return Grid.of(rows, "Runs (± is the combined standard uncertainty of each run)", left=(0, 1, 7))


def _statistics(runs: Sequence[RunFacts]) -> list[Content]:
    series = series_of([run.drop for run in runs])
    found = (
        ("e of the first bounce", series.e, 1.0),
        ("g / (m/s²)", series.g_m_s2, 1.0),
        ("drop height / mm", series.drop_height_m, 1e3),
    )
    rows = (
        {
            "quantity": text,
            "n": str(one.n),
            "mean ± combined u": one.words(scale),
            "standard error": plain(one.standard_error, 2, scale=scale),
            "standard deviation": plain(one.standard_deviation, 2, scale=scale),
        }
        for text, one, scale in found
    )
    of = {"measured": "", "simulated": "simulated ", "replay": "replayed "}[series.kind or "measured"]
    title = f"Statistics of the {of}series (runs whose rest before the fall was recorded; of one run its own ±)"
    left_out = "; ".join(f"{name}: {why}" for name, why in series.left_out.items())
    return [Grid.of(rows, title), *([Note(f"Not in the statistics: {left_out}.")] if left_out else [])]


_MOST_NAMED = 8
_MARKERS = "osD^v<>P"
_WORST_SHARE = 0.1
"""An e known to no better than this would stretch the axis of all others."""


def speed_picture(groups: Mapping[str, Sequence[RunFacts]]) -> tuple[Picture, ...]:
    """Return the figure of e against the impact speed, one colour a group of runs; none without a valid impact."""
    points = {name: own for name, runs in groups.items() if (own := [one for run in runs for one in _points(run)])}
    return (Picture("restitution against impact speed", partial(_series_page, points)),) if points else ()


def _points(run: RunFacts) -> list[tuple[float, float, float]]:
    """Return speed before, e and its statistical u of the valid impacts; an e that is hardly known is left out."""
    return [
        (impact.speed_before_m_s, impact.e, impact.u_e)
        for impact in run.bounces.impacts
        if impact.valid and math.isfinite(impact.e) and impact.u_e < _WORST_SHARE * impact.e
    ]


def _series_page(points: Mapping[str, Sequence[tuple[float, float, float]]]) -> Figure:
    """Return the page: e with bars of two standard uncertainties against the speed before the impact."""
    figure = new_page()
    axes = add_axes(figure, 26.0, 32.0, 170.0, 100.0)
    axes.set_title("Coefficient of restitution of every valid impact, bars ± 2 u (statistical)")
    axes.set_xlabel("speed before the impact / (m/s)")
    axes.set_ylabel("e")
    for number, (name, own) in enumerate(points.items()):
        speed, e, u = zip(*own, strict=True)
        axes.errorbar(
            speed,
            e,
            yerr=[2.0 * one for one in u],
            fmt=_MARKERS[number % len(_MARKERS)],
            color=RECEIVER_COLOURS[number % len(RECEIVER_COLOURS)],
            markersize=3.0,
            elinewidth=0.6,
            capsize=1.5,
            capthick=0.6,
            label=name if number < _MOST_NAMED else None,
        )
    axes.margins(0.05, 0.1)
    axes.set_xlim(left=0.0)
    if len(points) <= _MOST_NAMED:
        legend(axes)
    return figure


_WORST_CONDITION = 100.0
"""From here an error of L may reach the position a hundredfold."""


def _setup_blocks(setup: Setup, *, recorded: bool = True, simulated: bool = False) -> list[Content]:
    """Return what the report says about the setup.

    Parameters
    ----------
    setup
        Of the session.
    recorded
        Whether the setup's device recorded: imported runs were digitised by something else, of which it knows nothing.
    simulated
        Whether no device recorded at all.
    """
    radar, tracer = setup.radar, setup.tracer
    rate = f"{setup.daq.rate_hz:g} samples per second and channel"
    release = ", ".join(f"{1e3 * x:g}" for x in tracer.release_position_m)
    floor, daq = setup.floor.height_m, setup.daq
    air = f" (n = {radar.refractive_index:g})" if radar.refractive_index else ", the air taken as vacuum"
    density = f", {tracer.density_kg_m3:g} kg/m³" if tracer.density_kg_m3 else ""
    diameter = _with_u(tracer.diameter_m, tracer.u_diameter_m, "mm", 1e3)
    inputs = f"{daq.device}: {', '.join(setup.physical_channels)}; {daq.terminal}, ±{daq.range_v:g} V"
    rows = {
        "Frequency, wavelength": f"{radar.frequency_hz / 1e9:g} GHz, {plain(radar.wavelength_m, 5, 'mm', 1e3)}{air}",
        "Sign of the phase": f"{radar.phase_sign:+d}",
        "Transmitter": _transmitter(setup.transmitter),
        "Sphere": f"{diameter} diameter, released at ({release}) mm{density}",
        "Floor": "found from the impacts" if floor is None else f"z = {plain(floor, 4, 'mm', 1e3)} at contact",
        "Acquisition": f"simulated, {rate}" if simulated else inputs if recorded else "",
        "Rate": f"{rate}, skew {plain(daq.channel_skew_s, 3, 'µs', 1e6)}" if recorded else "",
        "Processing": f"correction {setup.processing.correction}, geometry {setup.processing.geometry}",
    }
    blocks: list[Content] = [Facts.of(rows, "Setup"), _receivers(setup), *_calibration(setup)]
    if setup.n_receivers >= LEAST_RECEIVERS:
        blocks += _matrix(setup)
    return blocks


def _transmitter(transmitter: Transmitter) -> str:
    distance = transmitter.distance_m
    if distance is None:
        place = f"at ({', '.join(f'{1e3 * x:g}' for x in transmitter.place_m)}) mm"
    else:
        place = f"{_with_u(distance, transmitter.u_distance_m, 'mm', 1e3)} above the centre"
    if transmitter.polarization_deg is None:
        return f"{place}; polarisation not given: the sphere counts as a point"
    return f"{place}, polarised along {_with_u(transmitter.polarization_deg, transmitter.u_polarization_deg, '°')}"


def _with_u(value: float, u: float | None, unit: str = "", scale: float = 1.0) -> str:
    return quantity(value, u, unit, scale) if u else f"{value * scale:g} {unit}".strip()


def _receivers(setup: Setup) -> Grid:
    rows = (
        {
            "receiver": str(number),
            "tilt / °": _with_u(receiver.tilt_deg, receiver.u_tilt_deg),
            "azimuth / °": _with_u(receiver.azimuth_deg, receiver.u_azimuth_deg),
            "distance / mm": _with_u(receiver.distance_m, receiver.u_distance_m, scale=1e3),
        }
        for number, receiver in enumerate(setup.receiver, 1)
    )
    return Grid.of(rows, "Receivers")


def _calibration(setup: Setup) -> list[Content]:
    """Return the table of what a calibration found, and which of it is known only together."""
    content = setup.calibration.content
    if content is None or not content.names:
        return []
    covariance = np.array(content.covariance)
    u = np.sqrt(np.diag(covariance))
    rows = (
        {
            "parameter": setup_key(name),
            "unit": unit,
            "value ± u": quantity(value, own, scale=scale),
            "in the setup": plain(value_at(setup, name), 6, scale=scale),
        }
        for name, value, own in zip(content.names, content.values, u.tolist(), strict=True)
        for unit, scale in [unit_of(name)]
    )
    words = calibration_words(setup)
    said = f"{words[0].upper()}{words[1:]}: {content.reason.rstrip('.') or UNKNOWN}."
    edited = edited_since(setup)
    pairs = [f"{setup_key(a)} with {setup_key(b)}: {r:+.2f}" for a, b, r in correlations(covariance, content.names)]
    named = "; ".join(pairs[:_MOST_NAMED]) + (f" and {len(pairs) - _MOST_NAMED} more" * (len(pairs) > _MOST_NAMED))
    together = [Note(f"Correlated by more than {CORRELATED:g}: {named}.")] if pairs else []
    return [
        Note(said),
        Grid.of(rows, "Calibration", left=(0, 1)),
        *together,
        *([Note(f"{edited[0].upper()}{edited[1:]}.", warning=True)] if edited else []),
    ]


def _matrix(setup: Setup) -> list[Content]:
    antennas = place_antennas(setup)
    rows = tuple((str(number), *(f"{value:.5f}" for value in row)) for number, row in enumerate(t_matrix(antennas), 1))
    condition = condition_number(antennas)
    return [
        Grid(("receiver", "sin t cos a", "sin t sin a", "1 + cos t"), rows, "Matrix T (plane wave)"),
        Note(f"Condition number of T: {condition:.3f}", warning=condition > _WORST_CONDITION),
    ]
