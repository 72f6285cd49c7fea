"""Examine one kept input again: ``python -m tests.fuzz.again MODULE NUMBER FILE``.

MODULE, NUMBER and FILE are on the second line of the ``.txt`` file beside the input.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from tests.fuzz.campaign import FAILURES, Input, Worker


def main(module: str, number: str, file: str) -> int:
    """Print the outcome; return 1 if it is a failure."""
    path = Path(file) if os.path.exists(file) else FAILURES / file
    _, _, name = path.name.split("-", 3)[1:] if path.parent == FAILURES else ("", "", path.name)
    with tempfile.TemporaryDirectory() as folder:
        worker = Worker(module, Path(folder))
        try:
            answer = worker.ask(Input(name, path.read_bytes()), int(number))
        finally:
            worker.close()
    print(answer.get("complaint") or answer["outcome"])
    return int("complaint" in answer)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
