"""Half-bandwidth of a block pattern, and the check of a declared one."""

from __future__ import annotations

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.planning import reach_of


def half_bandwidth(
    pattern: BlockPattern, scalars: int | None = None, blocks: int | None = None
) -> int:
    """Largest distance of an entry below the diagonal, in scalars.

    Parameters
    ----------
    pattern : BlockPattern
    scalars : int, optional
        Declared half-bandwidth in scalars.
    blocks : int, optional
        Declared half-bandwidth in block rows.

    Returns
    -------
    int
        `scalars` if declared, else that of the pattern.

    Raises
    ------
    AraelError
        E1020, naming the first pair of entities outside the declared band; E0842 if the declared
        width is negative.
    """
    for option, width in (("half_bandwidth", scalars), ("block_half_bandwidth", blocks)):
        if width is not None and width < 0:
            raise AraelError(
                Diagnostic(
                    "E0842",
                    f"{option} must not be negative, found {width}",
                    origin="solver options",
                )
            )
    if scalars is None and blocks is None:
        return reach_of(pattern)
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    offsets = pattern.offsets
    reach = offsets[pattern.rows + 1] - 1 - offsets[columns]
    if scalars is not None and (reach > scalars).any():
        where = int(np.argmax(reach > scalars))
        _off_band(pattern, where, columns, f"{scalars} scalars", f"half_bandwidth={reach.max()}")
    apart = pattern.rows - columns
    if blocks is not None and (apart > blocks).any():
        where = int(np.argmax(apart > blocks))
        found = f"block_half_bandwidth={apart.max()}"
        _off_band(pattern, where, columns, f"{blocks} entities", found)
    if scalars is not None:
        return scalars
    return int(reach.max(initial=0))


def band_flops(n: int, kd: int) -> float:
    """Additions and multiplications of a banded Cholesky factorisation with truncated end."""
    kd = min(kd, max(n - 1, 0))
    return float(n - kd) * (kd + 1) ** 2 + kd * (kd + 1) * (2 * kd + 1) / 6


def _off_band(
    pattern: BlockPattern, block: int, columns: np.ndarray, declared: str, enough: str
) -> None:
    offsets = pattern.offsets
    lower = pattern.name_of(int(offsets[pattern.rows[block]]))
    upper = pattern.name_of(int(offsets[columns[block]]))
    apart = int(pattern.rows[block] - columns[block])
    raise AraelError(
        Diagnostic(
            "E1020",
            f"{lower} and {upper} are coupled {apart} entities apart, "
            f"outside the declared band of {declared}",
            origin="solver band",
            help=(
                f"declare {enough}, which includes every coupling",
                "or use the solver 'sparse' or 'auto', which accept any pattern",
            ),
        )
    )
