"""Commands on freedom, redundancy and influence: `dof`, `why`, `free`, `what_if`."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.sketch.commands.constraints import inner_command, rejected
from arael.sketch.commands.describing import record_line
from arael.sketch.commands.dimensions import dimension_of
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.judge.alike import MOST, alike

MAX_DENSE = 4000
"""Unknowns and rows of a sketch whose singular values are shown."""

MAX_SHOWN = 200
"""Singular values and rows that are shown."""


@command(
    "dof",
    group="ask",
    usage=["dof", "dof analyze", "dof eigenvalues", "dof singular", "dof jacobian"],
    summary="Count the degrees of freedom, or look into them.",
    details="""
`analyze` says what can still move. `eigenvalues` are those of J'J, one per unknown; `singular`
shows the singular values of J with their directions and the constraints that resist them;
`jacobian` lists its rows. Ranges do not count.
""",
    arguments=("what=",),
)
def dof(session: Session, words: Words) -> Reply:
    """Degrees of freedom."""
    kinds = ("analyze", "eigenvalues", "singular", "jacobian")
    what = words.choice("what to show", *kinds) if words else ""
    words.end()
    if what == "analyze":
        return _free(session)
    if what:
        return _TABLES[what](_linearised(session))
    freedoms = session.editor.judge.freedoms()
    text = f"{freedoms.total} degree{'' if freedoms.total == 1 else 's'} of freedom"
    if freedoms.redundant:
        text += f"; redundant: {', '.join(freedoms.redundant)}"
    data = {
        "freedoms": freedoms.total,
        "by_entity": dict(freedoms.by_entity),
        "redundant": list(freedoms.redundant),
    }
    return Reply(text, remembered=False, data=data)


@command(
    "free",
    group="ask",
    usage=["free"],
    summary="Say in words what can still move.",
    details="""
Of more than six motions those that differ by names only are one sentence, with their number.
""",
    arguments=(),
)
def free(session: Session, words: Words) -> Reply:
    """What can still move."""
    words.end()
    return _free(session)


def _free(session: Session) -> Reply:
    motions = session.editor.judge.free()
    groups = alike(motions)
    count = f"{len(motions)} degree{'' if len(motions) == 1 else 's'} of freedom"
    lines = [one.sentence + (f" ({one.count})" if one.count > 1 else "") for one in groups[:MOST]]
    rest = sum(one.count for one in groups[MOST:])
    if rest:
        lines.append(f"and {rest} more")
    text = "\n".join([f"{count}:", *(f"  {line}" for line in lines)])
    moving = [{"sentence": m.sentence, "entities": list(m.entities)} for m in motions]
    return Reply(
        text if motions else "Nothing can move: the sketch is fully defined",
        remembered=False,
        data={
            "freedoms": len(motions),
            "motions": moving,
            "groups": [
                {"sentence": one.sentence, "entities": list(one.entities), "count": one.count}
                for one in groups
            ],
        },
    )


@command(
    "why",
    group="ask",
    usage=["why L0", "why L0.p1"],
    summary="List what holds an entity or a point.",
    arguments=("name",),
)
def why(session: Session, words: Words) -> Reply:
    """What holds an entity or a point."""
    found = words.operand()
    words.end()
    names = session.editor.judge.why(found.handle)
    records = [session.document.find(name) for name in names]
    lines = [f"  {record_line(session, one)}" for one in records if one is not None]
    head = f"{found.handle} is held by:" if lines else f"Nothing holds {found.handle}"
    return Reply("\n".join([head, *lines]), remembered=False, data={"holds": list(names)})


@command(
    "what_if",
    group="ask",
    usage=["what_if <command>"],
    summary="Say what a command would change: freedoms, and how far things move.",
    details="""
