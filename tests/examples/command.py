"""Solving a problem of an example by the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from arael.cli.main import run


def solved_by_command(
    model: Path, data: Path, capsys: pytest.CaptureFixture[str], *options: str
) -> float:
    """Cost that ``arael solve MODEL DATA`` reports; it must converge."""
    capsys.readouterr()
    code = run(["solve", str(model), str(data), "--json", *options])
    captured = capsys.readouterr()
    assert code == 0, captured.err
    return float(json.loads(captured.out)["end_cost"])
