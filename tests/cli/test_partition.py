"""`arael solve --partition`, in this process (`--workers 0`)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.cli.conftest import Arael
from tests.distributed.parts.problems import GRID, grid


@pytest.fixture
def field(arael: Arael, line: Path) -> Path:
    """A folder with a model and its data in two formats."""
    (line / "grid.arael").write_text(GRID, encoding="utf-8")
    model = grid(6)
    model.write(line / "grid.npz")
    model.write(line / "grid.json")
    return line


IN_PARTS = ("--partition", "3", "--workers", "0", "--interpret")


def test_a_file_of_columns_is_solved_in_parts(arael: Arael, field: Path) -> None:
    alone = arael("solve", "grid.arael", "grid.npz", "--interpret", "--json").json
    done = arael("solve", "grid.arael", "grid.npz", *IN_PARTS, "-o", "x.npz", "--json")
    assert done.code == 0
    assert done.json["iterations"] == alone["iterations"]
    assert done.json["end_cost"] == pytest.approx(alone["end_cost"], rel=1e-9)
    assert done.json["plan"]["solver"] == "parts"
    with np.load(field / "x.npz") as file:
        assert sorted(file) == ["nodes.h", "nodes.s"]


def test_another_format_is_read_here_and_written_whole(arael: Arael, field: Path) -> None:
    done = arael("solve", "grid.arael", "grid.json", *IN_PARTS, "-o", "out.json")
    assert done.code == 0
    assert "3 parts of" in done.out
    again = arael("solve", "grid.arael", "out.json", "--interpret", "--json").json
    assert again["start_cost"] == pytest.approx(again["end_cost"], rel=1e-6)


def test_a_checkpoint_is_resumed(arael: Arael, field: Path) -> None:
    keep = ("--checkpoint", "state.npz", "--json")
    first = arael("solve", "grid.arael", "grid.npz", *IN_PARTS, *keep, "--max-iters", "3")
    assert first.code == 1
    then = arael("solve", "grid.arael", "grid.npz", *IN_PARTS, *keep, "--resume")
    assert then.code == 0
    assert then.json["start_cost"] == pytest.approx(first.json["end_cost"], rel=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--checkpoint", "x.npz"), "`--checkpoint` needs `--partition`"),
        (("--resume",), "--resume is for many problems"),
        (("--partition", "2", "--resume"), "`--resume` needs `--checkpoint`"),
        (("--partition", "2", "--solver", "dense"), "`--solver` and `--partition` exclude"),
        (("--partition", "2", "--summary"), "`--summary` and `--partition` exclude"),
        (("--partition", "2", "-o", "x.json"), "written as .npz"),
    ],
)
def test_options_that_do_not_go_together_are_refused(
    arael: Arael, field: Path, options: tuple[str, ...], message: str
) -> None:
    done = arael("solve", "grid.arael", "grid.npz", "--interpret", *options)
    assert done.code == 2
    assert message in done.err