```
what_if length L0 12
what_if delete C3
```
""",
    arguments=("*command",),
)
def what_if(session: Session, words: Words) -> Reply:
    """What a command would change."""
    start = inner_command(session, words)
    statement = words.statement
    text = statement.source.text[start : statement.end]
    document = session.document
    before = session.editor.judge.freedoms().total
    kept = {e.name: document.numbers_of(e.name).copy() for e in document.entities.values()}

    def trial() -> tuple[Reply, int, dict[str, float]]:
        reply = session.call(statement, start)
        after = session.editor.judge.freedoms().total
        moved = {
            name: float(np.abs(document.numbers_of(name) - old).max())
            for name, old in kept.items()
            if name in document.entities and len(document.numbers_of(name)) == len(old)
        }
        return reply, after, moved

    with session.dry_run():
        try:
            reply, after, moved = session.editor.explain(trial)
        except AraelError as error:
            return rejected(text, error)
    far = {name: by for name, by in sorted(moved.items(), key=lambda x: -x[1]) if by > 1e-9}
    lines = [f"'{text}': accepts -- {reply.text}", f"  degrees of freedom: {before} -> {after}"]
    lines += [f"  {name} moves by {shown(by)}" for name, by in list(far.items())[:10]]
    if len(far) > 10:
        lines.append(f"  and {len(far) - 10} more")
    return Reply(
        "\n".join(lines),
        remembered=False,
        data={"accepted": True, "before": before, "after": after, "moved": far},
    )


@command(
    "sensitivity",
    group="ask",
    usage=["sensitivity d0", "sensitivity d0 L3"],
    summary="Say how far entities move per unit of a dimension.",
    arguments=("dimension", "entity="),
)
def sensitivity(session: Session, words: Words) -> Reply:
    """How far entities move per unit of a dimension."""
    dimension = dimension_of(session, words)
    entity = words.operand("an entity", "entity") if words else None
    words.end()
    if dimension.derived:
        hint = f"`set_driven {dimension.name}` lets it hold its value"
        message = f"`{dimension.name}` only measures: nothing follows it"
        fail("E1271", message, words.statement.span, "", hint)
    moved = session.editor.judge.sensitivity(dimension.name)
    if entity is not None:
        moved = {entity.entity.name: moved.get(entity.entity.name, 0.0)}
    ranked = {name: by for name, by in sorted(moved.items(), key=lambda x: -x[1]) if by > 1e-12}
    lines = [
        f"{name} moves by {shown(by)} per unit of {dimension.name}" for name, by in ranked.items()
    ]
    return Reply(
        "\n".join(lines) or f"Nothing moves with {dimension.name}",
        remembered=False,
        data={"moved": ranked},
    )


@command(
    "cost",
    group="ask",
    usage=["cost"],
    summary="Show how well the constraints hold: half the sum of squared residuals.",
    arguments=(),
)
def cost(session: Session, words: Words) -> Reply:
    """How well the constraints hold."""
    words.end()
    residuals = session.editor.layout.linearisation().residuals
    value = 0.5 * float(np.dot(residuals, residuals))
    largest = float(np.abs(residuals).max()) if len(residuals) else 0.0
    return Reply(
        f"cost {value:.6g}, largest residual {largest:.3g}, {len(residuals)} equations",
        remembered=False,
        data={"cost": value, "largest": largest, "equations": len(residuals)},
    )


# --- the Jacobian ---------------------------------------------------------------------------


class _System(NamedTuple):
    """Residuals and Jacobian at the present position.

    `owners` names the constraint, dimension or entity of every row, `unknowns` every column.
    """

    jacobian: NDArray[np.float64]
    residuals: NDArray[np.float64]
    owners: list[str]
    unknowns: list[str]


def _linearised(session: Session) -> _System:
    layout: Any = session.editor.layout
    system = layout.linearisation(ranges=False)
    rows, columns = len(system.owners), len(system.x)
    if max(rows, columns) > MAX_DENSE:
        assert session.statement is not None
        message = f"a sketch of {columns:,} unknowns and {rows:,} equations"
        hint = "`dof` and `dof analyze` take any size"
        fail("E1260", message, session.statement.span, f"at most {MAX_DENSE:,} are shown", hint)
    dense = np.zeros((rows, columns))
    row_of = np.repeat(np.arange(rows), np.diff(system.indptr))
    np.add.at(dense, (row_of, system.indices), system.entries)
    names = [layout.name_of(column) for column in range(columns)]
    return _System(dense, np.asarray(system.residuals), list(system.owners), names)


def _eigenvalues(system: _System) -> Reply:
    values = np.linalg.eigvalsh(system.jacobian.T @ system.jacobian)
    found = [float(value) for value in values]
    lines = [f"  {value:.6e}" for value in found[:MAX_SHOWN]]
    head = f"{len(found)} eigenvalues of J'J"
    return Reply("\n".join([head, *lines]), remembered=False, data={"eigenvalues": found})


def _singular(system: _System) -> Reply:
    rows, columns = system.jacobian.shape
    if not columns:
        return Reply("No unknowns", remembered=False, data={"singular": []})
    u, values, vt = np.linalg.svd(system.jacobian if rows else np.zeros((1, columns)))
    lines: list[str] = []
    found = []
    for k in reversed(range(columns)):
        sigma = float(values[k]) if k < len(values) else 0.0
        found.append(sigma)
        if len(lines) >= 2 * MAX_SHOWN:
            continue
        lines.append(f"  {sigma:.6e}  {_combination(vt[k], system.unknowns)}")
        share = u[:, k] ** 2 if k < len(values) and rows and sigma > 0.0 else np.zeros(0)
        lines.append(f"           {_shares(share, system.owners)}")
    head = f"{columns} singular values of J, smallest first"
    return Reply("\n".join([head, *lines]), remembered=False, data={"singular": found})


def _combination(vector: NDArray[np.float64], names: list[str]) -> str:
    """``0.707 A0.start.x - 0.707 A0.end.x``: parts above a third of the largest."""
    largest = float(np.abs(vector).max())
    parts = [
        f"{weight:+.3f} {name}"
        for weight, name in zip(vector.tolist(), names, strict=True)
        if abs(weight) > 0.3 * largest
    ]
    return " ".join(parts)


def _shares(share: NDArray[np.float64], owners: list[str]) -> str:
    total: dict[str, float] = {}
    for part, owner in zip(share.tolist(), owners, strict=False):
        total[owner] = total.get(owner, 0.0) + part
    ranked = sorted(total.items(), key=lambda item: -item[1])
    shown_ = [f"{round(100 * part)}% {name}" for name, part in ranked if part > 0.05]
    return ", ".join(shown_) or "free"


def _jacobian(system: _System) -> Reply:
    lines = []
    for k, row in enumerate(system.jacobian[:MAX_SHOWN]):
        at = np.flatnonzero(row)
        parts = ", ".join(f"{system.unknowns[i]} {row[i]:+.4g}" for i in at)
        norm = math.sqrt(float(row @ row))
        lines.append(
            f"row {k} {system.owners[k]}  r={system.residuals[k]:.3e} |dr|={norm:.4g}  [{parts}]"
        )
    rest = len(system.owners) - MAX_SHOWN
    if rest > 0:
        lines.append(f"and {rest} more")
    data = {"rows": len(system.owners), "columns": len(system.unknowns)}
    return Reply("\n".join(lines) or "No equations", remembered=False, data=data)


_TABLES = {"eigenvalues": _eigenvalues, "singular": _singular, "jacobian": _jacobian}
