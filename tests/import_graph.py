"""The imports of arael's modules, read from their source."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FACADE = "arael"
"""``arael/__init__.py`` imports nothing but on demand, and stands for every package."""

REASON = "# imported here"


@dataclass(frozen=True)
class Edge:
    """One import: by which module, of which module, at which line.

    `inside` a function; `typing`: under ``if TYPE_CHECKING``, so never executed; `reason`: the
    comment of an import in a function, "" without one.
    """

    source: str
    target: str
    line: int
    inside: bool = False
    typing: bool = False
    reason: str = ""

    def __str__(self) -> str:
        return f"{self.source}:{self.line} imports {self.target}"


@cache
def modules() -> dict[str, Path]:
    """Python modules of arael by name."""
    return {_name(path): path for path in sorted((ROOT / "arael").rglob("*.py"))}


def _name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def edges() -> tuple[Edge, ...]:
    """Every import of Python modules, also of other libraries."""
    return tuple(
        edge for name, path in modules().items() for edge in imports_of(path.read_text(), name)
    )


def imports_of(text: str, name: str) -> list[Edge]:
    """The imports of the module `name`, whose source is `text`."""
    lines = text.splitlines()
    found: list[Edge] = []

    def visit(body: Iterable[ast.AST], inside: bool, typing: bool, start: int = 1) -> None:
        for node in body:
            if isinstance(node, ast.Import | ast.ImportFrom):
                reason = _reason(lines[start - 1 : node.lineno - 1])
                for target in _targets(node):
                    found.append(Edge(name, target, node.lineno, inside, typing, reason))
                continue
            function = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            for field, value in ast.iter_fields(node):
                children = value if isinstance(value, list) else [value]
                visit(
                    [child for child in children if isinstance(child, ast.AST)],
                    inside or function,
                    typing or (field == "body" and _is_type_checking(node)),
                    node.lineno if function else start,  # type: ignore[attr-defined]
                )

    visit(ast.parse(text).body, inside=False, typing=False)
    return found


def _reason(lines: Iterable[str]) -> str:
    """The comment on imports among the lines of a function before one; "" without one."""
    comments = " ".join(line.strip() for line in lines if line.strip().startswith("#"))
    return comments if REASON in comments.lower() else ""


def _is_type_checking(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING")


def _targets(node: ast.Import | ast.ImportFrom) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
        return
    assert node.module and not node.level, "relative import"
    for alias in node.names:
        inner = f"{node.module}.{alias.name}"
        yield inner if inner in modules() else node.module


@cache
def cython_imports() -> tuple[Edge, ...]:
    """Imports and cimports of arael's modules by Cython modules and the files that they include."""
    found = []
    for path in sorted((ROOT / "arael").rglob("*.p[yx][xdi]")):
        if path.suffix not in (".pyx", ".pxd", ".pxi"):
            continue
        for number, line in enumerate(path.read_text().splitlines(), start=1):
            match = re.match(r" *(?:from|import|cimport) +(arael[\w.]*)", line)
            if match:
                found.append(Edge(_name(path), match[1], number))
    return tuple(found)


def package(module: str) -> str:
    """The folder below `arael` that holds a module; a module at the top stands for itself."""
    return ".".join(module.split(".")[:2])


def circles(graph: Mapping[str, Iterable[str]]) -> list[tuple[str, ...]]:
    """Strongly connected components of more than one node (Tarjan)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[tuple[str, ...]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for target in graph.get(node, ()):
            if target not in index:
                visit(target)
                low[node] = min(low[node], low[target])
            elif target in stack:
                low[node] = min(low[node], index[target])
        if low[node] == index[node]:
            at = stack.index(node)
            component = tuple(sorted(stack[at:]))
            del stack[at:]
            if len(component) > 1:
                found.append(component)

    for node in graph:
        if node not in index:
            visit(node)
    return sorted(found)
