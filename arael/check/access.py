"""Types names, ``a.b`` and ``a[i]``."""

from __future__ import annotations

import re
from collections.abc import Sequence

from arael.check.arithmetic import NotConstant, evaluate
from arael.check.binding import BROKEN, Binding, Broken, Collection, Entity, RefList, describe
from arael.check.builtins import FUNCTIONS, IDENTITIES, METHODS, is_number
from arael.check.field_reads import bind_field
from arael.check.scope import Candidate
from arael.check.stored import as_stored
from arael.check.suggest import nearest
from arael.check.typed import (
    QUATERNION,
    REAL,
    Apply,
    Component,
    Formula,
    Literal_,
    MatrixType,
    Pack,
    Read,
    TransformType,
    Typed,
    VectorType,
)
from arael.check.typist import Typist
from arael.check.units import Unit
from arael.diagnostics.records import Label
from arael.operations.constants import CONSTANTS
from arael.syntax import tree

QUATERNION_PARTS = {"w": 0, "x": 1, "y": 2, "z": 3}
VECTOR_PARTS = {"x": 0, "y": 1, "z": 2}


def name(t: Typist, node: tree.Name) -> Binding:
    """A bare name."""
    candidates = t.scope.candidates(node.id)
    if len(candidates) > 1:
        first = candidates[0].entity
        agree = first is not None and all(c.entity and c.entity.same(first) for c in candidates)
        if not agree:
            return _ambiguous(t, node, candidates)
    if candidates:
        return candidates[0].bind(node.span)
    if node.id in CONSTANTS:
        return t.make(Literal_(type=REAL, span=node.span, value=CONSTANTS[node.id].number))
    if node.id in IDENTITIES:
        return t.make(Apply(type=IDENTITIES[node.id], span=node.span, name=node.id, args=()))
    return _unknown(t, node)


def _ambiguous(t: Typist, node: tree.Name, candidates: Sequence[Candidate]) -> Broken:
    """Report an ambiguous name, once for each set of colliding declarations."""
    message = f"`{node.id}` means two things here"
    labels = [Label(c.span, c.what) for c in candidates if c.span is not None]
    if t.report.reported("E0202", message, labels):
        return BROKEN
    names = [re.sub(r"^a ", "the ", c.what) for c in candidates]
    longer = [
        f"`{c.longer}` for {what}" for c, what in zip(candidates, names, strict=True) if c.longer
    ]
    first = re.sub(r" of.*", "", names[0])
    return t.fail(
        "E0202",
        node.span,
        message,
        label=" or ".join(c.what for c in candidates),
        labels=labels,
        help=[f"write {' or '.join(longer)}, or rename {first}" if longer else f"rename {first}"],
    )


def _unknown(t: Typist, node: tree.Name) -> Broken:
    if node.id in t.declarations.broken:
        return BROKEN
    if node.id in FUNCTIONS or node.id in t.declarations.functions:
        return t.fail(
            "E0304",
            node.span,
            f"`{node.id}` is a function",
            label="expected a value here",
            help=[f"call it: `{node.id}(...)`"],
        )
    help_ = t.scope.advice(node.id)
    stored = node.id.removesuffix("_value")
    if stored != node.id and t.scope.candidates(stored):
        help_ = [f"write `{stored}.value` for the parameter's value at the start of the solve"]
    if not help_:
        near = nearest(node.id, [*t.scope.names(), *CONSTANTS, *IDENTITIES])
        help_ = [f"did you mean `{near}`?"] if near else []
    return t.fail(
        "E0201",
        node.span,
        f"unknown name `{node.id}`",
        label="not found here",
        help=help_,
    )


def attribute(t: Typist, node: tree.Attribute) -> Binding:
    """``obj.name``: a field of an entity, a component of a value, ``.value`` of a parameter."""
    owner = t.visit(node.obj)
    if isinstance(owner, Broken):
        return BROKEN
    if isinstance(owner, Entity):
        return _of_entity(t, node, owner)
    if isinstance(owner, Collection):
        return _of_collection(t, node, owner)
    if isinstance(owner, RefList):
        return _of_refs(t, node, owner)
    value = t.as_value(owner, node.obj.span)
    return value if isinstance(value, Broken) else _of_value(t, node, value)


