"""The data files of a command: one or several, with their format and fields."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import click

import arael
from arael.cli.guess import Guess
from arael.io import formats
from arael.io.files import shown
from arael.io.several import read_several, split

F = TypeVar("F", bound=Callable[..., Any])


def data_options(function: F) -> F:
    """Add ``--format``, ``--collection``, ``--fields`` and ``--information``."""
    for option in (
        click.option(
            "--information",
            metavar="POSITION[,ROTATION]",
            callback=_information,
            help="Information of g2o measurements that give none, as 100 or 100,400.",
        ),
        click.option(
            "--fields",
            metavar="PART=FIELD,...",
            callback=_fields,
            help="Fields of a trajectory's poses, as position=pos,rotation=att.",
        ),
        click.option(
            "--collection",
            metavar="NAME",
            help="The collection of a single DATA file, and of a trajectory that -o writes.",
        ),
        click.option(
            "--format",
            "format",
            type=click.Choice(list(formats.FORMATS)),
            metavar="FORMAT",
            help="Format of DATA, in place of that of its ending or content.",
        ),
    ):
        function = option(function)
    return function


def _fields(
    context: click.Context, option: click.Parameter, text: str | None
) -> dict[str, str] | None:
    """``position=pos,rotation=att`` as a dict."""
    if text is None:
        return None
    found = {}
    for part in text.split(","):
        what, sign, field = (word.strip() for word in part.partition("="))
        if not (what and sign and field):
            raise click.BadParameter(f"expected PART=FIELD, found '{part}'")
        found[what] = field
    return found


def _information(
    context: click.Context, option: click.Parameter, text: str | None
) -> tuple[float, float] | None:
    """``100`` or ``100,400`` as two numbers."""
    if text is None:
        return None
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = []
    if len(found) not in (1, 2) or not all(0 < value < math.inf for value in found):
        raise click.BadParameter(f"expected one or two positive numbers, found '{text}'")
    return found[0], found[-1]


def model_with_data(
    guess: Guess,
    format: str | None,
    collection: str | None,
    fields: dict[str, str] | None,
    information: tuple[float, float] | None,
    precision: Any = None,
    quiet: bool = False,
) -> Any:
    """An instance of the guessed model with its data; what was guessed is said unless `quiet`."""
    if not quiet:
        guess.announce()
    kind: Any = arael.load(guess.model, precision=precision)
    instance = kind()
    read_data(instance, guess.data, format, collection or guess.collection, fields, information)
    return instance


def read_data(
    instance: Any,
    data: Sequence[str],
    format: str | None = None,
    collection: str | None = None,
    fields: dict[str, str] | None = None,
    information: tuple[float, float] | None = None,
) -> None:
    """Read the data files of a command into a model.

    Raises
    ------
    AraelError
        As `arael.read`; E0727 for two files of the same data.
    """
    named = [split(argument) for argument in data]
    if len(data) == 1:
        name, path = named[0]
        arael.read(
            instance,
            path,
            format,
            collection=name or collection,
            fields=fields,
            information=information,
        )
        return
    if information is not None:
        raise click.UsageError("--information is for one data file")
    if collection is not None:
        raise click.UsageError("--collection is for one data file; of several write name=path")
    read_several(instance, [(name, path) for name, path in named], format, fields=fields)


def joined(data: Sequence[str]) -> str:
    """The files for a report."""
    return ", ".join(data)


def named(data: Sequence[str]) -> str:
    """The names of the files without their folders, for a title."""
    return ", ".join(shown(os.path.basename(path.rstrip("/"))) for path in data)
