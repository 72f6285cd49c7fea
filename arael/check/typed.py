"""Typed schema, the result of checking: all names resolved, all shapes and types known.

Expressions are trees with shared nodes where a `let` is read twice. Constraint bodies are typed
once per *site* (a place where their struct occurs), because `parent` and optional ancestors depend
on it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from arael.check.units_quantities import NUMBER, Quantity
from arael.diagnostics.records import Span
from arael.runtime.layout import Block, Column, LayoutPass, Slot, Step, Table

# --- types ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ScalarType:
    """A number, a truth value or a text."""

    kind: Literal["real", "int", "bool", "string"] = "real"

    def __str__(self) -> str:
        return self.kind


@dataclass(frozen=True)
class VectorType:
    """A column of `n` scalars."""

    n: int

    def __str__(self) -> str:
        return f"vec{self.n}" if self.n in (2, 3) else f"vec<{self.n}>"


@dataclass(frozen=True)
class MatrixType:
    """A matrix, stored row by row."""

    rows: int
    columns: int

    def __str__(self) -> str:
        if self.rows == self.columns and self.rows in (2, 3):
            return f"mat{self.rows}"
        return f"mat<{self.rows},{self.columns}>"


@dataclass(frozen=True)
class QuaternionType:
    """A unit quaternion w, x, y, z."""

    def __str__(self) -> str:
        return "quat"


@dataclass(frozen=True)
class TransformType:
    """A rigid transform: translation, unit quaternion and, if `scaled`, a scale."""

    scaled: bool = False

    def __str__(self) -> str:
        return "similarity" if self.scaled else "transform"


ValueType = ScalarType | VectorType | MatrixType | QuaternionType | TransformType

REAL = ScalarType("real")
INT = ScalarType("int")
BOOL = ScalarType("bool")
STRING = ScalarType("string")
QUATERNION = QuaternionType()
TRANSFORM = TransformType()
SIMILARITY = TransformType(scaled=True)


# --- expressions ------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, kw_only=True)
class Typed:
    """Base of typed expressions; `eq=False`, since shared lets are compared by identity."""

    type: ValueType
    span: Span = field(repr=False)


@dataclass(frozen=True, eq=False)
class Named:
    """The constant that a number comes from.

    Attributes
    ----------
    name : of the constant
    component : of a vector or a matrix, flat
    negative : whether the number is minus its value
    formula : of the constant, which may read other constants
    """

    name: str
    component: int
    negative: bool
    formula: Typed


@dataclass(frozen=True, eq=False, kw_only=True)
class Literal_(Typed):
    """A number; a bool is 0 or 1. The value of a constant has the unit of its formula."""

    value: float
    unit: Quantity = NUMBER
    constant: Named | None = field(default=None, repr=False)


@dataclass(frozen=True, eq=False, kw_only=True)
class Read(Typed):
    """A column reached through a slot.

    `version` is ``trial`` for a parameter under optimisation and for stored data of a component,
    ``computed`` for a ``compute`` field, ``stored`` for the value at the start of the solve
    (``pos.value``), ``data`` for everything else. `parameter` is the param kind of the column
    (``euler``, ``rotation``, ...) or "" for data: an ``euler`` or ``angle`` reads as its angles
    (vec3 / real), ``rotation`` and ``quaternion`` as a quaternion, ``direction`` as a vec3,
    ``transform`` and ``similarity`` as transforms.
    """

    slot: int
    column: str
    version: Literal["trial", "computed", "stored", "data"]
    parameter: str = ""


@dataclass(frozen=True, eq=False, kw_only=True)
class Present(Typed):
    """Whether an optional is present (BOOL)."""

    slot: int
    column: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Component(Typed):
    """Scalar of a vector (index), matrix (row * columns + column), quaternion (0 = w) or transform.

    Of a transform: translation 0 to 2, quaternion 3 to 6, scale 7.
    """

    of: Typed
    index: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Pack(Typed):
    """Scalars and vectors joined into one vector, or row by row into a matrix."""

    items: tuple[Typed, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Select(Typed):
    """``if cond then a else b``, elementwise on shapes that agree."""

    cond: Typed
    then: Typed
    otherwise: Typed


@dataclass(frozen=True, eq=False, kw_only=True)
class Apply(Typed):
    """An operator or built-in function on values whose shapes have been checked.

    Names and argument types (S scalar, V vector, M matrix, Q quaternion, T transform):

    ==================  =====================================================================
    name                meaning
    ==================  =====================================================================
    neg                 S V M Q, elementwise
    add sub             two of the same shape
    mul                 S*S S*V V*S S*M M*S S*Q Q*S, M*M M*V, V*M (row vector), Q*Q, T*T T*V
    div                 S/S V/S M/S Q/S
    emul ediv           elementwise ``.*`` ``./`` of the same shape (or with a scalar)
    pow                 S^S
    lt le gt ge eq ne   S, S -> bool
    and or not          bool
    transpose           M
    inverse             M, Q, T
    row column          M with a literal index as second argument
    quat_vec            Q -> vec3
    translation         T -> vec3
    rotation            T -> Q
    rotation_matrix     euler vec3 -> M3, angle S -> M2, Q -> M3, T -> M3 (as method or function)
    matrix              T -> M4, homogeneous
    euler_angles        M3 or Q -> vec3
    quaternion          M3 -> Q
    transform           M4 or M<3,4>; V and Q or M3, in either order -> T
    similarity          V and Q or M3, in either order, S -> T
    tf_log tf_exp       T -> its twist V6 or V7, and back
    rotation_vector     M3 -> vec3
    direction_log       V3, V3 -> V2: from a unit vector to another, in its tangent plane
    dot cross norm norm2 unit perp det trace skew vee identity2 identity3
    conj rotate log exp of quaternions: conj(Q), rotate(Q, V), quat_log(Q), quat_exp(V)
    scalar functions    by their name in the language; the elementwise ones (starship, abs, sqrt
                        ... where LANGUAGE.md allows) keep the shape of their first argument
    ==================  =====================================================================
    """

    name: str
    args: tuple[Typed, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class Total(Typed):
    """The sum of `of` over the rows of a collection, whose number the data determines.

    `slot` is the row that owns the collection `collection`, a table, and `rows` the slot of its
    rows, from which `of` reads data but no parameters.
    """

    of: Typed
    slot: int
    rows: int
    collection: str


@dataclass(frozen=True, eq=False, kw_only=True)
class LookUp(Typed):
    """The value of a column between the rows of a collection, at the argument `of`.

    Attributes
    ----------
    slot : of the row that owns the collection `collection`, a table
    key, column : its columns: where the rows are, and what is interpolated
    rows : the column of a parameter in each row that the value depends on; none for data
    order : rows that a value depends on; 2 and ``cubic`` interpolate, a spline has control points
    spline : whether rows are the control points of a B-spline
    wrapped : whether the column holds angles, which are the same after a full turn
    clamp : whether an argument outside has the value at the nearest end
    derivative : with respect to the argument: 0 the value, 1 its rate, 2 its acceleration
    """

    of: Typed
    slot: int
    collection: str
    key: str
    column: str
    order: int
    spline: bool = False
    wrapped: bool = False
    clamp: bool = False
    derivative: int = 0
    value: ValueType = REAL  # of the column
    rows: tuple[Typed, ...] = ()


@dataclass(frozen=True, eq=False, kw_only=True)
class SquaredNorm(Typed):
    """The argument of a user-defined loss: the sum of the squared residuals of an instance."""


@dataclass(frozen=True, eq=False)
class Loss:
    """Loss of a constraint, applied to all its residuals together.

    `name` is one of `arael.check.losses.LOSSES`, or "" for a user-defined loss. `value` is
    then its expression over `argument`; else it is the scale, and `argument` is None. `text` is the
    loss as written.
    """

    name: str
    value: Typed
    argument: SquaredNorm | None
    span: Span
    text: str


@dataclass(frozen=True, eq=False, kw_only=True)
class Formal(Typed):
    """A parameter of a function, within the function's own formulas."""

    index: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Invoke(Typed):
    """A call of a function with `derivs`: scalars to a scalar.

    `value` is its formula, inlined for these arguments; None for native code.
    """

    function: str
    args: tuple[Typed, ...]
    value: Typed | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Formula(Typed):
    """A ``symbolic`` field of a component, inlined, of the row that a slot refers to.

    The state of its entity may hold its value under the path `column`.
    """

    of: Typed
    slot: int
    column: str


