"""Cost tables, Jacobians, covariances and free directions of hand-built layouts."""

from __future__ import annotations

import numpy as np
import pytest

from arael.analysis.cost_table import cost_table
from arael.analysis.covariance import covariance
from arael.analysis.jacobian import jacobian
from arael.diagnostics.records import AraelError
from arael.runtime.failures import SolveError
from arael.runtime.store import Store
from arael.solving import cost, problem_of, solve
from tests.runtime import toy, toys
from tests.test_solving import chain, code_of, line, model_of


def test_cost_table_lists_every_constraint():
    model = chain()
    table = cost_table(problem_of(model))
    assert list(table) == ["Pairs.odometry", "Poses.drift"]
    assert table["Poses.drift"] == 0 and table.instances == {
        "Pairs.odometry": 12,
        "Poses.drift": 12,
    }
    assert table.total == pytest.approx(cost(model), rel=1e-12)
    empty = toys.chain()
    assert cost_table(problem_of(model_of(empty, Store(empty)))) == {
        "Pairs.odometry": 0,
        "Poses.drift": 0,
    }
    assert str(table).splitlines()[0].split() == ["constraint", "cost", "instances", "rms"]
    assert table.rms("Pairs.odometry") == pytest.approx(
        (table["Pairs.odometry"] / table.residuals["Pairs.odometry"]) ** 0.5
    )


def test_jacobian_counts_degrees_of_freedom():
    layout = toys.chain()
    layout = toy.layout(layout.tables, layout.entities, layout.groups[:1])
    found = jacobian(problem_of(model_of(layout, toys.chain_store(layout))))
    s = found.singular_values()
    assert found.shape == (36, 36)
    assert (s[:-3] > 1e-3).all() and (s[-3:] < 1e-12).all()
    u, s, v = found.svd()
    np.testing.assert_allclose((u * s) @ v.T, found.dense(), atol=1e-12)
    # The free directions move all poses alike.
    assert np.abs(found.dense() @ v[:, -3:]).max() < 1e-12
    row = found[4]
    assert (row.label, row.constraint) == ("Pairs.odometry", 1)
    assert [c for c, _ in row.entries] == sorted(c for c, _ in row.entries)
    assert found.names[3] == "poses[1].pos.x"
    with pytest.raises(IndexError):
        found[36]


def test_covariance_of_a_line_is_the_textbook_one():
    model = line()
    solve(model)
    x = np.asarray(model._store.tables["data"].column("x"))
    design = np.stack([x, np.ones_like(x)], axis=1)
    expected = np.linalg.inv(design.T @ design)
    found = covariance(problem_of(model))
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-9)
    np.testing.assert_allclose(found.marginal("a"), expected[:1, :1], rtol=1e-9)
    np.testing.assert_allclose(found.cross("a", "b"), expected[:1, 1:], rtol=1e-9)
    np.testing.assert_allclose(found.marginal(("", 0)), expected, rtol=1e-9)


def test_relative_covariance_is_that_of_the_difference():
    model = chain()
    solve(model)
    found = covariance(problem_of(model))
    a, b = ("poses", 2), ("poses", 7)
    select = np.zeros((3, 36))
    select[:, 6:9], select[:, 21:24] = np.eye(3), -np.eye(3)
    expected = select @ found.matrix @ select.T
    np.testing.assert_allclose(found.relative(a, b), expected, rtol=1e-9)
    np.testing.assert_allclose(
        found.relative("poses[2].pos", "poses[7].pos"), expected[:2, :2], rtol=1e-9
    )


def test_singular_system_names_free_directions():
    layout = toys.chain()
    layout = toy.layout(layout.tables, layout.entities, layout.groups[:1])
    with pytest.raises(SolveError) as caught:
        covariance(problem_of(model_of(layout, toys.chain_store(layout))))
    error = caught.value.diagnostics[0]
    assert error.code == "E1008"
    assert error.message == "the system is singular: 3 of 36 directions are free"
    assert error.notes == (
        "free direction: `poses.pos` move together along x",
        "free direction: `poses.pos` move together along y",
        "free direction: `poses.pos` turn together",
    )


def test_covariance_of_what_is_fixed_is_refused():
    model = chain()
    poses = model._store.tables["poses"]
    poses.fixed("pos")[0] = poses.fixed("heading")[0] = True
    found = covariance(problem_of(model))
    assert found.matrix.shape == (33, 33)
    with pytest.raises(AraelError, match=r"`poses\[0\]` is not solved for") as caught:
        found.marginal(("poses", 0))
    assert code_of(caught) == "E1009"
