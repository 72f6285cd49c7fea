"""A vector times a product of matrices is applied factor by factor where that is shorter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arael.compiler import compiler
from arael.compiler.groups import Kernel
from arael.diagnostics.records import Findings, Source
from arael.loading import load
from arael.runtime.problem import Problem
from arael.syntax.parser import parse

TEXT = """
struct D {{ m: mat3; k: mat3; v: vec3 }}
root R {{ param a: vec3; param b: vec3; data: list of D
    fit data as e {{
        let A = rotation_matrix(root.a)
        let B = rotation_matrix(root.b)
        {body}
    }}
}}
"""


def kernel(body: str) -> Kernel:
    source = Source("model.arael", TEXT.format(body=body))
    model = compiler.types(parse(source), Findings())
    (found,) = compiler.derive(model, "model.arael").kernels
    return found


def operations(body: str) -> int:
    return kernel(body).group.tape.operations


@pytest.mark.sweep(4)
@pytest.mark.parametrize(
    ("written", "by_factors"),
    [
        ("A * B * e.v", "A * (B * e.v)"),
        ("(A * B)' * e.v", "B' * (A' * e.v)"),
        ("e.v * (A * B)", "B' * (A' * e.v)"),
        ("A * e.m * B * e.v", "A * (e.m * (B * e.v))"),
    ],
)
def test_few_vectors_are_turned_factor_by_factor(written: str, by_factors: str) -> None:
    assert operations(written) <= operations(by_factors)
    product = written.replace("A * B", "P").replace("A * e.m * B", "P")
    if "P" in product:
        assert operations(written) < operations("let P = (A * B).*1\n" + product)


@pytest.mark.slow
def test_a_product_for_many_vectors_is_formed() -> None:
    """Five vectors: factor by factor would take more."""
    terms = " + ".join(f"sin(P * (e.v * root.a[0] ^ {k}))" for k in range(2, 7))
    formed = f"let P = A * B .* 1\n{terms}"
    assert operations(f"let P = A * B\n{terms}") <= operations(formed)


def test_a_product_of_data_is_formed_once_per_solve() -> None:
    """``m k`` depends on data alone: its product is an input, whatever it is applied to."""
    found = kernel("(e.m * e.k) * root.a")
    assert found.group.data_count == 9
    assert found.group.tape.operations == 15


def test_values_agree(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    a, b, v = rng.normal(size=(3, 3))
    values = []
    for name, body in (("chain", "A * B * e.v"), ("formed", "let P = A * B .* 1\nP * e.v")):
        path = tmp_path / f"{name}.arael"
        path.write_text(TEXT.format(body=body))
        model = load(path, interpret=True)(a=a, b=b)
        model.data.append(v=v, m=np.eye(3), k=np.eye(3))
        values.append(Problem(model.layout, model._store).evaluation.group_rows(0)[0])
    np.testing.assert_allclose(values[0], values[1], rtol=0, atol=4e-16)