def _of_entity(t: Typist, node: tree.Attribute, entity: Entity) -> Binding:
    struct = entity.place.struct
    if node.name in struct.fields or node.name in struct.formulas:
        return bind_field(t, entity, node.name, node.span)
    if node.name == "parent":
        owner = t.paths.owner(entity)
        if owner is not None:
            return owner
        return t.fail(
            "E0204", node.name_span, f"{struct.name} has no parent", label="it is the root"
        )
    if node.name in t.declarations.broken:
        return BROKEN
    near = nearest(node.name, [*struct.fields, *struct.formulas])
    stored = node.name.removesuffix("_value")
    if stored != node.name and stored in struct.fields:
        near = f"{stored}.value"
    help_ = [f"did you mean `{near}`?"] if near else []
    owner = t.paths.owner(entity)
    if not near and owner is not None and node.name in owner.place.struct.fields:
        longer = f"{node.obj.span.text}.parent.{node.name}"
        help_ = [f"its parent {owner.place.struct.name} has one: write `{longer}`"]
    return t.fail(
        "E0204",
        node.name_span,
        f"{struct.name} has no field `{node.name}`",
        label="unknown field",
        labels=[Label(struct.node.name.span, f"{struct.name} is declared here")],
        help=help_,
    )


def _of_collection(t: Typist, node: tree.Attribute, collection: Collection) -> Broken:
    held = collection.site.place.struct.name
    return t.fail(
        "E0304",
        node.obj.span,
        f"`{node.obj.span.text}` is a collection",
        label=f"which {held}?",
        help=[
            f"point to one with `x: ref {held} in ...`, or put the constraint into {held}, where "
            "it runs for each"
        ],
    )


def _of_refs(t: Typist, node: tree.Attribute, refs: RefList) -> Broken:
    text = node.obj.span.text
    return t.fail(
        "E0304",
        node.obj.span,
        f"`{text}` is a list of {len(refs.field.elements)} refs",
        label=f"which {refs.field.struct}?",
        labels=[Label(refs.field.span, "declared here")],
        help=[
            f"write `{text}[0].{node.name}` for one of them, or "
            f"`sum(k in {text}) {{ k.{node.name} }}` for all"
        ],
    )


def _of_value(t: Typist, node: tree.Attribute, value: Typed) -> Binding:
    if node.name == "value":
        return _stored(t, node, value)
    type_ = value.type
    if isinstance(value, Read) and value.parameter == "rotation":
        return _of_rotation(t, node, value)
    if type_ == QUATERNION:
        if node.name in QUATERNION_PARTS:
            return _component(t, node, value, QUATERNION_PARTS[node.name])
        if node.name == "vec":
            return t.apply(node, "quat_vec", [value], VectorType(3))
    if isinstance(type_, VectorType) and node.name in VECTOR_PARTS:
        at = VECTOR_PARTS[node.name]
        if at < type_.n:
            return _component(t, node, value, at)
        return t.fail(
            "E0305",
            node.name_span,
            f"{type_} has no `{node.name}`",
            label=f"it has {', '.join(list(VECTOR_PARTS)[: type_.n])}",
            labels=t.origin(value),
        )
    if isinstance(type_, TransformType):
        if node.name == "translation":
            return t.apply(node, "translation", [value], VectorType(3))
        if node.name == "rotation":
            return t.apply(node, "rotation", [value], QUATERNION)
        if node.name == "scale" and type_.scaled:
            return _component(t, node, value, 7)
    help_ = []
    if node.name in METHODS:
        help_ = [f"`{node.name}` is a method: write `{node.name}()`"]
    elif isinstance(type_, MatrixType):
        help_ = ["write `M[row, column]`, `M.row(i)` or `M.col(i)`"]
    elif isinstance(type_, TransformType):
        help_ = [f"{type_} has translation, rotation{' and scale' if type_.scaled else ''}"]
    return t.fail(
        "E0204",
        node.name_span,
        f"{type_} has no part `{node.name}`",
        label="unknown part",
        labels=t.origin(value),
        help=help_,
    )


