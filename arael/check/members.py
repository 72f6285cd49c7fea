"""Rule: the members of a struct have unique names.

Allowed: a field and a constraint of the same name; one `key`, text or a number; one `solve`.

Not allowed: two fields, or two constraints, of one name; a `key` of another type. (The grammar
decides which members a struct and a root may have.)
"""

from __future__ import annotations

import re

from arael.check.declared import StructDecl
from arael.check.report import Reporter
from arael.check.suggest import did_you_mean
from arael.check.typed import REAL, STRING
from arael.diagnostics.records import Label, Span
from arael.syntax import tree


def sort_members(struct: StructDecl, report: Reporter) -> None:
    """Sort the members of `struct` by kind and check their names."""
    fields: dict[str, Span] = {}
    constraints: dict[str, Span] = {}
    for member in struct.node.members:
        match member:
            case tree.Field():
                _own_name(member.name, fields, "E0207", "field", report)
            case tree.Constraint():
                _own_name(member.name, constraints, "E0603", "constraint", report)
                struct.constraints.append(member)
            case tree.Prior():
                name = tree.Ident(span=member.target.span, id=prior_name(member))
                _own_name(name, constraints, "E0603", "constraint", report)
                struct.priors.append((name.id, member))
            case tree.Fit():
                struct.fits.append(member)
            case tree.Marginalize():
                struct.marginalize.append(member)
            case tree.Symbolic() | tree.Compute() | tree.Tie():
                if member.name.id not in fields:
                    struct.formulas[member.name.id] = member
                _own_name(member.name, fields, "E0207", "field", report)
            case tree.Update():
                if struct.update is not None:
                    _twice(member.span, "`update` is given twice", struct.update.span, report)
                struct.update = member
            case tree.Solve():
                if struct.solve is not None:
                    _twice(member.span, "`solve` is given twice", struct.solve.span, report)
                struct.solve = member
            case _:
                pass


def prior_name(prior: tree.Prior) -> str:
    """Name of a prior among the constraints of its struct: ``prior_pos_z`` of ``pos.z``."""
    text = prior.target.span.text.removeprefix("self.")
    target = re.sub(r"\W+", "_", text).strip("_")
    return f"prior_{target}"


def check_keys(struct: StructDecl, report: Reporter) -> None:
    """Find the key of `struct`, text or a number, after its fields are resolved."""
    first: tree.Key | None = None
    for member in struct.node.members:
        if not isinstance(member, tree.Key):
            continue
        if first is not None:
            _twice(member.span, "`key` is given twice", first.span, report)
            continue
        first = member
        name = member.field.id
        field = struct.fields.get(name)
        if field is None:
            if any(isinstance(m, tree.Field) and m.name.id == name for m in struct.node.members):
                continue
            report.error(
                "E0409",
                member.field.span,
                f"{struct.name} has no field `{name}`",
                label="unknown field",
                help=did_you_mean(name, struct.fields) or [f"add `{name}: string`"],
            )
        elif field.type not in (STRING, REAL) or field.optional or field.node.role != "data":
            report.error(
                "E0409",
                member.field.span,
                "a key is a field of type `string` or `real`",
                label=f"this is `{field.text}`",
                labels=[Label(field.span, "declared here")],
            )
        elif field.type == REAL:
            struct.order = name
        else:
            struct.key = name


def _own_name(
    name: tree.Ident, taken: dict[str, Span], code: str, what: str, report: Reporter
) -> None:
    if name.id in taken:
        report.error(
            code,
            name.span,
            f"{what} `{name.id}` is declared twice",
            label="declared again here",
            labels=[Label(taken[name.id], "first declared here")],
        )
    taken.setdefault(name.id, name.span)


def _twice(span: Span, message: str, first: Span, report: Reporter) -> None:
    report.error("E0207", span, message, labels=[Label(first, "first given here")])
