"""Rule: named blocks and what a model asks to marginalize exist and have parameters.

The blocks themselves are worked out from what constraints couple; naming them changes nothing of
the solution, so what is named only has to make sense.

Allowed: ``hb: block Pose``, ``hb_ab: block (a, b)`` with refs, ``hbt: triplets`` on the root,
``into [hb_pose, root.hbt]``, ``marginalize landmarks``.

Not allowed: a block of a struct without parameters, ``into`` something that is not a block.
"""

from __future__ import annotations

from arael.check.binding import Collection, Entity
from arael.check.declared import Declarations, FieldDecl, StructDecl
from arael.check.paths import Paths
from arael.check.places import Place, Sites
from arael.check.report import Reporter
from arael.check.suggest import did_you_mean
from arael.diagnostics.records import Label
from arael.syntax import tree


def check_blocks(struct: StructDecl, declarations: Declarations, report: Reporter) -> None:
    """Check the blocks that a struct names."""
    for field in struct.fields.values():
        if field.kind == "triplets" and struct.node.kind != "root":
            report.error(
                "E0410",
                field.node.type.span,
                "`triplets` belong to the root",
                label="not here",
            )
        if isinstance(field.node.type, tree.BlockType):
            for entity in field.node.type.entities:
                _entity(struct, entity, declarations, report)


def _entity(
    struct: StructDecl, entity: tree.Ident, declarations: Declarations, report: Reporter
) -> None:
    if entity.id in declarations.broken:
        return
    field = struct.fields.get(entity.id)
    name = field.struct if field is not None and field.kind == "ref" else entity.id
    target = declarations.structs.get(name)
    if target is None:
        refs = [f.name for f in struct.fields.values() if f.kind == "ref"]
        report.error(
            "E0410",
            entity.span,
            f"`{entity.id}` is neither a struct nor a ref of {struct.name}",
            label="a block of what?",
            help=did_you_mean(entity.id, [*declarations.structs, *refs]),
        )
    elif not target.has_params:
        report.error(
            "E0410",
            entity.span,
            f"{target.name} has no parameters",
            label="a block has the rows of its parameters",
            labels=[Label(target.node.name.span, "declared here")],
        )


def check_into(place: Place, constraint: tree.Constraint, paths: Paths, report: Reporter) -> None:
    """Check that what follows `into` names blocks."""
    for path in constraint.into:
        *before, last = path.parts
        holder: Entity | None = Entity((), place)
        if before:
            leading = tree.Path(parts=tuple(before), span=path.span)
            found = paths.walk(Entity((), place), leading, own=True)
            holder = found if isinstance(found, Entity) else None
            if isinstance(found, Collection):
                report.error(
                    "E0410", path.span, f"`{leading}` is a collection", label="not a block"
                )
        if holder is None:
            continue
        fields = holder.place.struct.fields
        field = fields.get(last.id)
        if field is None:
            if last.id not in paths.sites.declarations.broken:
                blocks = [f.name for f in fields.values() if _is_block(f)]
                report.error(
                    "E0410",
                    last.span,
                    f"{holder.place.struct.name} has no block `{last.id}`",
                    label="unknown block",
                    help=did_you_mean(last.id, blocks)
                    or ["leave `into` out: blocks are found without it"],
                )
        elif not _is_block(field):
            report.error(
                "E0410",
                last.span,
                f"`{path}` is not a block",
                label=f"this is `{field.text}`",
                labels=[Label(field.span, "declared here")],
            )


def _is_block(field: FieldDecl) -> bool:
    return field.kind in ("block", "triplets")


def check_marginalize(sites: Sites, paths: Paths, report: Reporter) -> None:
    """Check that `marginalize` names collections whose elements have parameters."""
    root = Entity((), sites.root.place)
    for member in sites.root.place.struct.marginalize:
        for path in member.paths:
            found = paths.walk(root, path, own=True)
            if isinstance(found, Entity):
                report.error(
                    "E0411",
                    path.span,
                    f"`{path}` is not a collection",
                    label="marginalize takes collections of entities",
                )
            elif isinstance(found, Collection):
                struct = found.site.place.struct
                if not any(p.struct.has_params for p in found.site.places()):
                    report.error(
                        "E0411",
                        path.span,
                        f"{struct.name} has no parameters",
                        label="nothing to eliminate",
                        labels=[Label(struct.node.name.span, "declared here")],
                    )
