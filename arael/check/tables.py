"""The tables and columns of the runtime, from the places of a model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from arael.check.binding import Broken, Entity
from arael.check.blocks import NamedBlock
from arael.check.declared import FieldDecl
from arael.check.field_reads import field_at, ref_text
from arael.check.paths import Paths
from arael.check.places import Place, Sites, TableSite, stored_fields
from arael.check.typed import ComponentSite, EntitySite, ScalarType
from arael.diagnostics.records import Label
from arael.runtime.layout import Block, BlockEnd, ByValue, Column, Slot, Table


def check_refs(sites: Sites, paths: Paths) -> None:
    """Resolve every ref at every place, so that each mistake in one is reported."""
    for place in sites.places():
        for field in place.struct.fields.values():
            ref = field.elements[0] if field.kind == "refs" else field
            if ref.kind == "ref":
                paths.target(place, ref)
                _check_chain(place, ref, paths)


def _check_chain(place: Place, field: FieldDecl, paths: Paths) -> None:
    """Report a non-optional ref whose target collection may be absent."""
    if field.optional:
        return
    collection = paths.resolve(Entity((), place), field)
    if isinstance(collection, Broken) or not collection.owner.needs:
        return
    source, column = collection.owner.needs[0]
    through = field_at(source, column)
    paths.report.error(
        "E0415",
        field.span,
        f"`{field.name}` is resolved through `{ref_text(source, column)}`, which may be null",
        label="then has no target collection",
        labels=[Label(through.span, f"declared `{through.text}` here")],
        help=[
            "start the path of a list of refs at `root` or `parent`"
            if "." in field.name
            else f"make it optional as well: `{field.name}: {field.text}?`"
        ],
    )


def build_tables(sites: Sites, paths: Paths) -> tuple[Table, ...]:
    """All tables, the root first, owners before owned."""
    return tuple(_table(site, paths) for site in sites.tables.values())


def build_entities(
    sites: Sites, tables: tuple[Table, ...], components: Mapping[Place, tuple[ComponentSite, ...]]
) -> tuple[EntitySite, ...]:
    """Every place of a struct with parameters, in the order of tables.

    `components` has those of each place, by the identity of the place.
    """
    by_path = {t.path: {c.path: c for c in t.columns if c.role != "present"} for t in tables}
    entities = []
    for place in sites.places():
        if place.struct.has_params and not place.struct.component:
            columns = by_path[place.table.path]
            entities.append(
                EntitySite(
                    place.struct.name,
                    place.table.path,
                    place.prefix,
                    tuple(columns[p.column(f)] for p, f in stored_fields(place)),
                    components[place],
                )
            )
    return tuple(entities)


def _table(site: TableSite, paths: Paths) -> Table:
    struct = site.place.struct
    columns: list[Column] = []
    values: list[ByValue] = []
    _flatten(site.place, paths, columns, values)
    declared = site.declared
    return Table(
        path=site.path,
        struct=struct.name,
        collection=site.collection,
        parent=site.parent,
        field=site.path_in_parent,
        where=declared.where if declared else str(struct.node.name.span),
        columns=tuple(columns),
        values=tuple(values),
        key=struct.key,
        doc=declared.node.doc if declared and declared.node.doc else struct.node.doc,
    )


def _flatten(top: Place, paths: Paths, columns: list[Column], values: list[ByValue]) -> None:
    """Columns of a place and of the structs held by value in it, in order of declaration."""
    waiting: list[Iterator[tuple[Place, FieldDecl]]] = [_fields(top)]
    while waiting:
        following = next(waiting[-1], None)
        if following is None:
            waiting.pop()
            continue
        place, field = following
        within = place.optionals[-1] if place.optionals else ""
        path = place.column(field)
        if field.kind == "struct":
            if field.optional:
                columns.append(_present(field, path))
            values.append(ByValue(path, field.struct, field.optional, field.where, within))
            waiting.append(_fields(place.values[field.name]))
        elif field.kind == "refs":
            count = len(field.elements)
            values.append(ByValue(path, field.struct, False, field.where, within, refs=count))
            for ref in field.elements:
                column = _column(place, ref, place.column(ref), within, paths)
                if column is not None:
                    columns.append(column)
        elif field.kind in ("column", "ref", "constraint_index"):
            column = _column(place, field, path, path if field.optional else within, paths)
            if column is not None:
                columns.append(column)
            if field.optional:
                columns.append(_present(field, path))  # after its values: `path` names those


def _fields(place: Place) -> Iterator[tuple[Place, FieldDecl]]:
    return ((place, field) for field in place.struct.fields.values())


def _present(field: FieldDecl, path: str) -> Column:
    return Column(
        path=path,
        kind="bool",
        shape=(),
        role="present",
        type=field.text,
        where=field.where,
        within=path,
        doc=field.node.doc,
    )


def _column(place: Place, field: FieldDecl, path: str, within: str, paths: Paths) -> Column | None:
    if field.kind == "ref":
        target = paths.target(place, field)
        if target is None:
            return None
        return Column(
            path=path,
            kind="int",
            shape=(),
            role="ref",
            type=field.text,
            where=field.where,
            target=target,
            within=within,
            doc=field.node.doc,
            skip=field.node.role == "skip",
        )
    if field.kind == "constraint_index":
        return Column(
            path=path,
            kind="int",
            shape=(),
            role="constraint_index",
            type=field.text,
            where=field.where,
            within=within,
            doc=field.node.doc,
        )
    kind = field.type.kind if isinstance(field.type, ScalarType) else "real"
    return Column(
        path=path,
        kind=kind,
        shape=field.shape,
        role="param" if field.param else "skip" if field.node.role == "skip" else "data",
        type=field.text,
        where=field.where,
        unit=field.unit,
        default=field.default,
        param=field.param,
        within=within,
        doc=field.node.doc,
        skip=field.node.role == "skip",
    )


def build_blocks(
    sites: Sites, entities: Sequence[EntitySite], blocks: Mapping[Place, Mapping[str, NamedBlock]]
) -> tuple[Block, ...]:
    """The named blocks of all places, in the form of the runtime."""
    number = {(e.table, e.prefix): i for i, e in enumerate(entities)}
    return tuple(
        Block(
            name=name,
            table=place.table.path,
            prefix=place.prefix,
            kind=block.kind,
            ends=tuple(
                BlockEnd(
                    Slot(end.steps, end.place.table.path),
                    number[end.place.table.path, end.place.prefix],
                )
                for end in block.ends
            ),
            where=block.field.where,
            doc=block.field.node.doc,
        )
        for place in sites.places()
        for name, block in blocks[place].items()
    )
