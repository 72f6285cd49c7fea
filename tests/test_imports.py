"""Imports point one way: from the language to the solver's data, never in a circle.

Between packages every import counts, also in functions and for types only; within a package those
that are executed.
"""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections import defaultdict
from collections.abc import Iterable

import pytest

from tests import import_graph
from tests.import_graph import FACADE, Edge, circles, edges, imports_of, modules, package

# The circles that are left, each within one package.
KNOWN = {
    # An error prints itself with excerpts of its sources.
    ("arael.diagnostics.records", "arael.diagnostics.render", "arael.diagnostics.window"),
    # A field of a row may be a collection, an item of which is a row.
    (
        "arael.face.collection",
        "arael.face.fields",
        "arael.face.given",
        "arael.face.ref",
        "arael.face.ref_list",
    ),
}

# Packages without a circle even where imports for types only count.
STRICT = (
    "analysis",
    "check",
    "cli",
    "compiler",
    "fitting",
    "io",
    "metrics",
    "plot",
    "residuals",
    "starts",
    "syntax",
)

# What a package may import of arael, as in the table of the design: nothing else is known to it.
DATA = {"diagnostics", "config", "statuses", "result"}
MAY_IMPORT = {
    "diagnostics": set[str](),
    "operations": set[str](),
    "display": set[str](),
    "syntax": {"diagnostics"},
    "symbolic": {"diagnostics", "operations", "runtime"},
    "manifolds": {"symbolic"},
    "check": {*DATA, "manifolds", "operations", "runtime", "symbolic", "syntax"},
    "compiler": {
        *DATA,
        "check",
        "manifolds",
        "operations",
        "runtime",
        "symbolic",
        "syntax",
        "version",
    },
    "runtime": {*DATA, "operations"},
    "io": {*DATA, "runtime", "starts"},
    "metrics": {"diagnostics", "io", "runtime"},
    "analysis": {*DATA, "display", "geometry", "runtime", "symbolic"},
    "certificates": {
        *DATA,
        "check",
        "compiler",
        "display",
        "geometry",
        "runtime",
        "symbolic",
        "syntax",
    },
    "geometry": {"diagnostics"},
    "scenes": {"geometry", "runtime"},
    "starts": {*DATA, "runtime", "session", "solving"},
    "plot": {*DATA, "io", "runtime"},
    "fitting": {
        *DATA,
        "analysis",
        "compiled_model",
        "compiler",
        "display",
        "io",
        "model",
        "plot",
        "runtime",
        "sym",
        "syntax",
    },
    "face": {*DATA, "analysis", "display", "io", "runtime"},
    "sym": {*DATA, "check", "compiler", "operations", "runtime", "symbolic", "syntax"},
    "windows": {
        *DATA,
        "analysis",
        "face",
        "geometry",
        "io",
        "online",
        "residuals",
        "runtime",
        "session",
        "solving",
    },
    "calculator": {*DATA, "check", "sym", "syntax"},
    "residuals": {*DATA, "check", "compiled_model", "compiler", "face", "runtime", "syntax"},
}


# Packages of the sketch editor, each with those below it that it may import.
SKETCH_MAY_IMPORT = {
    "geometry": set[str](),
    "document": {"geometry"},
    "expressions": {"document", "geometry"},
    "layout": {"document", "expressions", "geometry"},
    "solve": {"document", "layout"},
    "judge": {"document", "layout", "solve"},
    "editing": {"document", "expressions", "geometry", "judge", "layout", "solve"},
}


def own(found: Iterable[Edge]) -> list[Edge]:
    """The imports of arael's modules, but for those of and by the facade."""
    names = {edge.source for edge in found} | set(modules())
    return [
        edge
        for edge in found
        if edge.target.startswith("arael.") or edge.target in names
        if FACADE not in (edge.source, edge.target)
    ]


def graph_of(found: Iterable[Edge]) -> dict[str, set[str]]:
    graph: dict[str, set[str]] = defaultdict(set)
    for edge in found:
        if edge.source != edge.target:
            graph[edge.source].add(edge.target)
    return graph


def test_no_circle_of_packages() -> None:
    every = [*own(edges()), *own(import_graph.cython_imports())]
    graph: dict[str, set[str]] = defaultdict(set)
    for edge in every:
        if package(edge.source) != package(edge.target):
            graph[package(edge.source)].add(package(edge.target))
    assert circles(graph) == []


def test_at_most_two_circles_of_modules() -> None:
    graph = graph_of(edge for edge in own(edges()) if not edge.typing)
    assert set(circles(graph)) <= KNOWN
    assert len(KNOWN) <= 2
    assert all(len({package(name) for name in circle}) == 1 for circle in KNOWN)


@pytest.mark.parametrize("name", STRICT)
def test_no_circle_even_of_types(name: str) -> None:
    inner = (e for e in own(edges()) if package(e.source) == package(e.target) == f"arael.{name}")
    assert circles(graph_of(inner)) == []


@pytest.mark.parametrize("name", sorted(MAY_IMPORT))
def test_a_package_imports_only_what_it_may_know(name: str) -> None:
    found = [
        str(edge)
        for edge in (*own(edges()), *own(import_graph.cython_imports()))
        if package(edge.source) == f"arael.{name}" != package(edge.target)
        if package(edge.target).removeprefix("arael.") not in MAY_IMPORT[name]
    ]
    assert found == []


