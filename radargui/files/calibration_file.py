"""A calibration on the disk: JSON, replaced in one step."""

import json
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from radargui.model.calibration import Calibration, Origin, Residual

_ARRAYS = ("before", "values", "u_before", "covariance")


def write_calibration(path: Path, calibration: Calibration) -> None:
    """Write a calibration."""
    fields = {name: getattr(calibration, name) for name in Calibration.__dataclass_fields__}
    fields |= {name: fields[name].tolist() for name in _ARRAYS}
    partial = path.with_name(path.name + ".part")
    partial.write_bytes(TypeAdapter(dict).dump_json(fields, indent=1))
    partial.replace(path)


def read_calibration(path: Path) -> Calibration:
    """Return a calibration."""
    fields = json.loads(path.read_bytes())
    fields |= {name: np.array(fields[name]) for name in _ARRAYS}
    fields |= {name: tuple(fields[name]) for name in ("names", "undetermined", "notes")}
    origin = fields["origin"] | {"known": tuple(fields["origin"]["known"])}
    return Calibration(
        **fields | {"origin": Origin(**origin), "residuals": tuple(Residual(**one) for one in fields["residuals"])}
    )
