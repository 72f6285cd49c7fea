"""Passes of a solve, with the parameters that each of them freezes."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime import layout as layouts
from arael.runtime.layout import Layout, PassSetting
from arael.runtime.store.values import convert


@dataclass(frozen=True)
class Pass:
    """One pass of a solve schedule, for ``model.solve(passes=[...])``.

    What a pass of a model's `solve { }` may do, from Python.

    Attributes
    ----------
    name : in reports and traces
    data : numbers of the root's data that are set before the pass, by path; later passes keep them
    freeze, free : what is frozen for this pass, and what of it, or of what ``solve(freeze=...)``
        froze, is free: paths of parameters or of what contains them (``"poses.ea"``, ``"poses"``),
        or the same by the name of a struct, wherever it is used (``"Pose.ea"``, ``"Pose"``)
    config : settings of `arael.LmConfig` by name, for this pass alone

    Examples
    --------
    >>> from arael import Pass
    >>> schedule = [
    ...     Pass("rough", data={"scale": 0.1}, freeze="Pose.ea", config={"max_iters": 10}),
    ...     Pass("full", data={"scale": 1}, free="Pose.ea"),
    ... ]
    """

    name: str
    data: Mapping[str, Any] = field(default_factory=dict)
    freeze: str | Iterable[str] = ()
    free: str | Iterable[str] = ()
    config: Mapping[str, Any] = field(default_factory=dict)

    def compiled(self, layout: Layout) -> layouts.LayoutPass:
        """The pass in the form of the layout.

        Raises
        ------
        AraelError
            E0701 for what is no data of the root, E0703-E0706 for a value that does not fit.
        """
        columns = {
            c.path: c for c in layout.tables[0].columns if c.role == "data" and c.kind != "string"
        }
        settings = []
        for path, value in self.data.items():
            if path not in columns:
                raise _unknown("E0701", "data of the root called", path, list(columns), layout)
            origin = f"pass {self.name}: {path}"
            kind = np.dtype({"int": np.int64, "bool": np.bool_}.get(columns[path].kind, np.float64))
            found = convert(columns[path], value, 1, kind, _naming(origin), False)
            settings.append(PassSetting(path, tuple(float(x) for x in np.ravel(found))))
        return layouts.LayoutPass(
            self.name,
            tuple(settings),
            dict(self.config),
            _listed(self.freeze),
            _listed(self.free),
        )


def _naming(origin: str) -> Callable[[int], str]:
    return lambda _: origin


def _listed(paths: str | Iterable[str]) -> tuple[str, ...]:
    return (paths,) if isinstance(paths, str) else tuple(paths)


# What a model without passes runs.
_PLAIN = (layouts.LayoutPass("solve"),)


def chosen_passes(
    layout: Layout,
    passes: str | Pass | layouts.LayoutPass | Iterable[str | Pass | layouts.LayoutPass] | None,
) -> tuple[layouts.LayoutPass, ...]:
    """The passes to run.

    Raises
    ------
    AraelError
        E1011 for a name that the model does not declare, and what `Pass.compiled` raises.
    """
    if passes is None:
        return layout.passes or _PLAIN
    if isinstance(passes, layouts.LayoutPass):
        return (passes,)
    if isinstance(passes, str):
        for one in layout.passes:
            if one.name == passes:
                return (one,)
    known = {one.name: one for one in layout.passes}
    chosen: list[layouts.LayoutPass] = []
    wanted = [passes] if isinstance(passes, str | Pass | layouts.LayoutPass) else passes
    kinds = (str, Pass, layouts.LayoutPass)
    wanted = list(wanted) if isinstance(wanted, Iterable) else wanted
    if not isinstance(wanted, list) or not all(isinstance(one, kinds) for one in wanted):
        raise wrong_argument(
            "solve", "passes", "names of passes or `arael.Pass`", passes, 'write `passes=["name"]`'
        )
    for one in wanted:
        if isinstance(one, str):
            if one not in known:
                raise _unknown("E1011", "pass", one, list(known), layout)
            chosen.append(known[one])
        else:
            chosen.append(one.compiled(layout) if isinstance(one, Pass) else one)
    return tuple(chosen) or _PLAIN


def parameter_paths(layout: Layout) -> list[str]:
    """Paths of all parameters and of their parts: ``poses.ea``, ``poses.T.rotation``."""
    found = []
    for table in layout.tables:
        for column in table.columns:
            if column.param is not None:
                path = f"{table.path}.{column.path}" if table.path else column.path
                found += [path, *(f"{path}.{part.name}" for part in column.param.parts)]
    return found


def _component_paths(layout: Layout) -> list[str]:
    """Paths of the components of vectors and Euler angles: ``poses.pos.z``."""
    return [
        f"{table.path}.{column.path}.{name}".removeprefix(".")
        for table in layout.tables
        for column in table.columns
        if column.param is not None
        for name in column.param.components
    ]


def frozen_after(layout: Layout, frozen: frozenset[str], one: layouts.LayoutPass) -> frozenset[str]:
    """Return what is frozen in the pass `one`, where `frozen` is for the whole solve.

    A freeze ends with its pass. A parameter of which a part is freed is frozen no more as a whole,
    but by its other parts.
    """
    freed = held_by(layout, one.free)
    left = (frozen | held_by(layout, one.freeze)) - freed
    return frozenset(
        path for path in left if not any(other.startswith(f"{path}.") for other in freed)
    )


def frozen_paths(layout: Layout, frozen: frozenset[str]) -> tuple[str, ...]:
    """The paths of `frozen` without parts and components of what is frozen as a whole."""
    return tuple(
        path
        for path in (*parameter_paths(layout), *_component_paths(layout))
        if path in frozen and path.rpartition(".")[0] not in frozen
    )


def held_by(layout: Layout, paths: Iterable[str]) -> frozenset[str]:
    """Paths of the parameters that `paths` name or hold, and of their parts and components."""
    wanted = tuple(one for path in paths for one in _at_all_places(layout, path))
    if not wanted:
        return frozenset()
    return frozenset(
        one
        for one in (*parameter_paths(layout), *_component_paths(layout))
        if any(one == path or one.startswith(f"{path}.") for path in wanted)
    )


def _at_all_places(layout: Layout, path: str) -> list[str]:
    """A path as it is; one that begins with the name of a struct (``Pose.ea``), at every place."""
    struct, _, rest = path.partition(".")
    fields = [c.path for c in layout.tables[0].columns] + [t.path for t in layout.tables]
    if any(field.partition(".")[0] == struct for field in fields):
        return [path]
    places = []
    for table in layout.tables:
        start = f"{table.path}." if table.path else ""
        prefixes = [f"{value.path}." for value in table.values if value.struct == struct]
        for prefix in ["", *prefixes] if table.struct == struct else prefixes:
            if rest:
                places.append(f"{start}{prefix}{rest}")
            else:
                params = (c.path for c in table.columns if c.param is not None)
                places += [start + p for p in params if p.startswith(prefix)]
    return places or [path]


def check_paths(layout: Layout, paths: Iterable[str]) -> None:
    """Raise AraelError (E1012) for a path that names no parameter and nothing that holds one."""
    for path in paths:
        if not held_by(layout, [path]):
            known = parameter_paths(layout)
            structs = (t.struct for t in layout.tables if any(c.param for c in t.columns))
            raise _unknown("E1012", "parameter", path, [*known, *structs], layout)


def _unknown(code: str, what: str, name: str, known: list[str], layout: Layout) -> AraelError:
    near = difflib.get_close_matches(name, known, 1)
    if near:
        text = f"did you mean `{near[0]}`?"
    elif known:
        text = f"there are: {', '.join(known)}"
    else:
        text = f"the model declares no {what}"
    return AraelError(
        Diagnostic(code, f"there is no {what} `{name}`", origin=layout.name, help=(text,))
    )
