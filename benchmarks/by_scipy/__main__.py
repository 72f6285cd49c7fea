"""``python -m benchmarks.by_scipy [NAME ...]``: examples beside `scipy.optimize.least_squares`.

Milliseconds of processor time on one thread, least of several runs: of a new instance with its data
and its solve (a whole loop where there is one), and of SciPy from the same start. Lines are those
of the model and of SciPy's functions without blank lines, comments and docstrings.
"""

from __future__ import annotations

import os

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import ast  # noqa: E402
import importlib  # noqa: E402
import inspect  # noqa: E402
import sys  # noqa: E402
from pathlib import Path  # noqa: E402
from types import ModuleType  # noqa: E402

from benchmarks.by_scipy import EXAMPLES  # noqa: E402
from benchmarks.recipes import least  # noqa: E402

NAMES = sorted(p.stem for p in Path(__file__).parent.glob("*.py") if not p.stem.startswith("_"))


def lines_of_model(module: ModuleType) -> int:
    """Lines of the model without blank ones and comments."""
    text = (EXAMPLES / module.MODEL).read_text(encoding="utf-8")
    return sum(bool(line.split("#")[0].strip()) for line in text.splitlines())


def lines_of_program(module: ModuleType) -> int:
    """Lines of SciPy's functions as Python prints them, without docstrings."""
    count = 0
    for function in module.PROGRAM:
        tree = ast.parse(inspect.getsource(function)).body[0]
        assert isinstance(tree, ast.FunctionDef)
        if ast.get_docstring(tree):
            tree.body = tree.body[1:]
        count += len(ast.unparse(tree).splitlines())
    return count


def measured(name: str) -> str:
    """A row of the table."""
    module = importlib.import_module(f"benchmarks.by_scipy.{name}")
    given = module.data()
    costs = module.by_arael(given), module.by_scipy(given)
    ours = least(lambda: module.by_arael(given), 7)
    beside = least(lambda: module.by_scipy(given), 2)
    return (
        f"| {name} | {lines_of_model(module)} | {lines_of_program(module)} | {1e3 * ours:.2f} | "
        f"{1e3 * beside:.0f} | {beside / ours:.0f} | {costs[0]:.6g} | {costs[1]:.6g} |"
    )


def main(names: list[str]) -> None:
    """Print the table."""
    print("| problem | model | program | arael [ms] | SciPy [ms] | ratio | cost | of SciPy |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for name in names or NAMES:
        print(measured(name), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
