"""The process in which inputs are examined: a crash, a hang or a leak ends it, not the test.

``python -m tests.fuzz.worker MODULE FOLDER``; each line of standard input is a case as JSON, and is
answered by one line of JSON.
"""

from __future__ import annotations

import base64
import faulthandler
import importlib
import json
import os
import random
import re
import resource
import signal
import sys
import traceback
import warnings
from pathlib import Path
from typing import Any

from arael.diagnostics.records import AraelError
from tests.fuzz.verdict import unusable

SECONDS = 10
"""Processor time that one input may take."""
MEMORY = int(os.environ.get("ARAEL_FUZZ_MEMORY", 1 << 30))
"""Bytes of address space that the inputs of a process may take, beyond what imports took."""


def main(module: str, folder: str) -> None:
    """Answer cases until standard input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="ascii")
    os.dup2(2, 1)  # what arael prints must not get among the answers
    faulthandler.enable()
    faulthandler.register(signal.SIGPROF, chain=True)  # where the time went; then the process ends
    warnings.simplefilter("ignore")
    os.fsync = lambda fd: (
        None
    )  # inputs need not survive a power cut, and the disk would set the pace
    examiner = importlib.import_module(f"tests.fuzz.{module}")
    os.chdir(folder)
    if hasattr(examiner, "warm_up"):
        examiner.warm_up(Path(folder))
    limit = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() + MEMORY
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    print(json.dumps({"ready": True}), file=answers, flush=True)
    for line in sys.stdin:
        case = json.loads(line)
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        answer = examined(examiner, case, Path(folder))
        signal.setitimer(signal.ITIMER_PROF, 0)
        print(json.dumps(answer), file=answers, flush=True)


def examined(examiner: Any, case: dict[str, Any], folder: Path) -> dict[str, Any]:
    """What became of one input: ``outcome``, and ``complaint`` with its ``signature`` if any."""
    content = base64.b64decode(case["content"])
    try:
        outcome = examiner.examine(content, case["name"], random.Random(case["seed"]), folder)
    except AraelError as error:
        complaint = unusable(error)
        code = error.diagnostics[0].code if error.diagnostics else ""
        if complaint:
            return {
                "outcome": "failed",
                "complaint": complaint,
                "signature": f"{code} {complaint}"[:60],
            }
        return {"outcome": f"refused {code}"}
    except BaseException as error:
        frames = traceback.extract_tb(error.__traceback__)
        place = next((f for f in reversed(frames) if "/arael/" in f.filename), frames[-1])
        where = f"{Path(place.filename).name}:{place.name}"
        kind = type(error).__name__
        signature = f"{kind} {where}" + (
            f" {error}"[:40] if isinstance(error, AssertionError) else ""
        )
        text = "".join(traceback.format_exception(error, limit=-12))
        return {
            "outcome": "failed",
            "complaint": text,
            "signature": re.sub(r"[\d.e+-]+", "#", signature),
        }
    return {"outcome": outcome}


if __name__ == "__main__":
    main(*sys.argv[1:])
