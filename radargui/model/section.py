"""What all tables of the setup file share: they are immutable and refuse unknown keys and wrong types."""

from typing import Annotated, TypeAlias

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict
from pydantic_core import PydanticCustomError


class Section(BaseModel):
    """One table of the setup file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def _not_true_nor_a_decimal(value: object) -> object:
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    raise PydanticCustomError("literal_error", "a whole number is wanted")


ExactWhole = BeforeValidator(_not_true_nor_a_decimal)
"""Beside a Literal of whole numbers, which by itself takes true and 1.0 for 1."""
Real: TypeAlias = Annotated[float, Strict()]
Whole: TypeAlias = Annotated[int, Strict()]
Flag: TypeAlias = Annotated[bool, Strict()]
Text: TypeAlias = Annotated[str, Strict()]
Coordinate: TypeAlias = Annotated[float, Strict(), Field(ge=-10.0, le=10.0)]
Vector: TypeAlias = tuple[Coordinate, Coordinate, Coordinate]
"""A place in metres, x, y, z."""
