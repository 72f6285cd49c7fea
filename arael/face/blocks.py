"""Python interface of blocks of the Hessian."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest
from arael.runtime.layout import Block
from arael.runtime.problem import Problem
from arael.runtime.store import Store

if TYPE_CHECKING:
    from arael.analysis.hessian_blocks import HessianBlocks
    from arael.face.fields import Fields


def read_block(fields: Fields, block: Block) -> Any:
    """A named block at the rows of `fields`: (k, l) of one row, (n, k, l) of many."""
    found = _linearised(fields._table.store)
    if block.kind == "triplets":
        return found.triplets(block.name)
    rows = fields._rows()
    every = np.atleast_1d(np.arange(fields._table.size)[rows])
    values = found.named(block, every)
    return values[0] if isinstance(rows, int) else values


def block_at(store: Store, path: str, row: int | None) -> Any:
    """The named block at `path` (``poses.hb_pose``), of one row of its table or of all."""
    known = {f"{b.table}.{b.prefix}{b.name}".lstrip("."): b for b in store.layout.blocks}
    block = known.get(path)
    if block is None:
        near = closest(path, known)
        raise AraelError(
            Diagnostic(
                "E0701",
                f"the model names no block `{path}`",
                origin="hessian_block",
                help=(
                    f"did you mean `{near[0]}`?"
                    if near
                    else "name it in the model, `hb: block T`, or pass two rows: "
                    "`hessian_block(a, b)`",
                ),
            )
        )
    found = _linearised(store)
    if block.kind == "triplets":
        return found.triplets(block.name)
    size = store.tables[block.table].size
    if row is None and block.table:
        return found.named(block, np.arange(size))
    if row is not None and not isinstance(row, int | np.integer):
        raise wrong_argument("hessian_block", "b", "the number of a row", row)
    number = 0 if row is None else int(row)
    if not -size <= number < size:
        raise IndexError(f"row {number} of `{block.table}`, which has {size}")
    return found.named(block, np.array([number % size]))[0]


def block_between(store: Store, a: Any, b: Any) -> Any:
    """The block of two rows: refs, or the model for its root."""
    return _linearised(store).of_rows(_row(store, a), _row(store, b))


def _row(store: Store, where: Any) -> tuple[str, int]:
    table = getattr(where, "_table", None)
    rows = where._rows() if table is not None else None
    if table is None or not isinstance(rows, int) or table.store is not store:
        raise wrong_argument(
            "hessian_block",
            "a or b",
            "a row of this model, the model itself, or the path of a named block",
            where,
            "write `model.poses[3]`",
        )
    return table.layout.path, rows


def _linearised(store: Store) -> HessianBlocks:
    # imported here: start-up time, since most programs never read the Hessian
    from arael.analysis.hessian_blocks import HessianBlocks

    store.check_complete()
    if store.residuals is None:
        return HessianBlocks(Problem(store.layout, store, store.kernels, bindings=store.bindings))
    posed = store.residuals.posed()
    return HessianBlocks(
        Problem(
            posed.layout,
            posed,
            store.kernels,
            programs=posed.programs,
            bindings={**store.bindings, **posed.bindings},
        )
    )