@pytest.mark.parametrize("name", sorted(SKETCH_MAY_IMPORT))
def test_a_package_of_sketches_imports_only_those_below_it(name: str) -> None:
    sketch = "arael.sketch."
    found = [
        str(edge)
        for edge in own(edges())
        if edge.source.startswith(f"{sketch}{name}.") and edge.target.startswith(sketch)
        if edge.target.split(".")[2] not in {name, *SKETCH_MAY_IMPORT[name]}
    ]
    assert found == []


LANGUAGE = ("arael.check", "arael.compiler", "arael.manifolds", "arael.symbolic")


def test_the_compiler_knows_nothing_of_solving() -> None:
    """It shares the layout, tapes and the table of operations with the runtime."""
    shared = ("layout", "library", "operations", "relocation", "tape")
    for edge in own(edges()):
        language = package(edge.source) in LANGUAGE
        if language and package(edge.target) == "arael.runtime":
            assert edge.target.rpartition(".")[2].startswith(shared), str(edge)


def test_nothing_but_the_entry_point_imports_the_commands() -> None:
    users = {edge.source for edge in own(edges()) if package(edge.target) == "arael.cli"}
    assert {package(name) for name in users} <= {"arael.cli", "arael.__main__"}


def test_imports_in_functions_state_their_reason() -> None:
    """Start-up time, or one of the known circles."""
    in_circles = {name for circle in KNOWN for name in circle}
    for edge in edges():
        if edge.inside and not edge.typing:
            allowed = "start-up time" in edge.reason or (
                "circle" in edge.reason and edge.source in in_circles
            )
            assert allowed, f"{edge}: write `{import_graph.REASON}: start-up time`, or move it up"


def test_the_reader_of_imports() -> None:
    text = (
        "from typing import TYPE_CHECKING\n"
        "import numpy as np\n"
        "if TYPE_CHECKING:\n"
        "    from arael.check.typed import Typed\n"
        "def f():\n"
        '    """Doc."""\n'
        "    # imported here: start-up time\n"
        "    import re\n"
        "\n"
        "    from arael.check import typed\n"
        "    if re:\n"
        "        import os\n"
    )
    found = {edge.target: edge for edge in imports_of(text, "arael.one")}
    assert set(found) == {"typing", "numpy", "arael.check.typed", "re", "os"}
    assert [e.typing for e in imports_of(text, "x") if e.target == "arael.check.typed"] == [
        True,
        False,
    ]
    assert not found["numpy"].inside and found["os"].inside
    assert found["re"].reason == found["os"].reason == "# imported here: start-up time"
    (bare,) = imports_of("def f():\n    x = 1  # imported here: no\n    import re\n", "x")
    assert bare.inside and bare.reason == ""


def test_circles_are_found() -> None:
    graph = {"a": ["b"], "b": ["c"], "c": ["a", "d"], "d": ["e"], "e": ["d"], "f": ["f"]}
    assert circles(graph) == [("a", "b", "c"), ("d", "e")]


# Uses of `id()` that are not keys of caches: the hash of a handle of a table.
IDENTITIES = {"arael.face.ref": 1}


@pytest.mark.parametrize("name", sorted({package(one) for one in modules()}))
def test_no_cache_is_keyed_by_id(name: str) -> None:
    """A key outlives what it was the `id` of; nodes are keys themselves."""
    for module, path in modules().items():
        if package(module) == name:
            calls = [
                node
                for node in ast.walk(ast.parse(path.read_text()))
                if isinstance(node, ast.Call) and ast.unparse(node.func) == "id"
            ]
            assert len(calls) == IDENTITIES.get(module, 0), module


START = {
    "import arael": 4,
    "from arael.cli.main import run; run(['--help'])": 16,
    "import arael; arael.load('linear')": 165,
}


@pytest.mark.parametrize("code", START)
def test_start_up_imports_no_more_modules_of_arael_than_it_needs(code: str) -> None:
    script = f"import sys\n{code}\nfound = [m for m in sys.modules if m.split('.')[0] == 'arael']"
    script += "\nimport json; print(json.dumps(found), file=sys.stderr)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stderr.splitlines()[-1])
    assert len(found) <= START[code], sorted(found)


def test_a_solve_imports_no_large_module_that_it_does_not_need() -> None:
    """Each takes a tenth of the time of `arael solve` of a file or more."""
    script = (
        "import arael, sys\n"
        "model = arael.load('pose_graph_2d')()\n"
        "u = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
        "for k in range(40): model.poses.append(t=[k, 0], th=0)\n"
        "for k in range(39): model.edges.append(a=k, b=k + 1, t=[1, 0], th=0.1, u=u)\n"
        "model.anchors.append(pose=0, t=[0, 0], th=0, u=u)\n"
        "print(model.solve())\n"
        "print([m for m in ('numpy.ma', 'scipy.sparse', 'sympy', 'lark') if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_lark_is_used_by_its_public_names_only() -> None:
    """The tables of its parsers come from what it stores of them, not from its attributes."""
    public = {"lark.Lark", "lark.grammar.Rule", "lark.lexer.PatternStr", "lark.lexer.TerminalDef"}
    for module, path in modules().items():
        text = path.read_text()
        if "lark" not in text and not module.startswith("arael.syntax"):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "lark":
                assert {f"{node.module}.{alias.name}" for alias in node.names} <= public, module
            if module.startswith("arael.syntax") and isinstance(node, ast.Attribute):
                private = node.attr.startswith("_") and not node.attr.startswith("__")
                own_ = ast.unparse(node.value) in ("self", "cls", "super()")
                assert own_ or not private, f"{module}: {ast.unparse(node)}"
