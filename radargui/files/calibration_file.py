"""A calibration on the disk: JSON, replaced in one step."""

from pathlib import Path

from pydantic import TypeAdapter

from radargui.model.calibration import Calibration


def write_calibration(path: Path, calibration: Calibration) -> None:
    """Write a calibration."""
    fields = {name: getattr(calibration, name) for name in Calibration.__dataclass_fields__}
    fields = {name: value.tolist() if hasattr(value, "tolist") else value for name, value in fields.items()}
    path.write_bytes(TypeAdapter(dict).dump_json(fields, indent=1))
