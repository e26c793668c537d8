"""Export to NI TDMS: codes with NI's own scaling properties, values as they are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from radargui.files.export_facts import ExportFacts
from radargui.files.progress import Progress
from radargui.files.run_stream import RunStream

FACTS = "RadarGUI"
"""Property of the file that holds all facts as TOML."""
_LINEAR = 2


def write_tdms(run: RunStream, path: Path, tell: Progress) -> None:
    """Write one group of the run's name with one channel each; LabVIEW and DIAdem show volts at their times.

    NI_Scale properties turn codes into volts, wf_increment and wf_start_time give the times. TDMS has no record of
    lost samples: they stand in the property `RadarGUI` of the file, as all facts do.
    """
    from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

    facts = run.facts
    group = facts.name
    names = facts.digitisation.channel_names
    properties = [_properties(facts, place) for place in range(len(names))]
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                RootObject({"name": facts.name, FACTS: facts.text()}),
                GroupObject(group, dict(facts.session)),
                *(ChannelObject(group, name, None, own) for name, own in zip(names, properties, strict=True)),
            ]
        )
        for piece in run.pieces(tell):
            writer.write_segment(
                [ChannelObject(group, name, np.ascontiguousarray(row)) for name, row in zip(names, piece, strict=True)]
            )


def _properties(facts: ExportFacts, place: int) -> dict[str, Any]:
    known = facts.digitisation
    properties: dict[str, Any] = {
        "wf_increment": 1.0 / known.sample_rate_hz,
        "wf_start_offset": 0.0,
        "wf_samples": 1,
        "unit_string": known.unit,
    }
    if known.channel_skew_s is not None:
        properties["channel_skew_s"] = known.channel_skew_s
    if (start := facts.started_utc()) is not None:
        properties["wf_start_time"] = np.datetime64(start, "us")
    if known.scaling is not None:
        properties |= _scale(known.scaling[place])
    return properties


def _scale(coefficients: tuple[float, ...]) -> dict[str, Any]:
    scale: dict[str, Any] = {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 1}
    if len(coefficients) <= _LINEAR:
        offset, slope = (*coefficients, 0.0)[:2]
        scale |= {
            "NI_Scale[0]_Scale_Type": "Linear",
            "NI_Scale[0]_Linear_Slope": slope,
            "NI_Scale[0]_Linear_Y_Intercept": offset,
            "NI_Scale[0]_Linear_Input_Source": np.uint32(0xFFFFFFFF),
        }
        return scale
    scale |= {
        "NI_Scale[0]_Scale_Type": "Polynomial",
        "NI_Scale[0]_Polynomial_Coefficients_Size": np.uint32(len(coefficients)),
        "NI_Scale[0]_Polynomial_Input_Source": np.uint32(0xFFFFFFFF),
    }
    return scale | {f"NI_Scale[0]_Polynomial_Coefficients[{k}]": value for k, value in enumerate(coefficients)}
