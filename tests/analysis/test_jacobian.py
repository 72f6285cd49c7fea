"""The Jacobian by rows, its singular values and vectors, its way back to the model."""

from __future__ import annotations

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from tests.analysis.maps import planar


@pytest.fixture
def model(tmp_path):
    return planar(tmp_path, fixes=1)


def test_singular_vectors_against_numpy(model) -> None:
    found = model.jacobian()
    dense = found.dense()
    u, s, vt = np.linalg.svd(dense, full_matrices=False)
    svd = found.svd()
    np.testing.assert_allclose(svd.s, s, rtol=1e-12, atol=1e-10)
    np.testing.assert_allclose(found.singular_values(), s, rtol=1e-12, atol=1e-10)
    np.testing.assert_allclose(svd.u @ np.diag(svd.s) @ svd.v[:, : len(s)].T, dense, atol=1e-10)
    for k in range(len(s) - 1):  # the last one is 0 here, its vector free in sign
        assert abs(svd.u[:, k] @ u[:, k]) == pytest.approx(1, abs=1e-6)
        assert abs(svd.v[:, k] @ vt[k]) == pytest.approx(1, abs=1e-6)
    assert svd.s[-1] < 1e-9
    assert np.abs(dense @ svd.v[:, -1]).max() < 1e-9
    assert found.rank() == np.linalg.matrix_rank(dense) == 23


def test_more_columns_than_rows(tmp_path) -> None:
    path = tmp_path / "wide.arael"
    path.write_text("root R { param x: vec3 = [1, 2, 3]\nconstraint c { x.x + x.y } }\n")
    found = arael.load(path, interpret=True)().jacobian()
    u, s, v = found.svd()
    assert (u.shape, s.shape, v.shape) == ((1, 1), (1,), (3, 3))
    assert found.dense() @ v[:, 1:] == pytest.approx(np.zeros((1, 2)), abs=1e-12)
    assert v.T @ v == pytest.approx(np.eye(3))
    assert found.rank() == 1


def test_rows_carry_residual_label_constraint_entries(model) -> None:
    found = model.jacobian()
    dense = found.dense()
    assert len(found.rows) == found.shape[0] == 3 * 9 + 2
    for i, row in enumerate(found):
        assert row.residual == found.residuals[i]
        again = np.zeros(found.shape[1])
        for column, value in row.entries:
            again[column] = value
        assert again == pytest.approx(dense[i])
        assert row.is_finite
    assert {row.label for row in found} == {"Edge.between", "Fix.fix"}
    assert found[-1].constraint == 9
    assert found.instance(9) == "Fix.fix[0] at fixes[0]"
    assert found.instance(4) == "Edge.between[4] at edges[4]"
    with pytest.raises(IndexError):
        found.instance(10)


def test_rows_of_one_label(model) -> None:
    found = model.jacobian()
    fixes = found.of("Fix.fix")
    assert fixes.shape == (2, 24)
    assert fixes.dense() == pytest.approx(found.dense()[-2:])
    assert [row.label for row in fixes] == ["Fix.fix"] * 2
    with pytest.raises(KeyError, match=r"there are Edge\.between, Fix\.fix"):
        found.of("fix")


def test_sensitivities_are_lengths_of_columns(model) -> None:
    found = model.jacobian()
    assert found.sensitivities() == pytest.approx(np.linalg.norm(found.dense(), axis=0))


def test_bad_rows(model) -> None:
    # The store takes no NaN from a user; a native function may write one.
    model._store.tables["fixes"].column("t")[0, 0] = np.nan
    bad = model.jacobian().bad_rows()
    assert [(row.label, row.constraint) for row in bad] == [("Fix.fix", 9)]
    assert not bad[0].is_finite


def test_constraint_index_names_the_rows(tmp_path) -> None:
    path = tmp_path / "indexed.arael"
    path.write_text(
        "struct A { x: real; use: bool\nci: constraint_index\n"
        "constraint c when use { root.p - x } }\n"
        "root R { param p: real = 0; items: list of A }\n"
    )
    model = arael.load(path, interpret=True)()
    model.items.extend(x=[1.0, 2.0, 3.0], use=[True, False, True])
    found = model.jacobian()
    assert list(model.items.ci) == [0, -1, 1]
    by_index = {row.constraint: row.residual for row in found}
    assert by_index == {0: -1.0, 1: -3.0}
    assert found.instance(1) == "A.c[2] at items[2]"


def test_single_precision_ranks_and_double_decompositions(tmp_path) -> None:
    model = planar(tmp_path, fixes=1, precision="f32")
    found = model.jacobian()
    assert found.singular_values().dtype == np.float64
    assert found.rank() == 23


@pytest.mark.parametrize("method", ["rank", "svd", "singular_values"])
def test_a_derivative_that_is_not_finite_is_named(tmp_path, method: str) -> None:
    path = tmp_path / "root.arael"
    path.write_text("""
        struct P { param x: real; param y: real
            constraint a { [x, sqrt(y)] } }
        root R { ps: list of P }
    """)
    model = arael.load(path, interpret=True)()
    model.ps.extend(x=[1.0, 2.0, 3.0], y=[1.0, 0.0, 4.0])
    with pytest.raises(AraelError) as failure:
        getattr(model.jacobian(), method)()
    (found,) = failure.value.diagnostics
    assert found.code == "E1002"
    assert "row 3" in found.message
    assert "`P.a[1] at ps[1]`" in found.message
    assert "`ps[1].y` is inf" in found.message
    assert "`bad_rows()` lists this row" in found.help