_ANGLES = {"x": "roll", "y": "pitch", "z": "yaw", "roll": "roll", "pitch": "pitch", "yaw": "yaw"}


def _of_rotation(t: Typist, node: tree.Attribute, value: Typed) -> Broken:
    """Report a part of a rotation: it would be one of its quaternion, where `euler` has an angle.

    A model changed from ``euler`` to ``rotation`` would silently read other numbers.
    """
    whole = node.obj.span.text
    angle = _ANGLES.get(node.name)
    help_ = []
    if angle is not None:
        part = VECTOR_PARTS.get(node.name, ("roll", "pitch", "yaw").index(angle))
        help_.append(f"write `{whole}.euler_angles().{'xyz'[part]}` for the {angle} angle")
    elif node.name in METHODS:
        help_.append(f"`{node.name}` is a method: write `{node.name}()`")
    help_.append(
        f"turn vectors with `{whole}.rotation_matrix() * v`; a parameter `quaternion` has the "
        "parts w, x, y, z and vec"
    )
    return t.fail(
        "E0313",
        node.name_span,
        f"a `rotation` has no part `{node.name}`",
        label="a component of its quaternion, or an angle?"
        if node.name in QUATERNION_PARTS
        else "unknown part",
        labels=t.origin(value),
        help=help_,
    )


def _stored(t: Typist, node: tree.Attribute, value: Typed) -> Binding:
    if isinstance(value, Read) and value.version == "trial":
        stored = Read(
            type=value.type,
            span=node.span,
            slot=value.slot,
            column=value.column,
            version="stored",
            parameter=value.parameter,
        )
        t.units.read(stored, t.units.fields.get(value))
        if value in t.origins:
            t.origins[stored] = t.origins[value]
        return t.make(stored)
    if isinstance(value, Formula):
        return as_stored(t, value)
    return t.fail(
        "E0308",
        node.name_span,
        "only a parameter has a stored value",
        label="not the value of a parameter",
        labels=t.origin(value),
        notes=["`x.value` is the value of the parameter `x` at the start of the solve"],
    )


def _component(t: Typist, node: tree.Expr, value: Typed, at: int) -> Binding:
    return t.make(Component(type=REAL, span=node.span, of=value, index=at))


def index(t: Typist, node: tree.Index) -> Binding:
    """``a[i]`` of a vector, ``M[i, j]`` of a matrix, counted from 0; ``a:b`` for a part of it."""
    owner = t.visit(node.obj)
    if isinstance(owner, RefList):
        return _element(t, node, owner)
    value = t.as_number(owner, node.obj.span)
    if isinstance(value, Broken):
        return BROKEN
    type_ = value.type
    sizes: tuple[int, ...]
    if isinstance(type_, VectorType):
        sizes = (type_.n,)
    elif isinstance(type_, MatrixType):
        sizes = (type_.rows, type_.columns)
    else:
        help_ = ["write q.w, q.x, q.y, q.z"] if type_ == QUATERNION else []
        return t.fail(
            "E0305",
            node.span,
            f"{type_} cannot be indexed",
            label="only vectors and matrices have elements",
            labels=t.origin(value),
            help=help_,
        )
    if len(node.indices) != len(sizes):
        help_ = ["write `M[i, :]` for a whole row"] if len(sizes) == 2 else []
        return t.fail(
            "E0305",
            node.span,
            f"{type_} takes {len(sizes)} {'index' if len(sizes) == 1 else 'indices'}, "
            f"found {len(node.indices)}",
            labels=t.origin(value),
            help=help_,
        )
    if any(isinstance(i, tree.Slice) for i in node.indices):
        return _part(t, node, value, sizes)
    at = 0
    for expr, size in zip(node.indices, sizes, strict=True):
        assert not isinstance(expr, tree.Slice)
        i = constant_index(t, expr, size, str(type_))
        if i is None:
            return BROKEN
        at = at * size + i
    return _component(t, node, value, at)