# --- the model --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Assignment:
    """An assignment of an update: the new value of the column; a number fills a vector."""

    column: str
    value: Typed


@dataclass(frozen=True)
class Definition:
    """A formula of a component at one place, with the path by which it is read."""

    column: str
    value: Typed


@dataclass(frozen=True)
class ComponentSite:
    """A component at one place. Its expressions read the row of its entity, through slot 0.

    `moved` are the parameters of it and of nested components: if a step changes one of them, the
    `updates` are applied in order. `symbolic` fields have derivatives, `computed` ones
    (``compute``) are values stored with each row.
    """

    struct: str
    span: Span
    moved: tuple[str, ...]
    updates: tuple[Assignment, ...]
    symbolic: tuple[Definition, ...]
    computed: tuple[Definition, ...]


@dataclass(frozen=True)
class EntitySite:
    """A struct with parameters at one place.

    Columns are the parameters of its own prefix, and all columns of its components: those without
    `param` are stored data. Nested components come first.
    """

    struct: str
    table: str
    prefix: str  # "" or "info." with the dot
    columns: tuple[Column, ...]
    components: tuple[ComponentSite, ...] = ()


@dataclass(frozen=True)
class ConstraintSite:
    """A constraint at one place, fully typed.

    `slots[0]` is always the instance's own row. `guard` is None or BOOL over data; the presence of
    every optional ancestor of the site itself is already part of it. `sigma` is the standard
    deviation of a prior where the data decides it, which must be positive.
    """

    label: str  # "PointFrine.bearing"
    struct: str
    name: str
    table: str
    prefix: str
    span: Span
    slots: tuple[Slot, ...]
    residual: tuple[Typed, ...]  # scalars and vectors, to be flattened in order
    guard: Typed | None = None
    loss: Loss | None = None
    sigma: Typed | None = None
    triplets: str = ""  # field of the root that receives the pairs without a named block
    crossed: tuple[frozenset[tuple[tuple[Step, ...], str]], ...] = ()  # pairs with named blocks
    index_column: str = ""  # constraint_index column of the struct, if any
    require: Literal["", "equal", "at_least"] = ""  # rows hold: zero, or not negative
    require_text: str = ""  # the comparison as written
    units: tuple[str, ...] = ()  # of each row that holds
    doc: str = ""


@dataclass(frozen=True)
class TypedFunction:
    """A function of the model as a function of scalars; parameters are `Formal`.

    Attributes
    ----------
    body : its formula; None for native code, and for one that does not take scalars
    derivs : partial derivatives, one per parameter; None where the formula is differentiated
    text, deriv_texts : the same as the model writes them
    """

    name: str
    params: tuple[str, ...]
    native: bool
    body: Typed | None
    derivs: tuple[Typed, ...] | None
    text: str
    deriv_texts: tuple[str, ...]
    span: Span
    doc: str = ""


@dataclass(frozen=True)
class TypedModel:
    """Typed schema of a model: tables and columns in the runtime's form, typed constraints."""

    name: str
    root: str
    precision: Literal["f32", "f64"]
    tables: tuple[Table, ...]
    entities: tuple[EntitySite, ...]
    constraints: tuple[ConstraintSite, ...]
    passes: tuple[LayoutPass, ...]
    blocks: tuple[Block, ...] = ()
    functions: tuple[TypedFunction, ...] = ()
    constants: tuple[tuple[str, str], ...] = ()  # names, and texts as written
    marginalize: tuple[str, ...] = ()
    doc: str = ""
