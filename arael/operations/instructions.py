"""The instructions of the expression machine as C; `setup.py` writes them to a header.

python -m arael.operations.instructions HEADER
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path

from arael.operations.record import Operation
from arael.operations.table import OPERATIONS


def instructions(operations: Iterable[Operation]) -> tuple[str, ...]:
    """Names of the operations that have an instruction, in the order of their numbers."""
    return tuple(one.name for one in operations if one.opcode)


def header() -> str:
    """C macro that passes number and expression of each instruction to another macro.

    Operands are A, B and C; ``CALL(sin)`` is the C function of the precision.
    """
    lines = ["/* Written by setup.py from arael/operations/table.py. */"]
    names = instructions(OPERATIONS.values())
    lines.append(f"#define ARAEL_INSTRUCTION_COUNT {len(names)}")
    lines.append("#define ARAEL_INSTRUCTIONS(EACH) \\")
    for number, name in enumerate(names):
        lines.append(f"    EACH({number}, {_expression(OPERATIONS[name])}) \\")
    lines[-1] = lines[-1].removesuffix(" \\")
    return "\n".join(lines) + "\n"


def _expression(one: Operation) -> str:
    called = re.sub(r"^\w+", lambda found: f"CALL({found[0]})", one.c_expression)
    return (one.machine or (called if one.library else one.c)).format("A", "B", "C")


if __name__ == "__main__":
    target, text = Path(sys.argv[1]), header()
    if not target.exists() or target.read_text(encoding="utf-8") != text:
        target.write_text(text, encoding="utf-8")
