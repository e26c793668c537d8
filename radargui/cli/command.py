"""Make a command from a class of options; the docstring of the class is its help."""

import re
from copy import copy
from dataclasses import dataclass
from importlib import import_module
from inspect import Parameter, Signature, cleandoc, signature
from typing import Annotated, Any, dataclass_transform, get_args, get_origin

import typer
from typer import Option

app = typer.Typer(
    name="radargui",
    help="Record a particle-tracking radar, watch it live, and measure the restitution of a falling sphere.",
    epilog="Without a command the window opens.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)
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
    # a file that cannot be read is told by who reads it: of several the others are taken all the same
    option.readable = False
    annotated: Any = Annotated
    return field.replace(annotation=annotated[kind, option])


@dataclass_transform(frozen_default=True)
class Command:
    """A command: the fields of a class are its options, and what it says of itself and of them is the help.

    `does` is the module below `radargui.cli`, loaded when it is called, and the function in it that takes the options
    and returns the exit status.
    """

    def __init_subclass__(cls, does: str) -> None:
        module, _, function = does.partition(".")
        options_of = dataclass(frozen=True)(cls)

        def run(**options: Any) -> int:
            return int(getattr(import_module(f"radargui.cli.{module}"), function)(options_of(**options)))

        text, declared = described(options_of)
        # the library reads what it parses from the signature
        vars(run)["__signature__"] = declared
        app.command(cls.__name__.lower(), help=text)(run)
