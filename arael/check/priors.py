"""Rule: a prior is of a parameter of its struct, or of a component of one.

Allowed: ``prior a ~ normal(mean, sigma)`` with mean and sigma from data or constants;
``prior pos.z ~ normal(0, 1)``, ``prior v[0:2] ~ ..``, ``prior T.rotation ~ ..``; one number for all
components of a vector.

Not allowed: a parameter of another row, data, a formula, a component of a quaternion; another
distribution; a mean or sigma that is solved for, or does not fit.

The residual is ``(a - mean) / sigma``. Of an angle the difference is wrapped; of a rotation, a
direction or a transform it is the tangent vector at the mean that leads to the parameter.
"""

from __future__ import annotations

import math

from arael.check.arithmetic import NotConstant, evaluate
from arael.check.binding import BROKEN, Broken
from arael.check.builtins import is_number
from arael.check.defaults import UNIT_TOLERANCE
from arael.check.suggest import did_you_mean
from arael.check.typed import (
    QUATERNION,
    REAL,
    Apply,
    Component,
    MatrixType,
    Pack,
    QuaternionType,
    Read,
    ScalarType,
    TransformType,
    Typed,
    VectorType,
)
from arael.check.types import size_of
from arael.check.typist import Typist
from arael.check.units import ONE
from arael.check.units_quantities import NUMBER
from arael.check.walk import postorder
from arael.diagnostics.records import Label
from arael.syntax import tree

DISTRIBUTIONS = ("normal",)
_WRAPPED = ("angle", "euler")


def prior_residual(t: Typist, node: tree.Prior) -> tuple[Typed, Typed | None] | None:
    """The residual of a prior, and its sigma if the data decides it; None after an error."""
    target = t.value(node.target)
    if isinstance(target, Broken):
        return None
    read = _parameter(t, node, target)
    if read is None or not _known(t, node):
        return None
    values = [t.number(arg) for arg in node.args]
    good = [v for v in values if isinstance(v, Typed)]
    if len(good) < len(values) or not all(_is_fixed(t, v) for v in good):
        return None
    mean, sigma = _as_stored(t, target, good[0]), good[1]
    difference = _difference(t, node, target, read, mean)
    if isinstance(difference, Broken):
        return None
    whitened = _over_sigma(t, node, difference, sigma)
    if isinstance(whitened, Broken):
        return None
    return whitened, None if _smallest(sigma) is not None else sigma


def _smallest(sigma: Typed) -> float | None:
    """The smallest number of a constant sigma; None if it reads data."""
    try:
        return min(evaluate(sigma))
    except NotConstant:
        return None


def _parameter(t: Typist, node: tree.Prior, target: Typed) -> Read | None:
    """The parameter that `target` is, or a part of; None after an error."""
    here, parts = target, [target]
    while not isinstance(here, Read):
        if isinstance(here, Component):
            here = here.of
        elif isinstance(here, Pack) and here.items and _of_one(here):
            here = here.items[0]
        elif isinstance(here, Apply) and here.name in ("translation", "rotation"):
            here = here.args[0]
        else:
            break
        parts.append(here)
    label, help_ = "", ["name a parameter of this struct, or a component: `prior pos.z ~ ...`"]
    if not isinstance(here, Read):
        label = "this is a formula"
        help_ = ["for a formula write a constraint: `constraint near { (f - mean) / sigma }`"]
    elif not here.parameter or here.version != "trial":
        label = "this is data" if here.version == "data" else "this is not solved for"
    elif here.slot != 0:
        label = "a parameter of another row"
        help_ = ["write the prior in the struct that declares the parameter"]
    elif isinstance(target, Component | Pack) and any(p.type == QUATERNION for p in parts[1:]):
        label = "a component of a quaternion"
        help_ = [f"write the prior of the whole rotation: `prior {here.span.text} ~ ...`"]
    if not label:
        assert isinstance(here, Read)
        return here
    t.fail(
        "E0660",
        node.target.span,
        "a prior is of a parameter of its struct",
        label=label,
        labels=t.origin(here),
        help=help_,
    )
    return None


def _of_one(pack: Pack) -> bool:
    """Whether all items are components of one value: a slice."""
    items = pack.items
    first = items[0]
    return isinstance(first, Component) and all(
        isinstance(i, Component) and i.of is first.of for i in items
    )


def _known(t: Typist, node: tree.Prior) -> bool:
    name = node.distribution
    if name.id not in DISTRIBUTIONS:
        t.fail(
            "E0661",
            name.span,
            f"unknown distribution `{name.id}`",
            label="not found",
            help=did_you_mean(name.id, DISTRIBUTIONS) or ["write `normal(mean, sigma)`"],
        )
        return False
    if len(node.args) != 2:
        t.fail(
            "E0661",
            node.span,
            f"`normal` takes a mean and a standard deviation, found {len(node.args) or 'nothing'}",
            label="in this prior",
            help=["write `normal(mean, sigma)`"],
        )
        return False
    return True


def _is_fixed(t: Typist, value: Typed) -> bool:
    """Whether `value` reads no parameter; reports an error if it does."""
    read = [n for n in postorder([value]) if isinstance(n, Read) and n.version == "trial"]
    if not read:
        return True
    t.fail(
        "E0662",
        value.span,
        "the mean and sigma of a prior are data or constants",
        label="reads a parameter",
        labels=t.origin(read[0]),
        help=["for a difference of two parameters write a `constraint`"],
    )
    return False


