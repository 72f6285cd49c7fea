"""Operations of the constraints of a text, derived apart from typing: it takes up to seconds."""

from __future__ import annotations

from arael.compiler.compilation import compile_text
from arael.diagnostics.records import AraelError, Source
from arael.runtime.layout import Group


def counted(source: Source) -> dict[str, str]:
    """For each constraint, by label: its residuals and operations. Empty if the text has an error.

    Notes
    -----
    Reads imported files from the disk, not those that are open.
    """
    try:
        groups = compile_text(source).program.kernels
    except AraelError:
        return {}
    return {
        kernel.group.label: (
            f"{kernel.group.residuals} residual{'s' * (kernel.group.residuals != 1)}, "
            f"{len(kernel.group.jacobian)} derivatives, {kernel.group.operations_after} operations "
            f"({kernel.group.operations_before} before sharing)" + _for_rows(kernel.group)
        )
        for kernel in groups
    }


def _for_rows(group: Group) -> str:
    """What a row of a list adds that a constraint sums over, term by term."""
    if group.row_sums is None:
        return ""
    terms = sum(piece.tape.operations for _, piece in group.row_sums.sums)
    return f" without rows, and {terms} for each row that it sums over"
