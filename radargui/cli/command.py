"""The help of a command, from what its class of options says of itself."""

import re
from copy import copy
from inspect import Parameter, Signature, cleandoc, signature
from typing import Annotated, Any, get_args, get_origin

from typer import Option

_FIELD = re.compile(r"^(\w+)(?: : (.+))?\n((?: {4}.+\n?)+)", re.MULTILINE)


def described(options: type) -> tuple[str, Signature]:
    """Return a command's help and its signature, each option with its help and what stands for its value."""
    text, _, fields = cleandoc(options.__doc__ or "").partition("\n\nAttributes\n----------\n")
    said = {name: (shown, " ".join(words.split())) for name, shown, words in _FIELD.findall(fields)}
    declared = signature(options)
    parameters = [_with_help(one, *said.get(one.name, ("", ""))) for one in declared.parameters.values()]
    return text, declared.replace(parameters=parameters)


def _with_help(field: Parameter, shown: str, words: str) -> Parameter:
    """Return a field as the library reads it, with its help and what stands for its value; a flag has no --no-."""
    kind, *given = get_args(field.annotation) if get_origin(field.annotation) is Annotated else (field.annotation,)
    option = copy(given[0]) if given else Option(f"--{field.name.replace('_', '-')}")
    option.help, option.metavar = words or option.help, shown or option.metavar
    annotated: Any = Annotated
    return field.replace(annotation=annotated[kind, option])