def _as_stored(t: Typist, target: Typed, mean: Typed) -> Typed:
    """The mean of a rotation or transform that is written as a list, as a default is."""
    type_ = target.type
    if not isinstance(type_, QuaternionType | TransformType):
        return mean
    if mean.type != VectorType(size_of(type_)):
        return mean
    try:
        values = evaluate(mean)
    except NotConstant:
        return mean
    start = 0 if type_ == QUATERNION else 3
    if abs(math.hypot(*values[start : start + 4]) - 1) > UNIT_TOLERANCE:
        return mean
    packed = t.make(Pack(type=type_, span=mean.span, items=(mean,)))
    return packed if isinstance(packed, Typed) else mean


def _difference(
    t: Typist, node: tree.Prior, target: Typed, read: Read, mean: Typed
) -> Typed | Broken:
    """The parameter relative to the mean: a number, or a vector in the tangent."""
    type_ = target.type
    if type_ == QUATERNION:
        return _rotation(t, node, target, mean)
    if isinstance(type_, TransformType):
        if mean.type != type_:
            return _misfit(t, node, mean, "mean", str(type_))
        back = _apply(t, node, "inverse", [mean], type_)
        step = back and _apply(t, node, "mul", [back, target], type_)
        twist = VectorType(7 if type_.scaled else 6)
        return (step and _apply(t, node, "tf_log", [step], twist)) or BROKEN
    if read.parameter == "direction" and target is read:
        if mean.type != type_:
            return _misfit(t, node, mean, "mean", "a unit vector (vec3)")
        return _apply(t, node, "direction_log", [mean, target], VectorType(2)) or BROKEN
    size = size_of(type_)
    if not (is_number(mean.type) or mean.type == type_):
        wanted = "a number" if size == 1 else f"a number or {type_}"
        return _misfit(t, node, mean, "mean", wanted)
    means = _spread(t, mean, size)
    if read.parameter not in _WRAPPED and size_of(mean.type) == size:
        return _apply(t, node, "sub", [target, mean], type_) or BROKEN
    operation = "rad_diff" if read.parameter in _WRAPPED else "sub"
    parts = [target] if size == 1 else _spread(t, target, size)
    items = [_apply(t, node, operation, [a, m], REAL) for a, m in zip(parts, means, strict=True)]
    differences = [i for i in items if i is not None]
    if len(differences) < len(items):
        return BROKEN
    if size == 1:
        return differences[0]
    return t.make(Pack(type=type_, span=node.target.span, items=tuple(differences)))


def _rotation(t: Typist, node: tree.Prior, target: Typed, mean: Typed) -> Typed | Broken:
    if isinstance(mean.type, MatrixType) and size_of(mean.type) == 9:
        mean = _apply(t, node, "quaternion", [mean], QUATERNION) or mean
    if mean.type != QUATERNION:
        return _misfit(t, node, mean, "mean", "a unit quaternion or a rotation matrix")
    back = _apply(t, node, "conj", [mean], QUATERNION)
    step = back and _apply(t, node, "mul", [back, target], QUATERNION)
    return (step and _apply(t, node, "quat_log", [step], VectorType(3))) or BROKEN


def _over_sigma(t: Typist, node: tree.Prior, difference: Typed, sigma: Typed) -> Typed | Broken:
    vector = isinstance(difference.type, VectorType)
    if not (is_number(sigma.type) or (vector and sigma.type == difference.type)):
        wanted = f"a number or {difference.type}" if vector else "a number"
        return _misfit(t, node, sigma, "sigma", wanted)
    smallest = _smallest(sigma)
    if smallest is not None and smallest <= 0:
        return t.fail(
            "E0662",
            sigma.span,
            f"sigma is positive, found {smallest:g}",
            label="a standard deviation",
            help=["to hold a parameter, freeze it or set `fixed` in the data"],
        )
    operation = "div" if isinstance(sigma.type, ScalarType) else "ediv"
    whitened = _apply(t, node, operation, [difference, sigma], difference.type)
    if whitened is not None and t.units.of(sigma) is NUMBER:
        t.units.known[whitened] = ONE  # a literal number takes the unit of the parameter
    return whitened or BROKEN


def _spread(t: Typist, value: Typed, size: int) -> list[Typed]:
    """Each scalar of a vector; a number as many times."""
    if isinstance(value.type, ScalarType):
        return [value] * size
    items = [Component(type=REAL, span=value.span, of=value, index=k) for k in range(size)]
    for item in items:
        t.units.note(item)
    return list(items)


def _apply(
    t: Typist, node: tree.Prior, name: str, args: list[Typed], type_: object
) -> Typed | None:
    value = t.apply(node.target, name, args, type_)
    return value if isinstance(value, Typed) else None


def _misfit(t: Typist, node: tree.Prior, value: Typed, what: str, wanted: str) -> Broken:
    return t.fail(
        "E0662",
        value.span,
        f"expected {wanted} for the {what} of `{node.target.span.text}`, found {value.type}",
        label=f"this is {value.type}",
        labels=[label for label in t.origin(value) if isinstance(label, Label)],
    )
