"""Live expressions as programs with derivatives, for rows that follow geometry."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from arael.check.builtins import CONSTANTS as LANGUAGE_CONSTANTS
from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.handles import split_handle
from arael.sketch.expressions.evaluation import compiled
from arael.sketch.expressions.functions import CONSTANTS, GEOMETRY, TRIGONOMETRY
from arael.sketch.expressions.reading import chain, literal, path_of, read
from arael.sketch.expressions.refresh import follows_geometry
from arael.sketch.expressions.scope import DocumentScope
from arael.sketch.expressions.units import factor
from arael.syntax import tree

if TYPE_CHECKING:
    from arael.runtime.machine.tape import Tape

MAX_RESOLVED = 20_000
"""Characters of an expression with everything put in place."""

_PRECEDENCE = {"+": 1, "-": 1, "*": 2, "/": 2, "^": 3}
_PRECEDENCE |= dict.fromkeys(("<", "<=", ">", ">=", "==", "!="), 0)


class Program(NamedTuple):
    """An expression, its derivatives, and what they read.

    Attributes
    ----------
    tape : inputs are `geometry`, then `numbers`; outputs are the value, then its derivatives by
        each of `geometry`
    geometry : properties of entities (``L0.length``, ``P0.x``); angles in degrees
    numbers : parameters and dimensions that do not follow geometry
    """

    tape: Tape
    geometry: tuple[str, ...]
    numbers: tuple[str, ...]


def program(document: Document, text: str) -> Program:
    """A live expression as a program.

    Parameters and dimensions that follow geometry are put in place.

    Raises
    ------
    AraelError
        E1254: a function of geometry that has no derivative here (only `dist` of points or of a
        point and a line, and `angle`); E1260: too large; errors of reading.
    """
    return _program(resolved(document, text))


def resolved(document: Document, text: str) -> str:
    """An expression over properties and numbers alone, in the language of formulas."""
    found = _Resolver(document).text(text, 0)
    if len(found) > MAX_RESOLVED:
        raise _too_large()
    return found


@lru_cache(maxsize=2048)
def _program(text: str) -> Program:
    # imported here: start-up time
    from arael import sym
    from arael.sym.evaluation import Lowered

    try:
        # constants of the language are names of parameters here
        value = sym.parse(text, names={name: sym.symbol(name) for name in LANGUAGE_CONSTANTS})
    except AraelError:
        # its parts have been read: only their sum is too deep or too long
        raise _too_large() from None
    names = sym.free_vars(value)
    geometry = tuple(name for name in names if "." in name)
    numbers = tuple(name for name in names if "." not in name)
    outputs = [value, *(sym.diff(value, name) for name in geometry)]
    lowered = Lowered(outputs)
    return Program(lowered.graph.tape(lowered.roots, [*geometry, *numbers]), geometry, numbers)


def _too_large() -> AraelError:
    help_ = ("name parts of it by parameters that do not read geometry",)
    return AraelError(Diagnostic("E1260", "an expression that is too large to follow", help=help_))


class _Resolver:
    """Writes expressions out; parameters that follow geometry in place of their names."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.scope = DocumentScope(document)
        self.size = 0

    def text(self, text: str, depth: int) -> str:
        if depth > 100:
            raise _too_large()
        found = self._write(read(text).node, depth)
        self.size += len(found)
        if self.size > 10 * MAX_RESOLVED:
            raise _too_large()
        return found

    def _write(self, node: tree.Expr, depth: int) -> str:
        if isinstance(node, tree.Number):
            return self._number(node)
        path = path_of(node)
        if path:
            return self._path(path, depth)
        if isinstance(node, tree.Unary):
            return f"({node.op}{self._write(node.operand, depth)})"
        if isinstance(node, tree.Binary):
            return self._chain(node, depth)
        if isinstance(node, tree.Conditional):
            parts = (self._write(one, depth) for one in (node.cond, node.then, node.otherwise))
            return "(if {} then {} else {})".format(*parts)
        if isinstance(node, tree.Call) and isinstance(node.func, tree.Name):
            return self._call(node, node.func.id, depth)
        raise _unfollowed(node)

    def _chain(self, node: tree.Binary, depth: int) -> str:
        """Operations with brackets only where the order needs them: brackets have a depth."""
        first, links = chain(node)
        written = [self._write(first, depth)]
        before = _PRECEDENCE["^"]
        for link in links:
            binds = _PRECEDENCE[link.op]
            if len(written) > 1 and (binds > before or link.op == "^" or binds == 0):
                written = ["(", *written, ")"]
            written += [f" {link.op} ", self._write(link.right, depth)]
            before = binds
        return f"({''.join(written)})"

    def _number(self, node: tree.Number) -> str:
        if node.unit is None:
            return node.text
        unit = "in" if node.unit.text == "inch" else node.unit.text
        return f"({node.text} * {factor(unit, self.document.unit)!r})"

    def _path(self, path: str, depth: int) -> str:
        document = self.document
        record = document.parameters.get(path) or document.dimensions.get(path)
        if record is None:
            return repr(CONSTANTS[path]) if path in CONSTANTS else path
        parameter = document.parameters.get(path)
        amount = parameter.amount if parameter else document.dimensions[path].value
        if amount is None or (not parameter and document.dimensions[path].derived):
            return self._measured(path)
        if literal(amount.text) is None and follows_geometry(document, path):
            return f"({self.text(amount.text, depth + 1)})"
        return path

    def _measured(self, name: str) -> str:
        """A dimension that only measures, as the property that it shows."""
        dimension = self.document.dimensions[name]
        kind, args = dimension.kind, dimension.args
        if kind == "length":
            return f"{args[0]}.length"
        if kind in ("radius", "diameter", "radius_b", "sweep"):
            return f"{args[0]}.{kind}"
        if kind == "distance" and self._is_point(args[0]):
            return self._distance(*args)
        if kind in ("hdistance", "vdistance"):
            axis = "x" if kind == "hdistance" else "y"
            return f"abs({args[1]}.{axis} - {args[0]}.{axis})"
        help_ = ("read properties of the entities in its place",)
        message = f"`{name}` only measures a {kind}, which cannot be followed"
        raise AraelError(Diagnostic("E1254", message, help=help_))

    def _call(self, node: tree.Call, name: str, depth: int) -> str:
        if name in GEOMETRY:
            return self._geometric(node, name)
        args = [self._write(arg, depth) for arg in node.args]
        if name in TRIGONOMETRY and _is_angle(node.args[0], self.scope):
            args[0] = f"({args[0]} * {math.pi / 180.0!r})"
        if name in ("min", "max") and len(args) > 2:
            first, *others = args
            for one in others:
                first = f"{name}({first}, {one})"
            return first
        return f"{name}({', '.join(args)})"

    def _geometric(self, node: tree.Call, name: str) -> str:
        args = [path_of(arg) for arg in node.args]
        if name == "dist" and len(args) == 2 and all(args):
            if not self._is_point(args[0]):
                args.reverse()
            if self._is_point(args[0]) and (self._is_point(args[1]) or self._is_line(args[1])):
                return self._distance(*args)
        if name == "angle" and len(args) == 2 and all(map(self._is_line, args)):
            (ux, uy), (vx, vy) = map(_direction, args)
            cross, dot = f"({ux} * {vy} - {uy} * {vx})", f"({ux} * {vx} + {uy} * {vy})"
            return f"(atan2({cross}, {dot}) * {180.0 / math.pi!r})"
        raise _unfollowed(node)

    def _distance(self, point: str, other: str) -> str:
        if self._is_point(other):
            dx, dy = f"({point}.x - {other}.x)", f"({point}.y - {other}.y)"
            return f"safe_sqrt({dx}^2 + {dy}^2)"  # has a derivative at 0
        ux, uy = _direction(other)
        cross = f"({ux} * ({point}.y - {other}.p1.y) - {uy} * ({point}.x - {other}.p1.x))"
        return f"(abs({cross}) / {other}.length)"

    def _is_point(self, path: str) -> bool:
        parts = split_handle(path)
        entity = self.document.entities.get(parts.name) if parts else None
        return bool(parts and entity and (parts.point or entity.kind == "point"))

    def _is_line(self, path: str) -> bool:
        entity = self.document.entities.get(path)
        return entity is not None and entity.kind == "line"


def _is_angle(node: tree.Expr, scope: DocumentScope) -> bool:
    """Whether a part of an expression is an angle in degrees."""
    return compiled(node.span.text).quantity(scope) == "angle"


def _direction(line: str) -> tuple[str, str]:
    return f"({line}.p2.x - {line}.p1.x)", f"({line}.p2.y - {line}.p1.y)"


def _unfollowed(node: tree.Expr) -> AraelError:
    help_ = ("put `=` before the value to take what it is now",)
    message = f"`{node.span.text[:60]}` cannot be followed while the geometry moves"
    return AraelError(Diagnostic("E1254", message, node.span, help=help_))
