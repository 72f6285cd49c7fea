"""Rule: a residual consists of scalars and vectors and depends on a parameter.

Allowed: a scalar, a vector, a list of both.

Not allowed: a matrix, a quaternion, a comparison, a struct, an empty list; a residual of data
alone.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from arael.check.binding import Broken
from arael.check.builtins import is_number
from arael.check.field_reads import field_at, ref_text
from arael.check.guards import conjuncts, facts_of, moves
from arael.check.typed import (
    BOOL,
    QUATERNION,
    Apply,
    LookUp,
    MatrixType,
    Present,
    Read,
    TransformType,
    Typed,
    VectorType,
)
from arael.check.typist import Typist
from arael.check.walk import postorder
from arael.diagnostics.records import Label
from arael.syntax import tree


def residual_of(t: Typist, node: tree.Expr) -> list[Typed] | None:
    """The parts of a residual, in order; None after an error."""
    parts = node.items if isinstance(node, tree.ListExpr) else (node,)
    if not parts:
        t.fail(
            "E0604",
            node.span,
            "the residual is empty",
            label="nothing to minimise",
            help=["end the body with a scalar, a vector or a list of both"],
        )
        return None
    rows: list[Typed] = []
    good = True
    for part in parts:
        value = t.value(part)
        if isinstance(value, Broken):
            good = False
        elif isinstance(value.type, VectorType) or is_number(value.type):
            rows.append(value)
        else:
            good = False
            _not_residual(t, part, value)
    return rows if good else None


def _not_residual(t: Typist, node: tree.Expr, value: Typed) -> None:
    help_ = []
    if isinstance(value.type, MatrixType):
        help_ = ["use a vector or an element of it: `rotation_vector(M)`, `M.col(i)`, `M[i, j]`"]
    elif value.type == QUATERNION:
        help_ = ["write `2 * q.vec` for a small rotation, or `q.log()`"]
    elif isinstance(value.type, TransformType):
        help_ = ["write `T.log()` for its twist, or a part of it: `T.translation`"]
    elif value.type == BOOL:
        help_ = ["write a condition after `when` or in `if ... then ... else`"]
        if isinstance(value, Apply) and value.name == "eq":
            left, right = (operand.span.text for operand in value.args)
            right = f"({right})" if re.search(r"[-+]", right) else right
            help_ = [f"write the difference, which the solve makes small: `{left} - {right}`"]
    t.fail(
        "E0602",
        node.span,
        f"a residual is a scalar or a vector, found {value.type}",
        label=f"this is {value.type}",
        labels=t.origin(value),
        help=help_,
    )


def check_rows(t: Typist, guard: Typed | None, values: Sequence[Typed]) -> bool:
    """Whether the guard proves every row that is reached through an optional ref.

    `values` are the expressions that an instance evaluates. The part of the guard that reads
    parameters is one of them; the part over data alone selects the instances, and only that part is
    a proof.
    """
    parts = conjuncts(guard)
    facts = set(t.facts)
    for part in parts:
        if not moves(part):
            facts |= facts_of(part, t.slots.steps)[0]
    for node in postorder([*values, *(part for part in parts if moves(part))]):
        if not isinstance(node, LookUp | Read | Present):
            continue
        for source, column in t.slots.needs.get(node.slot, ()):
            if (source.steps, column) not in facts:
                way = ref_text(source, column)
                t.fail(
                    "E0503",
                    node.span,
                    f"the row that `{way}` points to may be absent here",
                    label=f"`when` does not test `{way}`",
                    labels=[Label(field_at(source, column).span, "declared optional here")],
                    notes=[
                        "an instance of a constraint is active only if all rows that it "
                        "reads exist; `if` cannot select rows"
                    ],
                    help=[f"write two constraints, `when {way}` and `when not {way}`"],
                )
                return False
    return True


def check_parameters(
    t: Typist, node: tree.Constraint | tree.Fit, residual: Sequence[Typed]
) -> bool:
    """Whether a residual reads a parameter, as far as the reads could be resolved."""
    if t.declarations.broken:
        return True
    reads = [n for n in postorder(residual) if isinstance(n, Read)]
    if any(n.version == "trial" and n.parameter for n in reads):
        return True
    still = [
        Label(
            n.span,
            "the stored value is constant"
            if n.version == "stored"
            else "a `compute` field has no derivative",
        )
        for n in reads
        if n.version != "data"
    ]
    name = node.name if isinstance(node, tree.Constraint) else node.collection
    t.fail(
        "E0601",
        name.span,
        "the constraint has no parameter",
        label="its residual cannot change",
        labels=still[:3],
        help=["declare an unknown as `param`"],
    )
    return False