def _element(t: Typist, node: tree.Index, refs: RefList) -> Binding:
    """``knots[2]``: the entity that an element of a list of refs points to."""
    elements = refs.field.elements
    (at, *more) = node.indices
    if more or isinstance(at, tree.Slice):
        return t.fail(
            "E0305",
            node.span,
            "an element of a list of refs has one index",
            label=f"expected 0 to {len(elements) - 1}",
            labels=[Label(refs.field.span, "declared here")],
        )
    i = constant_index(t, at, len(elements), f"`{node.obj.span.text}`")
    return BROKEN if i is None else t.paths.follow(refs.owner, elements[i])


def _part(t: Typist, node: tree.Index, value: Typed, sizes: Sequence[int]) -> Binding:
    """``v[a:b]``, ``M[i, :]``, ``M[:, j]``, ``M[a:b, c:d]``: the elements in a vector or matrix."""
    taken: list[range] = []
    for expr, size in zip(node.indices, sizes, strict=True):
        if isinstance(expr, tree.Slice):
            part = constant_slice(t, expr, size, str(value.type))
        else:
            i = constant_index(t, expr, size, str(value.type))
            part = None if i is None else range(i, i + 1)
        if part is None:
            return BROKEN
        taken.append(part)
    places = list(taken[0])
    if len(taken) == 2:
        places = [i * sizes[1] + j for i in taken[0] for j in taken[1]]
    selected = [
        len(part)
        for part, expr in zip(taken, node.indices, strict=True)
        if isinstance(expr, tree.Slice)
    ]
    type_ = MatrixType(*selected) if len(selected) == 2 else VectorType(*selected)
    items = [Component(type=REAL, span=node.span, of=value, index=at) for at in places]
    for item in items:
        t.units.note(item)
    return t.make(Pack(type=type_, span=node.span, items=tuple(items)))


def constant_slice(t: Typist, node: tree.Slice, size: int, of: str) -> range | None:
    """The elements of a slice; None after an error."""
    ends: list[int] = []
    for expr, default in ((node.low, 0), (node.high, size)):
        end = default if expr is None else constant_index(t, expr, size + 1, of)
        if end is None:
            return None
        ends.append(end)
    low, high = ends
    if low < high:
        return range(low, high)
    t.fail(
        "E0305",
        node.span,
        f"the slice {low}:{high} is empty",
        label="no elements",
        help=[f"`a:b` has the elements from a to b - 1, of 0 to {size - 1}"],
    )
    return None


def _constant(value: Typed) -> float | None:
    """The number of a constant, such as ``N - 1``; None of anything else."""
    if isinstance(value, Literal_):
        return value.value
    if not is_number(value.type):
        return None
    try:
        (number,) = evaluate(value)
    except NotConstant:
        return None
    return number


def constant_index(t: Typist, node: tree.Expr, size: int, of: str) -> int | None:
    """A constant index; None after an error."""
    value = t.number(node)
    if isinstance(value, Broken):
        return None
    number = _constant(value)
    if number is None or number != int(number):
        t.fail(
            "E0305",
            node.span,
            "an index is a constant whole number",
            label=f"this is {describe(value)}" if number is None else "not whole",
        )
        return None
    unit = t.units.of(value)
    if isinstance(unit, Unit) and not unit.is_one:
        t.fail("E0305", node.span, "an index has no unit", label=f"this is in {unit}")
        return None
    i = int(number)
    if not 0 <= i < size:
        t.fail(
            "E0305",
            node.span,
            f"index {i} is outside of {of}",
            label=f"expected 0 to {size - 1}",
        )
        return None
    return i
