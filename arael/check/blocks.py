"""Rule: a block that a model names is a block that its Hessian has.

The blocks follow from the pairs that constraints couple, so names are optional. A named block can
be listed in `into` and read from Python.

Allowed: ``hb: block Pose`` in Pose; ``hb: block (PointLandmark, Pose)`` where each has a unique
path (this struct, the struct that contains it, the root, a ref, a struct held by value); ``hb:
block (Pose, Pose)`` with two refs to Pose; ``hb_ab: block (a, b)`` with refs; ``hbt: triplets`` on
the root.

Not allowed: a block of a struct without parameters, of three items, of another struct than its
own, of a struct with several paths; two blocks of one pair; `triplets` off the root;
``skip_self_block`` beside a self block.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from arael.check.binding import Broken, Entity
from arael.check.declared import Declarations, FieldDecl, StructDecl
from arael.check.paths import Paths
from arael.check.places import Place
from arael.check.report import Reporter
from arael.check.suggest import did_you_mean
from arael.diagnostics.records import Label
from arael.syntax import tree


@dataclass(frozen=True)
class NamedBlock:
    """A block as named at a place.

    `ends` are the entities whose parameters give its rows and columns, relative to the row that
    declares the block: one for a self block, two for a cross block, none for triplets.
    """

    field: FieldDecl
    kind: Literal["self", "cross", "triplets"]
    ends: tuple[Entity, ...]


def check_blocks(struct: StructDecl, declarations: Declarations, report: Reporter) -> None:
    """Check the blocks that a struct names, as far as possible without its places."""
    for field in struct.fields.values():
        if field.kind == "triplets" and struct.node.kind != "root":
            report.error(
                "E0410",
                field.node.type.span,
                "`triplets` belong to the root",
                label="not here",
                help=[
                    "declare `hbt: triplets` in the root and write `into root.hbt`, or name the "
                    "pair: `block (a, b)`"
                ],
            )
        type_ = field.node.type
        if isinstance(type_, tree.BlockType):
            if len(type_.entities) > 2:
                names = [e.id for e in type_.entities]
                pairs = [f"block ({a}, {b})" for i, a in enumerate(names) for b in names[i + 1 :]]
                report.error(
                    "E0430",
                    type_.span,
                    f"a block couples two, found {len(names)}",
                    label="too many",
                    help=[f"name each pair: `{'`, `'.join(pairs[:3])}`"],
                )
            for entity in type_.entities:
                _exists(struct, entity, declarations, report)
    _skip(struct, report)


def _exists(
    struct: StructDecl, entity: tree.Ident, declarations: Declarations, report: Reporter
) -> None:
    if entity.id.partition("[")[0] in declarations.broken:
        return
    named = struct.field_at(entity.id)
    if named is not None and named.kind == "refs":
        report.error(
            "E0410",
            entity.span,
            f"`{entity.id}` is a list of {len(named.elements)} refs",
            label="which of them?",
            help=[f"a block couples two: `block ({entity.id}[0], ...)`"],
        )
        return
    target = declarations.structs.get(_struct_of(struct, entity.id))
    if target is None:
        refs = [f.name for f in struct.fields.values() if f.kind in ("ref", "struct")]
        report.error(
            "E0410",
            entity.span,
            f"`{entity.span.text}` is neither a struct nor a ref of {struct.name}",
            label="not a struct or ref",
            help=did_you_mean(entity.id, [*declarations.structs, *refs]),
        )
    elif target.component:
        report.error(
            "E0410",
            entity.span,
            f"the component {target.name} has no block",
            label="its parameters belong to the struct that has it",
            help=["name the struct that has the component"],
        )
    elif not target.has_params:
        report.error(
            "E0410",
            entity.span,
            f"{target.name} has no parameters",
            label="a block has the rows of its parameters",
            labels=[Label(target.node.name.span, "declared here")],
        )


def _skip(struct: StructDecl, report: Reporter) -> None:
    for member in struct.node.members:
        if not isinstance(member, tree.SkipSelfBlock):
            continue
        declared = [
            f
            for f in struct.fields.values()
            if isinstance(f.node.type, tree.BlockType)
            and [e.id for e in f.node.type.entities] == [struct.name]
        ]
        if declared:
            report.error(
                "E0433",
                member.span,
                f"{struct.name} skips its self block and names it",
                label="skipped here",
                labels=[Label(declared[0].span, "named here")],
                help=["remove one of the two"],
            )
        elif not struct.has_params:
            report.error(
                "E0433",
                member.span,
                f"{struct.name} has no parameters, so it has no self block to skip",
                label="nothing to skip",
                help=["remove it"],
            )


def named_blocks(place: Place, paths: Paths, report: Reporter) -> dict[str, NamedBlock]:
    """The blocks that the struct at a place names, without those in error."""
    blocks: dict[str, NamedBlock] = {}
    taken: dict[frozenset[tuple[object, str]], FieldDecl] = {}
    for field in place.struct.fields.values():
        if field.kind == "triplets":
            blocks[field.name] = NamedBlock(field, "triplets", ())
            continue
        if not isinstance(field.node.type, tree.BlockType):
            continue
        block = _block(place, field, field.node.type, paths, report)
        if block is None:
            continue
        key = frozenset((e.steps, e.place.prefix) for e in block.ends)
        if key in taken:
            report.error(
                "E0430",
                field.span,
                f"`{field.name}` is the block that `{taken[key].name}` names",
                label="named again here",
                labels=[Label(taken[key].span, "first named here")],
                help=["the Hessian has one block for each pair: remove one of the names"],
            )
            continue
        taken[key] = field
        blocks[field.name] = block
    return blocks


def _block(
    place: Place, field: FieldDecl, type_: tree.BlockType, paths: Paths, report: Reporter
) -> NamedBlock | None:
    declarations = paths.sites.declarations
    names = [e.id for e in type_.entities]
    for name in names:
        named = place.struct.field_at(name)
        if named is not None and named.kind == "refs":
            return None  # already reported
        target = declarations.structs.get(_struct_of(place.struct, name))
        if target is None or target.component or not target.has_params:
            return None  # already reported
    if len(names) == 1:
        if names[0] == place.struct.name:
            return NamedBlock(field, "self", (Entity((), place),))
        _foreign(place, field, type_, report)
        return None
    if len(names) > 2:
        return None
    ends: list[Entity] = []
    for ident in type_.entities:
        ways = _ways(place, ident.id, paths)
        if names[0] == names[1] and len(ways) == 2:
            return NamedBlock(field, "cross", (ways[0][1], ways[1][1]))
        if len(ways) != 1:
            _unclear(place, type_, ident, ways, report)
            return None
        ends.append(ways[0][1])
    if ends[0].same(ends[1]):
        report.error(
            "E0430",
            type_.span,
            f"both ends of the block are `{names[0]}`",
            label="couples it with itself",
            help=[f"the block of {ends[0].place.struct.name} with itself is its self block: "
                  f"`hb: block {ends[0].place.struct.name}` there"],
        )  # fmt: skip
        return None
    return NamedBlock(field, "cross", (ends[0], ends[1]))


def _struct_of(struct: StructDecl, name: str) -> str:
    """Name of the struct that a name in a block refers to: itself, or that of a field."""
    field = struct.field_at(name)
    return field.struct if field is not None and field.kind in ("ref", "struct") else name


def _ways(place: Place, name: str, paths: Paths) -> list[tuple[str, Entity]]:
    """Candidates for a name in a block: a field, or every path to a struct of that name."""
    home = Entity((), place)
    field = place.struct.field_at(name)
    fields: list[FieldDecl] = []
    for member in place.struct.fields.values():
        fields += (
            member.elements
            if member.kind == "refs"
            else [member] * (member.kind in ("ref", "struct"))
        )
    around: list[tuple[str, Entity]] = []
    if field is not None and field in fields:
        fields = [field]
    else:
        around = [("this struct", home)]
        words, here = "the parent", paths.owner(home)
        while here is not None:
            around.append((words, here))
            words, here = f"{words} of the parent", paths.owner(here)
        root = paths.root(home)
        if not any(entity.same(root) for _, entity in around):
            around.append(("the root", root))
        around = [(w, e) for w, e in around if e.place.struct.name == name]
        fields = [f for f in fields if f.struct == name]
    ways = []
    for member in fields:
        if member.kind == "struct":
            ways.append((f"`{member.name}`", Entity((), place.values[member.name])))
            continue
        target = paths.follow(home, member)
        if not isinstance(target, Broken):
            ways.append((f"`{member.shown}`", target))
    return [*around, *ways]


def _foreign(place: Place, field: FieldDecl, type_: tree.BlockType, report: Reporter) -> None:
    (ident,) = type_.entities
    struct = _struct_of(place.struct, ident.id)
    refs = [f.name for f in place.struct.fields.values() if f.kind == "ref" and f.struct == struct]
    through = ident.id if ident.id in refs else refs[0] if refs else ""
    hints = [f"declare `{field.name}: block {struct}` in {struct}"]
    if through:
        hints[0] += f", and write `into {through}.{field.name}` here"
    hints.append(f"a block that couples two names both: `block ({ident.id}, ...)`")
    report.error(
        "E0430",
        type_.span,
        f"the self block of {struct} belongs into {struct}",
        label=f"this is {place.struct.name}",
        help=hints,
    )


def _unclear(
    place: Place,
    type_: tree.BlockType,
    ident: tree.Ident,
    ways: list[tuple[str, Entity]],
    report: Reporter,
) -> None:
    if ways:
        words = [w for w, _ in ways]
        refs = [w.strip("`") for w in words if w.startswith("`")]
        taken = iter([*refs, ident.id])
        shown = [next(taken) if e.id == ident.id else e.id for e in type_.entities]
        report.error(
            "E0430",
            ident.span,
            f"`{ident.id}` is reached in {len(ways)} ways",
            label=f"{', '.join(words[:-1])} or {words[-1]}",
            help=[f"write the name of the field: `block ({', '.join(shown)})`"],
        )
        return
    refs = [f.name for f in place.struct.fields.values() if f.kind == "ref"]
    refs_text = f"its refs are `{'`, `'.join(refs)}`" if refs else "it has no refs"
    report.error(
        "E0430",
        ident.span,
        f"{place.struct.name} does not reach a {ident.id}",
        label="not coupled here",
        notes=[f"a block of {place.struct.name} couples itself, structs it holds by value, what "
               f"contains it, the root, and the targets of its refs; {refs_text}"],
        help=[f"declare the block where the constraint is that couples the two, or add "
              f"`x: ref {ident.id} in ...`"],
    )  # fmt: skip
