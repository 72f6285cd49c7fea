"""Rule: every item of a model has a unique name.

Allowed: items in any order, over several files; a file imported twice (its items count once).

Not allowed: two items of one name; the name of something built in; circular imports.
"""

from __future__ import annotations

from collections.abc import Callable

from arael.check.builtins import BUILTIN_NAMES
from arael.check.declared import Declarations, StructDecl
from arael.check.report import Reporter
from arael.check.suggest import nearest
from arael.check.types import TYPE_NAMES
from arael.diagnostics.records import Label, Span
from arael.syntax import tree

Load = Callable[[tree.Import], tree.File]


class Gathering:
    """Collects the items of a file and of all it imports."""

    def __init__(self, load: Load | None, report: Reporter) -> None:
        self.load = load
        self.report = report
        self.found = Declarations()
        self.names: dict[str, Span] = {}
        self.done: set[str] = set()
        self.chain: list[str] = []

    def file(self, file: tree.File) -> None:
        """Add the items of one file, imports first."""
        self.done.add(file.source.name)
        self.chain.append(file.source.name)
        for item in file.items:
            if isinstance(item, tree.Import):
                self._import(item)
        for item in file.items:
            if not isinstance(item, tree.Import):
                self._item(item)
        self.chain.pop()

    def _import(self, item: tree.Import) -> None:
        if self.load is None:
            self.report.error(
                "E0907",
                item.span,
                "this text cannot import other files",
                label=f"imports {item.path.value!r}",
                help=["save the model as a file and load it by its path"],
            )
            return
        file = self.load(item)
        if file.source.name in self.chain:
            circle = self.chain[self.chain.index(file.source.name) :]
            self.report.error(
                "E0212",
                item.span,
                f"circular import: {' -> '.join([*circle, file.source.name])}",
                label="this import closes the cycle",
                help=["move what both files need into a third one"],
            )
        elif file.source.name not in self.done:
            self.file(file)

    def _item(self, item: tree.Const | tree.Function | tree.Struct) -> None:
        name = item.name.id
        if name in BUILTIN_NAMES or name in TYPE_NAMES:
            self.report.error(
                "E0208",
                item.name.span,
                f"`{name}` belongs to the language",
                label="choose another name",
            )
            self.found.broken.add(name)
            return
        if name in self.names:
            self.report.error(
                "E0206",
                item.name.span,
                f"`{name}` is declared twice",
                label="declared again here",
                labels=[Label(self.names[name], "first declared here")],
            )
            return
        self.names[name] = item.name.span
        if isinstance(item, tree.Const):
            self.found.consts[name] = item
        elif isinstance(item, tree.Function):
            self.found.functions[name] = item
        else:
            self.found.structs[name] = StructDecl(item)


def gather(file: tree.File, load: Load | None, report: Reporter) -> Declarations:
    """All items of `file` and its imports."""
    gathering = Gathering(load, report)
    gathering.file(file)
    return gathering.found


def choose_root(
    file: tree.File, declarations: Declarations, wanted: str | None, report: Reporter
) -> StructDecl | None:
    """The root to compile: the only one, or the requested one."""
    roots = {r.name: r for r in declarations.roots}
    start = Span(file.source, 0, 0)
    if wanted is not None and wanted in roots:
        return roots[wanted]
    if not roots:
        report.error(
            "E0211",
            start,
            "the model has no root",
            notes=["the root is the struct that contains all others, one per model"],
            help=["declare it as `root NAME { ... }` with a `list of` each struct"],
        )
        return None
    names = ", ".join(roots)
    if wanted is not None:
        near = nearest(wanted, roots)
        report.error(
            "E0210",
            start,
            f"the model has no root `{wanted}`",
            notes=[f"roots of this model: {names}"],
            help=[f"did you mean `{near}`?"] if near else [],
        )
        return None
    if len(roots) > 1:
        report.error(
            "E0210",
            next(iter(roots.values())).node.name.span,
            f"the model has several roots: {names}",
            labels=[Label(r.node.name.span, "another root") for r in list(roots.values())[1:]],
            help=["give the name of one of them"],
        )
        return None
    return next(iter(roots.values()))
