"""Rule: `fixed` names parameters of its struct, or components of them.

Allowed: ``fixed f``, ``fixed f.x, pos.z``, ``fixed T.rotation``.

Not allowed: data, a component that does not exist, a parameter of another struct.
"""

from __future__ import annotations

import msgspec

from arael.check.declared import FieldDecl, StructDecl
from arael.check.report import Reporter
from arael.check.suggest import did_you_mean
from arael.diagnostics.records import Label
from arael.runtime.layout import Param
from arael.syntax import tree


def apply_fixed(struct: StructDecl, report: Reporter) -> None:
    """Hold the parameters that the `fixed` members of `struct` name."""
    for member in struct.node.members:
        if isinstance(member, tree.Fixed):
            for path in member.paths:
                _hold(struct, path, report)


def _hold(struct: StructDecl, path: tree.Path, report: Reporter) -> None:
    first, *rest = path.parts
    field = struct.fields.get(first.id)
    if field is None:
        if not any(
            isinstance(m, tree.Field) and m.name.id == first.id for m in struct.node.members
        ):
            report.error(
                "E0405",
                first.span,
                f"{struct.name} has no field `{first.id}`",
                label="unknown parameter",
                labels=[Label(struct.node.name.span, "this struct")],
                help=did_you_mean(first.id, struct.fields),
            )
        return
    if field.param is None:
        inside = f"write `fixed` in {field.struct}" if field.struct else ""
        report.error(
            "E0411",
            first.span,
            f"`{first.id}` is not a parameter",
            label=f"this is `{field.text}`",
            labels=[Label(field.span, "declared here")],
            help=[inside] if inside else ["data is never solved for: omit `fixed`"],
        )
        return
    scalars = _scalars(field.param, [part.id for part in rest])
    if scalars is None:
        _no_component(field, field.param, path, report)
        return
    held = tuple(sorted({*field.param.held, *scalars}))
    field.param = msgspec.structs.replace(field.param, held=held)


def _scalars(param: Param, parts: list[str]) -> range | None:
    """Tangent scalars of a component or a part; None if there is none of that name."""
    if not parts:
        return range(param.tangent)
    if len(parts) > 1:
        return None
    if parts[0] in param.components:
        at = param.components.index(parts[0])
        return range(at, at + 1)
    for part in param.parts:
        if part.name == parts[0]:
            return range(part.first, part.first + part.count)
    return None


def _no_component(field: FieldDecl, param: Param, path: tree.Path, report: Reporter) -> None:
    has = [*param.components, *(part.name for part in param.parts)]
    report.error(
        "E0411",
        path.span,
        f"`{field.name}` has no component `{'.'.join(p.id for p in path.parts[1:])}` to hold",
        label=f"it has {', '.join(has)}" if has else "it is held as a whole",
        labels=[Label(field.span, f"`{field.name}` is declared `{field.text}` here")],
        help=[] if has else [f"write `fixed {field.name}`"],
    )
