"""The syntax tree of a `.arael` file: the source with places, nothing resolved.

Every node carries its span. Documentation comments (the comment block right above an item, field or
constraint) are kept as text without their ``#``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from arael.diagnostics.records import Source, Span


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node with its place in the text."""

    span: Span = field(compare=False, repr=False)


# --- expressions ------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Number(Node):
    """A number as written; `text` distinguishes ``1e-3`` from ``0.001`` and ``1`` from ``1.0``.

    It may have a unit: ``9.81 [m/s^2]``.
    """

    text: str
    unit: Unit | None = None

    @property
    def value(self) -> float:
        """The number as a float."""
        return float(self.text)

    @property
    def is_integer(self) -> bool:
        """Return whether it is written without point and exponent."""
        return self.text.isdigit()


@dataclass(frozen=True, kw_only=True)
class Boolean(Node):
    """``true`` or ``false``."""

    value: bool


@dataclass(frozen=True, kw_only=True)
class String(Node):
    """``"text"``; `value` has its escapes resolved."""

    value: str


@dataclass(frozen=True, kw_only=True)
class Name(Node):
    """A name; ``self``, ``parent`` and ``root`` are names too."""

    id: str


@dataclass(frozen=True, kw_only=True)
class Attribute(Node):
    """``obj.name``; `name_span` is the place of the name alone."""

    obj: Expr
    name: str
    name_span: Span = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class Slice(Node):
    """``low:high`` between the brackets of an index; `colon` is the offset of the colon."""

    low: Expr | None
    high: Expr | None
    colon: int = field(compare=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class Index(Node):
    """``obj[i]``, ``obj[i, j]``, ``obj[a:b]`` or ``obj[i, :]``."""

    obj: Expr
    indices: tuple[Expr | Slice, ...]


@dataclass(frozen=True, kw_only=True)
class Call(Node):
    """``f(args)`` with `func` a Name, or ``obj.method(args)`` with `func` an Attribute."""

    func: Expr
    args: tuple[Expr, ...]


UnaryOp = Literal["-", "+", "not"]
BinaryOp = Literal[
    "+", "-", "*", "/", "^", ".*", "./", "==", "!=", "<", "<=", ">", ">=", "and", "or"
]


@dataclass(frozen=True, kw_only=True)
class Unary(Node):
    """``-x``, ``+x`` or ``not x``."""

    op: UnaryOp
    operand: Expr


@dataclass(frozen=True, kw_only=True)
class Binary(Node):
    """``left op right``."""

    op: BinaryOp
    left: Expr
    right: Expr


@dataclass(frozen=True, kw_only=True)
class Transpose(Node):
    """``M'``."""

    operand: Expr


@dataclass(frozen=True, kw_only=True)
class Conditional(Node):
    """``if cond then a else b``."""

    cond: Expr
    then: Expr
    otherwise: Expr


@dataclass(frozen=True, kw_only=True)
class ListExpr(Node):
    """``[a, b, c]``."""

    items: tuple[Expr, ...]


@dataclass(frozen=True, kw_only=True)
class Sum(Node):
    """``sum(k in self.knots) { ... }`` or ``sum(i, k in self.knots) { ... }``."""

    index: Ident | None
    element: Ident
    over: Expr
    body: Body


@dataclass(frozen=True, kw_only=True)
class Chain(Node):
    """``low <= middle <= high``, as `require` takes it."""

    low: Expr
    first: str
    middle: Expr
    second: str
    high: Expr


@dataclass(frozen=True, kw_only=True)
class Lambda(Node):
    """``|s| expr``, as `loss` takes it."""

    params: tuple[Ident, ...]
    body: Expr


Expr = (
    Number
    | Boolean
    | String
    | Name
    | Attribute
    | Index
    | Call
    | Unary
    | Binary
    | Transpose
    | Conditional
    | ListExpr
    | Sum
    | Chain
    | Lambda
)


@dataclass(frozen=True, kw_only=True)
class Ident(Node):
    """A name in a declaration."""

    id: str


@dataclass(frozen=True, kw_only=True)
class Path(Node):
    """A dotted path in a declaration: ``root.poses``, ``pose.info.features``."""

    parts: tuple[Ident, ...]

    def __str__(self) -> str:
        return ".".join(p.id for p in self.parts)


# --- types ------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Unit(Node):
    """A unit in brackets, as written between them: ``m``, ``1/rad``, ``m/s^2``."""

    text: str


@dataclass(frozen=True, kw_only=True)
class NamedType(Node):
    """``real``, ``vec3``, ``vec<4>``, ``mat<2,3>``, ``Pose``, ``constraint_index``, with a unit."""

    name: str
    dims: tuple[int, ...] = ()
    unit: Unit | None = None


@dataclass(frozen=True, kw_only=True)
class OptionalType(Node):
    """``T?``."""

    inner: NamedType


@dataclass(frozen=True, kw_only=True)
class CollectionType(Node):
    """``list of T``, ``deque of T``, ``arena of T``."""

    kind: Literal["list", "deque", "arena"]
    element: NamedType


@dataclass(frozen=True, kw_only=True)
class RefType(Node):
    """``ref T in PATH``, or ``ref T in PATH?`` where the ref may be null."""

    target: Ident
    path: Path
    optional: bool = False


@dataclass(frozen=True, kw_only=True)
class RefListType(Node):
    """``[ref T in PATH; n]``: `count` refs, each a `ref`."""

    ref: RefType
    count: int


@dataclass(frozen=True, kw_only=True)
class BlockType(Node):
    """``block A`` or ``block (A, B)``."""

    entities: tuple[Ident, ...]


@dataclass(frozen=True, kw_only=True)
class TripletsType(Node):
    """``triplets``."""


TypeExpr = (
    NamedType | OptionalType | CollectionType | RefType | RefListType | BlockType | TripletsType
)


# --- members ----------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Bounds(Node):
    """``in LOW .. HIGH`` of a parameter; either bound may be omitted."""

    low: Expr | None
    high: Expr | None


@dataclass(frozen=True, kw_only=True)
class Field(Node):
    """One field. `role` distinguishes ``param`` and ``skip`` from plain data."""

    name: Ident
    type: TypeExpr
    role: Literal["data", "param", "skip"] = "data"
    bounds: Bounds | None = None
    default: Expr | None = None
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Tie(Node):
    """``param b = 2 * a + 1``: derived from other parameters, not solved for."""

    name: Ident
    value: Expr
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Let(Node):
    """``let name = value``."""

    name: Ident
    value: Expr


@dataclass(frozen=True, kw_only=True)
class Body(Node):
    """The braces of a constraint: lets, then the residual."""

    lets: tuple[Let, ...]
    result: Expr


@dataclass(frozen=True, kw_only=True)
class Constraint(Node):
    """``constraint name when guard loss kernel into blocks { ... }``."""

    name: Ident
    body: Body
    guard: Expr | None = None
    loss: Expr | None = None  # a Call of a kernel, or a Lambda
    into: tuple[Path, ...] = ()
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Require(Constraint):
    """``require name when guard { comparison }``: the comparison holds exactly."""


@dataclass(frozen=True, kw_only=True)
class Fit(Node):
    """``fit data as e { residual }`` of a root; may take the clauses of a constraint."""

    collection: Path
    element: Ident
    body: Body
    guard: Expr | None = None
    loss: Expr | None = None
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Prior(Node):
    """``prior a ~ normal(mean, sigma)``; may take the clauses of a constraint."""

    target: Expr
    distribution: Ident
    args: tuple[Expr, ...]
    guard: Expr | None = None
    loss: Expr | None = None
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Fixed(Node):
    """``fixed f.x, bias``: parameters, or components of them, that no solve changes."""

    paths: tuple[Path, ...]


@dataclass(frozen=True, kw_only=True)
class Key(Node):
    """``key name``: refs in data may use this string field."""

    field: Ident


@dataclass(frozen=True, kw_only=True)
class Marginalize(Node):
    """``marginalize landmarks, points``."""

    paths: tuple[Path, ...]


@dataclass(frozen=True, kw_only=True)
class SkipSelfBlock(Node):
    """``skip_self_block``."""


@dataclass(frozen=True, kw_only=True)
class Setting(Node):
    """``name = expr`` in a pass: root data or a solver setting."""

    target: Path
    value: Expr


@dataclass(frozen=True, kw_only=True)
class Freeze(Node):
    """``freeze poses.ea`` (`free` False) or ``free poses.ea``."""

    paths: tuple[Path, ...]
    free: bool


@dataclass(frozen=True, kw_only=True)
class PassBlock(Node):
    """``pass name { ... }`` of a solve schedule."""

    name: Ident
    steps: tuple[Setting | Freeze, ...]
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Solve(Node):
    """``solve { pass ... }``."""

    passes: tuple[PassBlock, ...]
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Symbolic(Node):
    """``symbolic dir = expr`` of a component."""

    name: Ident
    value: Expr
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Compute(Node):
    """``compute cached = expr`` of a component."""

    name: Ident
    value: Expr
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Update(Node):
    """``update { base = ...; d = 0 }`` of a component."""

    steps: tuple[Setting, ...]
    doc: str = ""


Member = (
    Field
    | Tie
    | Constraint
    | Require
    | Prior
    | Fixed
    | Fit
    | Key
    | Marginalize
    | SkipSelfBlock
    | Solve
    | Symbolic
    | Compute
    | Update
)


# --- items ------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class Import(Node):
    """``import "file.arael"``."""

    path: String
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Const(Node):
    """``const name = value``."""

    name: Ident
    value: Expr
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Function(Node):
    """``fn f(x) = body``, ``fn f(x) derivs [..] = body`` or ``extern fn f(x) derivs [..]``."""

    name: Ident
    params: tuple[Ident, ...]
    body: Expr | None
    derivs: tuple[Expr, ...] | None = None
    extern: bool = False
    doc: str = ""


@dataclass(frozen=True, kw_only=True)
class Struct(Node):
    """A struct, root or component. `precision` is ``""`` if a root does not give one."""

    kind: Literal["struct", "root", "component"]
    name: Ident
    members: tuple[Member, ...]
    precision: Literal["", "f32", "f64"] = ""
    doc: str = ""


Item = Import | Const | Function | Struct


@dataclass(frozen=True)
class Comment:
    """A comment with its place, for the formatter."""

    span: Span = field(compare=False, repr=False)
    text: str = ""


@dataclass(frozen=True)
class File:
    """A whole file; `comments` holds every comment in order of appearance."""

    source: Source = field(compare=False, repr=False)
    items: tuple[Item, ...] = ()
    comments: tuple[Comment, ...] = field(default=(), compare=False)
