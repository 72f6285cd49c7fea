"""Rule: the nesting of structs is finite.

Allowed: ``struct A { list of B }`` with ``struct B { ref A in ... }``.

Not allowed: a struct that contains itself by value, directly or through others; a collection of a
struct within that struct (a tree of unknown depth): use a ref.
"""

from __future__ import annotations

from arael.check.declared import Declarations, FieldDecl
from arael.check.report import Reporter
from arael.diagnostics.records import Label


def check_containment(declarations: Declarations, report: Reporter) -> None:
    """Report every cycle of structs that contain each other."""
    holds: dict[str, list[FieldDecl]] = {
        name: [f for f in s.fields.values() if f.kind in ("struct", "collection")]
        for name, s in declarations.structs.items()
    }
    finished: set[str] = set()
    for start in holds:
        # Depth-first search with an explicit stack; `trail` has the field followed from each
        # struct.
        trail: dict[str, FieldDecl | None] = {}
        waiting: list[tuple[str, FieldDecl | None, bool]] = [(start, None, False)]
        while waiting:
            name, by, leaving = waiting.pop()
            if leaving:
                finished.add(trail.popitem()[0])
            elif name in trail:
                assert by is not None
                names = list(trail)
                entered = [*trail.values(), by]
                _report_cycle(name, entered[names.index(name) + 1 :], report)
            elif name not in finished:
                trail[name] = by
                waiting.append((name, by, True))
                waiting.extend((f.struct, f, False) for f in reversed(holds[name]))


def _report_cycle(name: str, circle: list[FieldDecl | None], report: Reporter) -> None:
    fields = [f for f in circle if f is not None]
    chain = " -> ".join([name, *(f.struct for f in fields)])
    labels = [Label(f.span, f"holds {f.struct}") for f in fields[1:6]]
    by_value = all(f.kind == "struct" for f in fields)
    if by_value:
        what = "component" if fields[0].component else "struct"
        report.error(
            "E0401",
            fields[0].span,
            f"{what} contains itself: {chain}",
            label=f"holds {fields[0].struct} by value",
            labels=labels,
            help=["remove one of these parameters"]
            if fields[0].component
            else [f"use a reference instead: `ref {fields[0].struct} in root...`"],
        )
        return
    report.error(
        "E0402",
        fields[0].span,
        f"collection within itself: {chain}",
        label="unbounded nesting",
        labels=labels,
        help=[f"keep all of {name} in one collection, and let each refer to its owner with `ref`"],
    )
