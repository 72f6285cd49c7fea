"""Checkpoints: written whole, and only for the problem that they are of."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.distributed import solve

from .problems import PROBLEMS, arrays_of, with_arrays


def interrupted(name: str, path: Path, attempts: int) -> tuple[Any, dict[str, Any]]:
    """Solve a problem and give up after some attempts."""
    model = PROBLEMS[name]()
    arrays = arrays_of(model)
    left = iter(range(attempts - 1))
    solve(
        with_arrays(model, arrays),
        partition=3,
        workers=0,
        checkpoint=path,
        observer=lambda record: next(left, None) is not None,
    )
    return model, arrays


@pytest.mark.parametrize("name", ["grid", "bundle", "fleet"])
def test_a_solve_goes_on_where_it_was(name: str, tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    model, arrays = interrupted(name, path, 3)
    with np.load(path) as file:
        reached = float(file["cost"])
    found = solve(with_arrays(model, arrays), partition=2, workers=0, checkpoint=path, resume=True)
    alone = model.solve(solver="sparse")
    assert found.result.start_cost == pytest.approx(reached, rel=1e-12)
    assert reached < alone.start_cost
    assert found.result.cost == pytest.approx(alone.cost, rel=1e-9)
    assert [p.name for p in tmp_path.iterdir()] == ["state.npz"]


def refused(path: Path, model: Any) -> str:
    with pytest.raises(AraelError) as caught:
        solve(model, partition=2, workers=0, checkpoint=path, resume=True)
    assert caught.value.diagnostics[0].code == "E0897"
    return str(caught.value)


def test_a_checkpoint_of_other_data_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "state.npz"
    model, arrays = interrupted("grid", path, 2)
    arrays["nodes.h"] = arrays["nodes.h"] + 1
    assert "other data" in refused(path, with_arrays(model, arrays))


def test_a_missing_or_damaged_checkpoint_is_refused(tmp_path: Path) -> None:
    assert "no such file" in refused(tmp_path / "none.npz", PROBLEMS["grid"]())
    (tmp_path / "bad.npz").write_bytes(b"PK\x03\x04 nothing")
    assert "damaged" in refused(tmp_path / "bad.npz", PROBLEMS["grid"]())
