"""`arael info`: the content of a model."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

import click
import msgspec

from arael.cli.declarations import Declaration, declarations
from arael.compiler.compilation import compile_text
from arael.loading import find_model
from arael.runtime.layout import Column, Entity, Group, Layout, LayoutPass, Table
from arael.syntax.files import read_source


@click.command("info", short_help="Show the content of a model: structs, parameters, constraints.")
@click.argument("model")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(model: str, as_json: bool) -> None:
    """Show the structs, parameters, constraints with operation counts, and passes of MODEL."""
    compiled = compile_text(read_source(find_model(model)))
    declared = declarations(compiled.sources)
    layout = compiled.layout
    found = summary(layout, declared)
    click.echo(json.dumps(found) if as_json else "\n".join(describe(layout, declared)))


def summary(layout: Layout, declared: Sequence[Declaration]) -> dict[str, Any]:
    """Describe `layout`, and what its structs declare, as plain data."""
    return {
        "name": layout.name,
        "root": layout.root,
        "precision": layout.precision,
        "source": layout.source,
        "doc": layout.doc,
        "tables": [_table(table) for table in layout.tables],
        "entities": [
            {
                "struct": entity.struct,
                "table": entity.table,
                "parameters": list(entity.tangent_names),
            }
            for entity in layout.entities
        ],
        "constraints": [
            {
                "label": group.label,
                "table": group.table,
                "residuals": group.residuals,
                "guard": group.guard_text,
                "loss": group.loss_text,
                "require": group.require,
                "operations_before": group.operations_before,
                "operations_after": group.operations_after,
                "where": group.where,
                "doc": group.doc,
            }
            for group in layout.groups
        ],
        "functions": [
            {
                "name": function.name,
                "parameters": list(function.params),
                "native": function.native,
                "formula": function.text,
                "derivatives": list(function.derivs),
                "where": function.where,
                "doc": function.doc,
            }
            for function in layout.functions
        ],
        "passes": [p.name for p in layout.passes],
        "derived": [one.to_dict() for one in declared if one.kind == "derived"],
        "priors": [one.to_dict() for one in declared if one.kind == "prior"],
        "fixed": [one.to_dict() for one in declared if one.kind == "fixed"],
        "freezes": [
            {"pass": p.name, "freeze": list(p.freeze), "free": list(p.free)}
            for p in layout.passes
            if p.freeze or p.free
        ],
    }


def _table(table: Table) -> dict[str, Any]:
    fields = [
        {
            "path": c.path,
            "type": c.type,
            "role": c.role,
            "skip": c.skip,
            "doc": c.doc,
            **_bounds_of(c),
        }
        for c in table.columns
    ]
    return {
        "path": table.path,
        "struct": table.struct,
        "collection": table.collection,
        "doc": table.doc,
        "fields": fields,
    }


def _bounds_of(column: Column) -> dict[str, list[float | None]]:
    """Bounds by component, where the model declares some; None where open."""
    param = column.param
    if param is None or not any(b is not None for b in (*param.low, *param.high)):
        return {}
    return {
        "low": list(param.low or (None,) * param.tangent),
        "high": list(param.high or (None,) * param.tangent),
    }


def describe(layout: Layout, declared: Sequence[Declaration] = ()) -> Iterator[str]:
    """Lines of text that describe `layout`, and what its structs declare."""
    yield f"{layout.name}: root {layout.root}, {layout.precision}  ({layout.source})"
    yield from _doc(layout.doc, "  ")
    for table in layout.tables:
        yield ""
        kind = "" if table.collection == "root" else f": {table.collection} of {table.struct}"
        yield f"{table.path or 'root ' + table.struct}{kind}"
        yield from _doc(table.doc, "  ")
        yield from _fields(table)
    yield ""
    yield "parameters"
    yield from (_entity(entity) for entity in layout.entities)
    yield from _declared("derived parameters (no freedom of their own)", "derived", declared)
    yield from _declared("priors", "prior", declared)
    yield from _declared("fixed in every solve", "fixed", declared)
    yield ""
    yield "constraints (operations of residual and derivatives, before and after sharing)"
    for group in layout.groups:
        if not group.require:
            yield from _group(group)
    if layout.required:
        yield ""
        rows = sum(layout.groups[k].residuals for k in layout.required)
        yield f"what holds exactly: {rows} row{'s' * (rows != 1)} of an instance of each"
        for number in layout.required:
            yield from _group(layout.groups[number])
    if layout.functions:
        yield ""
        yield "functions (extern: bound to native code when the model is loaded)"
        for function in layout.functions:
            yield f"  {function.item}"
            yield from _doc(function.doc, "    ")
    if layout.passes:
        yield ""
        yield "passes"
        yield from (_pass(p) for p in layout.passes)


def _declared(title: str, kind: str, declared: Sequence[Declaration]) -> Iterator[str]:
    chosen = [one for one in declared if one.kind == kind]
    if chosen:
        yield ""
        yield title
    for one in chosen:
        yield f"  {one}  ({one.where})"
        yield from _doc(one.doc, "    ")


def _fields(table: Table) -> Iterator[str]:
    valued = {c.path for c in table.columns if c.role != "present"}
    shown = [c for c in _with_lists(table) if c.role != "present" or c.path not in valued]
    name_width = max((len(_head(c)) for c in shown), default=0)
    type_width = max((len(c.type) for c in shown), default=0)
    for column in shown:
        notes = [
            _bounds(column),
            _default(column),
            _held(column),
            (column.doc or "").strip().split("\n")[0],
        ]
        note = "  ".join(n for n in notes if n)
        yield f"  {_head(column):<{name_width}}  {column.type:<{type_width}}  {note}".rstrip()


def _with_lists(table: Table) -> Iterator[Column]:
    """The columns of a table, with the elements of a list of refs as one."""
    lists = {value.path: value.refs for value in table.values if value.refs}
    for column in table.columns:
        path, _, number = column.path.rpartition(".")
        if path not in lists:
            yield column
        elif number == "0":
            type_ = f"[{column.type}; {lists[path]}]"
            yield msgspec.structs.replace(column, path=path, type=type_)


def _bounds(column: Column) -> str:
    """Bounds as the model writes them; one pair where they are the same for all components."""
    found = _bounds_of(column)
    pairs = dict.fromkeys(zip(found["low"], found["high"], strict=True)) if found else {}
    ends = [" .. ".join("" if b is None else f"{b:g}" for b in pair).strip() for pair in pairs]
    return f"in {', '.join(ends)}" if ends else ""


def _default(column: Column) -> str:
    if column.default is None or column.role == "present":
        return ""
    if isinstance(column.default, str):
        return f'= "{column.default}"'
    return "= " + ", ".join(f"{value:g}" for value in column.default)


def _held(column: Column) -> str:
    """The components that the model fixes: ``fixed x, z``; ``fixed`` for all."""
    param = column.param
    if param is None or not param.held:
        return ""
    if len(param.held) == param.tangent:
        return "fixed"
    named = dict(enumerate(param.components))
    for part in param.parts:
        named |= dict.fromkeys(range(part.first, part.first + part.count), part.name)
    return "fixed " + ", ".join(dict.fromkeys(named[k] for k in param.held))


def _head(column: Column) -> str:
    prefix = "skip " if column.skip else "param " if column.role == "param" else ""
    return prefix + column.path


def _entity(entity: Entity) -> str:
    names = ", ".join(entity.tangent_names)
    place = entity.table or "root"
    return f"  {entity.struct} at {place}: {entity.tangent} per row ({names})"


def _group(group: Group) -> Iterator[str]:
    clauses = f" when {group.guard_text}" if group.guard_text else ""
    clauses += f" loss {group.loss_text}" if group.loss_text else ""
    noun = "row" if group.require else "residual"
    noun += "s" * (group.residuals != 1)
    clauses += f" {{ {group.require_text} }}" if group.require else ""
    yield (
        f"  {group.label}{clauses}: {group.residuals} {noun}, "
        f"{group.operations_before} -> {group.operations_after} operations  ({group.where})"
    )
    if group.row_sums is not None:
        terms = sum(piece.tape.operations for _, piece in group.row_sums.sums)
        yield f"    without rows; {terms} operations for each row that it sums over"
    yield from _doc(group.doc, "    ")


def _pass(p: LayoutPass) -> str:
    settings = [f"{s.column} = {', '.join(f'{v:g}' for v in s.value)}" for s in p.settings]
    settings += [f"{k} = {v}" for k, v in p.config.items()]
    settings += [f"freeze {path}" for path in p.freeze] + [f"free {path}" for path in p.free]
    return f"  {p.name}: {'; '.join(settings) or 'no changes'}"


def _doc(text: str, indent: str) -> Iterator[str]:
    for line in text.strip().split("\n") if text.strip() else ():
        yield (indent + line.strip()).rstrip()
