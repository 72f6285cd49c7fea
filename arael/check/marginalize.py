"""Rule: `marginalize` names collections whose elements have parameters."""

from __future__ import annotations

from arael.check.binding import Collection, Entity
from arael.check.paths import Paths
from arael.check.places import Sites
from arael.check.report import Reporter
from arael.diagnostics.records import Label


def check_marginalize(sites: Sites, paths: Paths, report: Reporter) -> tuple[str, ...]:
    """Check that `marginalize` names collections whose elements have parameters; their tables."""
    tables: dict[str, None] = {}
    root = Entity((), sites.root.place)
    for member in sites.root.place.struct.marginalize:
        for path in member.paths:
            target = paths.walk(root, path, own=True, through=True)
            if isinstance(target, Entity):
                report.error(
                    "E0411",
                    path.span,
                    f"`{path}` is not a collection",
                    label="marginalize takes collections of entities",
                )
            elif isinstance(target, Collection):
                struct = target.site.place.struct
                if not any(p.struct.has_params for p in target.site.places()):
                    report.error(
                        "E0411",
                        path.span,
                        f"{struct.name} has no parameters",
                        label="nothing to eliminate",
                        labels=[Label(struct.node.name.span, "declared here")],
                    )
                else:
                    tables[target.site.place.table.path] = None
    return tuple(tables)
