"""What all tables of the setup file share: immutable, no unknown key, numbers are numbers."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, Strict


class Section(BaseModel):
    """One table of the setup file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


Real: TypeAlias = Annotated[float, Strict()]
Whole: TypeAlias = Annotated[int, Strict()]
Flag: TypeAlias = Annotated[bool, Strict()]
Text: TypeAlias = Annotated[str, Strict()]
Coordinate: TypeAlias = Annotated[float, Strict(), Field(ge=-10.0, le=10.0)]
Vector: TypeAlias = tuple[Coordinate, Coordinate, Coordinate]
"""A place in metres, x, y, z."""
