"""`arael emit`: print the output of a compiler stage."""

from __future__ import annotations

import tempfile
from pathlib import Path

import click

from arael.cli.outline import outline, programs
from arael.compiler import compiler
from arael.compiler.build import cython_to_c
from arael.compiler.compilation import compile_text
from arael.compiler.imports import Imports
from arael.compiler.kernels import module_name
from arael.diagnostics.records import Findings
from arael.loading import find_model
from arael.syntax.files import read_source

STAGES = ("ast", "types", "sympy", "ir", "pyx", "c")


@click.command("emit", short_help="Print a stage of the compiler.")
@click.argument("model")
@click.option("--stage", type=click.Choice(STAGES), default="pyx", show_default=True)
@click.option("--precision", type=click.Choice(["f32", "f64"]), help="Overrides that of the root.")
@click.option("--constraint", metavar="NAME", help="Only this one, with --stage sympy: Pose.gps.")
@click.option("--latex", is_flag=True, help="Print LaTeX, with --stage sympy.")
def command(
    model: str, stage: str, precision: str | None, constraint: str | None, latex: bool
) -> None:
    """Print the output of a compiler stage for MODEL.

    ast: the tree of the text; types: names and shapes resolved; sympy: values, derivatives and
    shared subexpressions in SymPy; ir: residuals and derivatives as straight-line
    programs; pyx: the Cython source; c: the C source.
    """
    if stage == "sympy":
        click.echo(_sympy(find_model(model), precision, constraint, latex))
        return
    for given, option in ((constraint, "--constraint"), (latex, "--latex")):
        if given:
            raise click.UsageError(f"{option} needs --stage sympy, found --stage {stage}")
    click.echo(_STAGES[stage](find_model(model), precision))


def _ast(path: Path, precision: str | None) -> str:

    return outline(compiler.syntax(read_source(path)))


def _types(path: Path, precision: str | None) -> str:

    tree = compiler.syntax(read_source(path))
    return outline(compiler.types(tree, Findings(), None, Imports()))


def _sympy(path: Path, precision: str | None, constraint: str | None, latex: bool) -> str:
    # imported here: start-up time
    from arael.cli.formulas import formulas

    tree = compiler.syntax(read_source(path))
    model = compiler.types(tree, Findings(), None, Imports())
    return formulas(model, precision, constraint, latex)


def _ir(path: Path, precision: str | None) -> str:

    return programs(compile_text(read_source(path), precision=precision).program)


def _pyx(path: Path, precision: str | None) -> str:

    return compile_text(read_source(path), precision=precision).emit()


def _c(path: Path, precision: str | None) -> str:

    with tempfile.TemporaryDirectory(prefix="arael-") as folder:
        pyx = Path(folder) / f"{module_name(path.stem)}.pyx"
        pyx.write_text(_pyx(path, precision), encoding="utf-8")
        return cython_to_c(pyx).read_text(encoding="utf-8")


_STAGES = {"ast": _ast, "types": _types, "ir": _ir, "pyx": _pyx, "c": _c}
