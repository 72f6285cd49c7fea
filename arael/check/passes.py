"""Rule: a pass sets data of the root or settings of the solver.

Allowed: ``pass fine { scale = 1.0  rel_precision = 1e-6  freeze poses.ea  free landmarks }``;
``freeze Pose.ea`` and ``freeze Pose``, at every place of that struct.

Not allowed: a misspelt name, a setting of the wrong kind, freezing a field that is not a parameter,
freezing a parameter that the pass freed before.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields

from arael.check.constants import Constants
from arael.check.declared import FieldDecl, StructDecl
from arael.check.defaults import constant_for
from arael.check.paths import Paths
from arael.check.places import Place, Sites
from arael.check.report import Reporter
from arael.check.suggest import did_you_mean
from arael.check.typed import BOOL, STRING
from arael.config import LmConfig, refused
from arael.diagnostics.records import Label, Span
from arael.runtime.layout import LayoutPass, PassSetting
from arael.syntax import tree

WHOLE = frozenset({"max_iters", "min_iters", "patience", "num_threads"})
REALS = frozenset(
    {
        "abs_precision",
        "rel_precision",
        "initial_lambda",
        "lambda_floor",
        "cost_threshold",
        "gradient_tolerance",
        "parameter_tolerance",
        "predicted_reduction_tolerance",
        "min_diagonal",
        "time_limit",
    }
)
SWITCHES = frozenset({"verbose"})
SETTINGS = WHOLE | REALS | SWITCHES
# Settings that a pass does not take: words, functions, and limits of the damped strategy.
FROM_PYTHON = frozenset(one.name for one in fields(LmConfig)) - SETTINGS


class Passes:
    """Resolves the solve schedule of the root."""

    def __init__(self, sites: Sites, paths: Paths, constants: Constants, report: Reporter) -> None:
        self.sites = sites
        self.root = sites.root.place
        self.paths = paths
        self.constants = constants
        self.report = report

    def all(self) -> tuple[LayoutPass, ...]:
        """The passes in order."""
        solve = self.root.struct.solve
        if solve is None:
            return ()
        taken: dict[str, Span] = {}
        for node in solve.passes:
            if node.name.id in taken:
                self.report.error(
                    "E0207",
                    node.name.span,
                    f"pass `{node.name.id}` is declared twice",
                    label="declared again here",
                    labels=[Label(taken[node.name.id], "first declared here")],
                )
            taken.setdefault(node.name.id, node.name.span)
        return tuple(self._pass(node) for node in solve.passes)

    def _pass(self, node: tree.PassBlock) -> LayoutPass:
        settings: list[PassSetting] = []
        config: dict[str, float | int | bool | str] = {}
        lists: dict[bool, list[tuple[str, Span]]] = {True: [], False: []}
        given: dict[str, Span] = {}
        for step in node.steps:
            if isinstance(step, tree.Freeze):
                for path in step.paths:
                    parameters = [(full, path.span) for full in self._parameters(path)]
                    if not step.free:
                        self._contradiction(path, parameters, lists[True])
                    lists[step.free] += parameters
                continue
            name = str(step.target).removeprefix("root.")
            if name in given:
                self.report.error(
                    "E0207",
                    step.target.span,
                    f"`{name}` is set twice in one pass",
                    labels=[Label(given[name], "first set here")],
                )
            given.setdefault(name, step.target.span)
            self._setting(step, name, settings, config)
        frozen, freed = ([path for path, _ in lists[free]] for free in (False, True))
        return LayoutPass(node.name.id, tuple(settings), config, tuple(frozen), tuple(freed))

    def _contradiction(
        self, path: tree.Path, parameters: list[tuple[str, Span]], freed: list[tuple[str, Span]]
    ) -> None:
        """Report a path that is frozen after it, or a part of it, was freed.

        All `freeze` of a pass are applied before all `free`, so that `free` would override a
        `freeze` that is written after it.
        """
        for full, _ in parameters:
            for earlier, first in freed:
                if _is_within(full, earlier) or _is_within(earlier, full):
                    self.report.error(
                        "E0207",
                        path.span,
                        f"`{path}` is frozen after it, or a part of it, was freed",
                        label="frozen here",
                        labels=[Label(first, "freed here")],
                        help=[
                            "remove one of the two, or free after freezing: "
                            "`freeze poses  free poses.ea` fixes all but `ea`"
                        ],
                    )
                    return

    def _setting(
        self,
        step: tree.Setting,
        name: str,
        settings: list[PassSetting],
        config: dict[str, float | int | bool | str],
    ) -> None:
        found = self._root_field(step.target)
        if found is None and name in SETTINGS:
            value = self._config_value(name, step.value)
            if value is not None:
                config[name] = value
            return
        if found is None:
            self._unknown(step.target, name)
            return
        place, field = found
        if str(step.target) in SETTINGS:
            self.report.error(
                "E0202",
                step.target.span,
                f"`{name}` means two things here",
                label="a setting of the solver, or a field of the root",
                labels=[Label(field.span, "the field")],
                help=[f"write `root.{name}` for the field, or rename it"],
            )
            return
        if field.kind != "column" or field.node.role != "data" or field.type == STRING:
            self.report.error(
                "E0209",
                step.target.span,
                f"a pass cannot set `{name}`",
                label=f"this is `{field.text}`" if not field.param else "this is a parameter",
                labels=[Label(field.span, "declared here")],
                help=["a pass sets numbers of the root's data"],
            )
            return
        values = constant_for(field, step.value, self.constants, self.report)
        if values is not None:
            settings.append(PassSetting(place.column(field), values))

    def _root_field(self, path: tree.Path) -> tuple[Place, FieldDecl] | None:
        """The field of the root, or of a struct held by value in it, that `path` names."""
        parts = [p.id for p in path.parts]
        if len(parts) > 1 and parts[0] in ("root", self.paths.root_name):
            parts = parts[1:]
        place = self.root
        for part in parts[:-1]:
            if part not in place.values:
                return None
            place = place.values[part]
        field = place.struct.fields.get(parts[-1])
        return (place, field) if field is not None else None

    def _unknown(self, target: tree.Path, name: str) -> None:
        if name in self.constants.declarations.broken:
            return
        columns = [f.name for f in self.root.struct.fields.values() if f.kind == "column"]
        label = "neither a field of the root nor a setting of the solver"
        help_lines = did_you_mean(name, [*columns, *sorted(SETTINGS)])
        if name in FROM_PYTHON:
            label = "a pass cannot set this setting of the solver"
            help_lines = [f"set it from Python: `model.solve({name}=...)`"]
        self.report.error(
            "E0209", target.span, f"unknown setting `{name}`", label=label, help=help_lines
        )

    def _config_value(self, name: str, node: tree.Expr) -> float | int | bool | None:
        found = self.constants.evaluate(node)
        if found is None:
            return None
        value = found.values[0]
        expected = ""
        if name in SWITCHES:
            expected = "" if found.type == BOOL else "true or false"
        elif found.type == BOOL or len(found.values) != 1:
            expected = "a number"
        if expected:
            self.report.error(
                "E0310", node.span, f"`{name}` takes {expected}", label=f"this is {found.type}"
            )
            return None
        if name in SWITCHES:
            return bool(value)
        setting = int(value) if name in WHOLE and value.is_integer() else value
        refusal = refused(name, setting)
        if refusal:
            self.report.error("E0310", node.span, f"`{name}` cannot be {setting:g}", label=refusal)
            return None
        return setting

    def _parameters(self, path: tree.Path) -> list[str]:
        """The checked paths of a `freeze` or `free`; empty after an error."""
        parts = path.parts
        struct = self.sites.declarations.structs.get(parts[0].id)
        if struct is not None and parts[0].id not in self.root.struct.fields:
            return self._of_type(struct, path)
        if len(parts) > 1 and parts[0].id in ("root", self.paths.root_name):
            parts = parts[1:]
        return self._at(self.root, parts)

    def _of_type(self, struct: StructDecl, path: tree.Path) -> list[str]:
        """The same for a struct, at all its places: its parameters, or those that `path` names."""
        places = [p for p in self.sites.places() if p.struct is struct]
        paths: list[str] = []
        if len(path.parts) > 1:
            for place in places:
                here = self._at(place, path.parts[1:])
                if not here:
                    break
                paths += here
            return paths
        for place in places:
            for below in _below(place):
                params = (f for f in below.struct.fields.values() if f.param is not None)
                paths += [_full(below, field.name) for field in params]
        if not paths:
            self.report.error(
                "E0411",
                path.span,
                f"`{path}` has no parameters" if places else f"no struct or root contains `{path}`",
                label="nothing to freeze or free",
                labels=[Label(struct.node.name.span, "declared here")],
            )
        return paths

    def _at(self, start: Place, parts: tuple[tree.Ident, ...]) -> list[str]:
        """The path of the target of `parts` from `start`, in a list; empty after an error."""
        *before, last = parts
        place = start
        text = _full(start, ".".join(p.id for p in parts))
        for part in before:
            if part is before[-1] and _is_part(place.struct.fields.get(part.id), last.id):
                return [text]
            target = self._step(place, part)
            if target is None:
                return []
            place = target
        field = place.struct.fields.get(last.id)
        if field is not None and field.param is not None:
            return [text]
        below: Iterable[Place] = ()
        if field is not None and field.kind == "struct":
            below = _below(place.values[last.id])
        elif field is not None and field.kind == "collection":
            below = place.collections[last.id].places()
        if any(p.struct.has_params for p in below):
            return [text]
        if field is None:
            if last.id not in self.constants.declarations.broken:
                self._no_field(place, last)
            return []
        self.report.error(
            "E0411",
            last.span,
            f"`{'.'.join(p.id for p in parts)}` has no parameters",
            label=f"this is `{field.text}`",
            labels=[Label(field.span, "declared here")],
        )
        return []

    def _step(self, place: Place, part: tree.Ident) -> Place | None:
        """One step of a path; through a collection it means all elements."""
        if part.id in place.values:
            return place.values[part.id]
        if part.id in place.collections:
            return place.collections[part.id].place
        self._no_field(place, part)
        return None

    def _names(self, place: Place) -> list[str]:
        """Possible continuations of a path; at its start also the names of structs."""
        structs = self.sites.declarations.structs if place is self.root else {}
        return [*place.struct.fields, *structs]

    def _no_field(self, place: Place, part: tree.Ident) -> None:
        self.report.error(
            "E0405",
            part.span,
            f"{place.struct.name} has no field `{part.id}`",
            label="unknown part of a path",
            labels=[Label(place.struct.node.name.span, "this struct")],
            help=did_you_mean(part.id, self._names(place)),
        )


def _full(place: Place, path: str) -> str:
    """A path within a place as one from the root."""
    start = f"{place.table.path}." if place.table.path else ""
    return f"{start}{place.prefix}{path}"


def _is_within(path: str, outer: str) -> bool:
    return path == outer or path.startswith(f"{outer}.")


def _is_part(field: FieldDecl | None, name: str) -> bool:
    """Whether `name` is a part of a parameter that freezes by itself (``T.rotation``)."""
    return (
        field is not None
        and field.param is not None
        and (name in field.param.components or any(p.name == name for p in field.param.parts))
    )


def _below(place: Place) -> list[Place]:
    places, waiting = [], [place]
    while waiting:
        here = waiting.pop()
        places.append(here)
        waiting.extend(here.values.values())
    return places
