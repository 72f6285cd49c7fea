"""Free directions: their number, and their names."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.analysis import normal
from arael.analysis.freedom import FreeDirections
from arael.analysis.normal import NormalEquations
from arael.runtime.failures import SolveError
from tests.analysis.maps import cloud, planar


def directions(model) -> FreeDirections:
    return FreeDirections(NormalEquations(model._problem()))


@pytest.fixture(params=[400, 0], ids=["dense", "sparse"])
def both_ways(request, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(normal, "_DENSE", request.param)


@pytest.mark.usefixtures("both_ways")
def test_odometry_alone_leaves_the_map_free(tmp_path) -> None:
    found = directions(planar(tmp_path, fixes=0))
    assert [one.gauge for one in found] == ["translation", "translation", "rotation"]
    assert str(found[0]) == "`poses.t` move together along x"
    assert found.rank == 21
    # The named motion is what it says: every position by the same, every heading by nothing.
    moved = found[0].vector.reshape(8, 3)
    assert moved == pytest.approx(np.tile([1.0, 0, 0], (8, 1)), abs=1e-6)
    turned = found[2].vector.reshape(8, 3)
    assert turned[:, 2] == pytest.approx(np.ones(8), abs=1e-6)


@pytest.mark.usefixtures("both_ways")
def test_no_residual_changes_along_a_free_direction(tmp_path) -> None:
    model = planar(tmp_path, fixes=0)
    j = model.jacobian().dense()
    for one in directions(model):
        assert np.abs(j @ one.vector).max() < 1e-5 * np.abs(j).max()


@pytest.mark.usefixtures("both_ways")
def test_one_fix_leaves_a_turn(tmp_path) -> None:
    found = directions(planar(tmp_path, fixes=1))
    assert [str(one) for one in found] == ["`poses.t` turn together"]


@pytest.mark.usefixtures("both_ways")
def test_two_fixes_leave_nothing(tmp_path) -> None:
    found = directions(planar(tmp_path))
    assert list(found) == []
    assert str(found) == "no free direction: rank 24 of 24"


def test_scale_of_a_cloud(tmp_path) -> None:
    kinds = [one.gauge for one in directions(cloud(tmp_path, distances=False))]
    assert kinds == ["translation"] * 3 + ["scale"]
    kinds = [one.gauge for one in directions(cloud(tmp_path, distances=True))]
    assert kinds == ["translation"] * 3


def test_parameters_that_only_act_together(tmp_path) -> None:
    path = tmp_path / "sum.arael"
    path.write_text(
        "root R { param a: real = 1; param b: real = 2; param c: real = 0; param d: real = 0\n"
        "constraint one { a + 2 * b - 3 }\nconstraint two { c - 1 }\nconstraint no { d * 0 } }\n",
        encoding="utf-8",
    )
    model = arael.load(path, interpret=True)()
    words = [str(one) for one in directions(model)]
    assert words == ["+1 a -0.5 b", "`d` alone"]
    with pytest.raises(SolveError, match="2 of 4 directions are free") as error:
        model.covariance()
    assert error.value.diagnostics[0].notes == tuple(f"free direction: {w}" for w in words)
