"""Data of instances by instance and in lane order."""

import numpy as np
import pytest

import arael
from arael.runtime.evaluation import instances
from arael.runtime.evaluation.instances import Instances
from arael.solving import problem_of


@pytest.mark.parametrize("n", [0, 1, 8, 21])
@pytest.mark.parametrize("columns", [0, 3])
@pytest.mark.parametrize("ordered", [False, True])
def test_data_from_lanes(n: int, columns: int, ordered: bool) -> None:
    rng = np.random.default_rng(n)
    data = rng.normal(size=(n, columns))
    order = rng.permutation(n) if ordered else None
    instances = Instances(np.arange(n), data.copy(), np.zeros(0))
    for lanes in (4, 8, 4):
        found = instances.in_lanes(lanes, order)
        expected = data if order is None else data[order]
        assert found.shape == (-(-n // lanes), columns, lanes)
        for k in range(len(found) * lanes):
            at = min(k, n - 1)
            np.testing.assert_array_equal(found[k // lanes, :, k % lanes], expected[at])
        np.testing.assert_array_equal(instances.data, data)
    assert instances.in_lanes(4, order) is instances.in_lanes(4, order)


def test_another_order_is_laid_out_anew() -> None:
    data = np.arange(12.0).reshape(12, 1)
    instances = Instances(np.arange(12), data.copy(), np.zeros(0))
    first = instances.in_lanes(4, None).copy()
    back = np.arange(12)[::-1]
    np.testing.assert_array_equal(instances.in_lanes(4, back).ravel(), data[::-1, 0])
    np.testing.assert_array_equal(instances.in_lanes(4, None), first)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_data_gathered_in_parts_is_that_gathered_at_once(
    precision: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = arael.loads(
        """
        struct Sample {
            x: real
            y: real
            constraint fit { (y - root.a * exp(-root.b * x) + 2 * root.k) / root.k }
        }
        root Curve {
            param a: real = 1
            param b: real = 1
            k: real = 3
            samples: list of Sample
        }
        """,
        interpret=True,
        precision=precision,  # type: ignore[arg-type]
    )()
    model.samples.extend(x=np.linspace(0, 2, 23), y=np.linspace(1, 5, 23) ** 2)
    whole = problem_of(model).instances[0]
    monkeypatch.setattr(instances, "_AT_ONCE", 7)
    parts = problem_of(model).instances[0]
    assert whole.data.shape[0] == 23 and whole.data.dtype == parts.data.dtype
    np.testing.assert_array_equal(parts.data, whole.data)
    np.testing.assert_array_equal(parts.uniform, whole.uniform)


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_data_of_the_root_alone_is_that_of_every_instance(precision: str) -> None:
    text = """
        struct Sample {
            param x: real = 1
            constraint fit { (x - root.k * root.k) * exp(root.k) / root.s }
        }
        root Data {
            k: real = 2
            s: real = 4
            samples: list of Sample
        }
        """
    model = arael.loads(text, interpret=True, precision=precision)()  # type: ignore[arg-type]
    model.samples.extend(3)
    expected = 3 * ((1 - 4) * np.exp(2) / 4) ** 2
    assert model.cost() == pytest.approx(expected, rel=1e-6)
    model.k = 1.0
    assert model.cost() == pytest.approx(0, abs=1e-6)
