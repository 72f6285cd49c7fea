"""The model that a data file is for, where the command names none."""

from __future__ import annotations

import glob
import os
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

import arael
from arael.diagnostics.model_warnings import DataWarning
from arael.diagnostics.records import AraelError, Diagnostic
from arael.io import files, formats
from arael.io.several import split
from arael.loading import standard_models

BUNDLES = ("bal", "bundler", "colmap")
SPATIAL = re.compile(rb"SE3|XYZ|^\s*(VERTEX|EDGE)3\b", re.MULTILINE)


@dataclass(frozen=True)
class Guess:
    """Model and data of a command.

    Attributes
    ----------
    model : name or file
    data : the files
    reason : why this model, in words; "" if the command names it
    collection : that the rows of a table fill; None: as the command says
    """

    model: str
    data: tuple[str, ...]
    reason: str = ""
    collection: str | None = None

    def announce(self) -> None:
        """Say on stderr which model was found, and why."""
        if self.reason:
            click.echo(f"model: {self.model}, {self.reason}", err=True)


def model_and_data(arguments: Sequence[str], format: str | None = None) -> Guess:
    """Model and data files of ``[MODEL] DATA...``.

    The first argument is a data file if it exists or has the ending of one, and is no ``.arael``
    file and no standard model.

    Raises
    ------
    AraelError
        E0859: no model is found for the file; the errors of reading it.
    """
    first = arguments[0]
    if not _is_data(first):
        return Guess(first, tuple(arguments[1:]))
    name, path = split(first)
    found = sorted(glob.glob(path)) if not os.path.exists(path) else []
    guess = _guess(found[0] if found else path, name, format)
    return Guess(guess.model, tuple(arguments), guess.reason, guess.collection)


def _is_data(argument: str) -> bool:
    _, path = split(argument)
    if path.endswith(".arael") or argument in standard_models():
        return False
    ending = os.path.splitext(path.lower().removesuffix(".gz"))[1]
    return os.path.exists(path) or ending in formats.EXTENSIONS


def _guess(path: str, collection: str | None, format: str | None) -> Guess:
    stem = Path(path.removesuffix(".gz")).with_suffix(".arael")
    if stem.is_file():
        return Guess(str(stem), (), "the file of that name beside the data")
    content, found = formats.load(path, format)
    if is_sketch(content):
        help = f"`arael sketch {files.shown(path)}` solves and edits it, `arael show` draws it"
        raise _unknown(path, "the file holds a sketch, which is solved with each edit", help)
    if found in formats.GRAPHS or found in BUNDLES:
        model = model_of_format(found, content)
        what = "tags" if found in formats.GRAPHS else "format"
        return Guess(model, (), f"by its {what} ({found})")
    if found in formats.TRAJECTORIES:
        raise _unknown(
            path,
            f"the file holds a trajectory ({found}), and no measurements to solve with",
            "`arael show` draws it, `arael metrics` compares it with another; with a model of "
            "your own: arael solve MODEL.arael DATA",
        )
    return _by_content(path, collection, format, found)


def is_sketch(content: bytes) -> bool:
    """Whether a file holds a drawing of the sketch editor."""
    return re.match(rb'\s*\{\s*"format":\s*"arael-sketch"', content) is not None


def model_of_format(found: str, content: bytes) -> str:
    """The standard model of a graph or of a bundle adjustment."""
    if found in BUNDLES:
        return "bundle_adjustment"
    return "pose_graph_3d" if SPATIAL.search(content[:65536]) else "pose_graph_2d"


def _by_content(path: str, collection: str | None, format: str | None, found: str) -> Guess:
    """The only standard model that can read the file and has residuals then."""
    fitting: list[tuple[str, str | None]] = []
    for name in standard_models():
        kind: Any = arael.load(name, interpret=True)
        tables = [t.path for t in kind.layout.tables if t.path and not t.parent]
        table = found in formats.ONE_COLLECTION
        for one in [collection] if collection or not table else tables:
            if _fits(kind(), path, format, one):
                fitting.append((name, one))
    columns = "columns" if found in formats.ONE_COLLECTION else "fields"
    if len(fitting) == 1:
        name, one = fitting[0]
        where = f" of `{one}`" if one else ""
        return Guess(name, (), f"by its {columns}: they are those{where}", one)
    if fitting:
        listed = " or ".join(f"`{name}`" for name, _ in fitting)
        raise _unknown(path, f"the file fits several models, {listed}", "name one before the file")
    beside = sorted(Path(path).resolve().parent.glob("*.arael"))
    if beside:
        names = " or ".join(f"arael solve {one.name} {files.shown(path)}" for one in beside[:3])
        raise _unknown(path, f"no standard model has the {columns} of this file", names)
    fit = "; `arael fit FORMULA DATA` needs no model" if found == "csv" else ""
    raise _unknown(
        path,
        f"no standard model has the {columns} of this file",
        f"name the model: arael solve MODEL.arael {files.shown(path)}; `arael new` writes one{fit}",
    )


def _fits(instance: Any, path: str, format: str | None, collection: str | None) -> bool:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DataWarning)  # something has no field
            arael.read(instance, path, format, collection=collection)
        return bool(sum(instance.cost_table().residuals.values()))
    except (AraelError, DataWarning):
        return False


def _unknown(path: str, message: str, help: str) -> AraelError:
    return AraelError(Diagnostic("E0859", message, origin=files.shown(path), help=(help,)))
