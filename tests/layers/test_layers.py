"""Solves as differentiable functions, by JAX and by PyTorch: gradients checked, batches, jit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.layers.layer import SolveLayer
from tests.interpreted import loader
from tests.optional import is_installed, needs

TEXT = """
struct Point { x: real
    y: real
    constraint fit { (root.v * x / (root.k + x) + root.bias - y) / 0.1 } }
root Rate { param v: real = 3
    param k: real = 2
    bias: real = 0
    points: list of Point }
"""
X = np.array([0.5, 1.0, 2.0, 3.0, 5.0])
Y = np.array([0.97, 1.58, 2.36, 2.98, 3.52])


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Any:
    found = loader(tmp_path_factory.mktemp("layers"))(TEXT)()
    found.points.extend(x=X, y=Y)
    return found


def test_values_and_their_derivatives_are_those_of_solves(model: Any) -> None:
    core = SolveLayer(model, ["points.y", "bias"], ["v / k", "v"])
    values = core.values([Y, 0.1])
    again = model.copy()
    again.bias = 0.1
    again.solve()
    expected = [float(again.v.value / again.k.value), float(again.v.value)]
    assert values == pytest.approx(expected, rel=1e-9)
    assert model.bias == 0 and float(model.v.value) == 3  # it stays as it is
    by_y, by_bias = core.pullback([Y, 0.1], [1.0, 0.5])
    h = 1e-5
    weigh = np.array([1.0, 0.5])
    for k in (0, 4):
        up, down = (Y + s * h * (np.arange(5) == k) for s in (1, -1))
        change = weigh @ (core.values([up, 0.1]) - core.values([down, 0.1])) / (2 * h)
        assert by_y[k] == pytest.approx(change, rel=1e-5)
    change = weigh @ (core.values([Y, 0.1 + h]) - core.values([Y, 0.1 - h])) / (2 * h)
    assert by_bias == pytest.approx(change, rel=1e-5)


@pytest.mark.parametrize(
    ("data", "of", "message"),
    [
        ("points.z", "v", "E1060.*points.z"),
        ([], "v", "E0828.*paths of columns"),
        ("points.y", 3, "E0828.*a formula"),
        ("points.y", "points.y", "E0[0-9]{3}|E1060"),
    ],
)
def test_wrong_layers(model: Any, data: Any, of: Any, message: str) -> None:
    with pytest.raises(AraelError, match=message):
        SolveLayer(model, data, of)


def test_wrong_shapes(model: Any) -> None:
    core = SolveLayer(model, "points.y", "v")
    with pytest.raises(AraelError, match=r"E1060.*\(4,\).*(.|\n)*points.y \(5,\)"):
        core.values([Y[:4]])
    with pytest.raises(AraelError, match="E1060"):
        SolveLayer(model, ["points.y", "bias"], "v").batch([Y[None], 0.0])


@pytest.mark.parametrize("part", [pytest.param("JAX", marks=needs("JAX"))])
def test_jax(model: Any, part: str) -> None:
    import jax
    import jax.numpy as jnp
    from jax.test_util import check_grads

    import arael.jax

    del part
    with jax.enable_x64(True):
        f = arael.jax.layer(model, ["points.y", "points.x"], "[v, k]")
        y, x = jnp.asarray(Y), jnp.asarray(X)
        assert f(y, x).shape == (2,)
        check_grads(f, (y, x), order=1, modes=["rev"], atol=1e-5, rtol=1e-5)
        core = SolveLayer(model, ["points.y", "points.x"], "[v, k]")
        slope = jax.jit(jax.grad(lambda y: f(y, x)[1]))(y)
        assert np.asarray(slope) == pytest.approx(core.pullback([Y, X], [0, 1])[0], rel=1e-12)
        many = jnp.stack([y, y + 0.1, 2 * y])
        each = jax.vmap(lambda y: jax.jacrev(f)(y, x))(many)
        assert each.shape == (3, 2, 5)
        assert np.asarray(each[1]) == pytest.approx(np.asarray(jax.jacrev(f)(y + 0.1, x)), rel=1e-9)


if is_installed("PyTorch"):  # not in CI: its wheels bring three gigabytes of CUDA

    def test_torch(model: Any) -> None:
        import torch

        import arael.torch

        f = arael.torch.layer(model, ["points.y", "bias"], "[v, k]")
        y = torch.tensor(Y, requires_grad=True)
        bias = torch.tensor(0.1, dtype=torch.float64, requires_grad=True)
        assert torch.autograd.gradcheck(f, (y, bias), eps=1e-3, atol=1e-5, rtol=1e-5)
        many = torch.stack([y.detach(), y.detach() + 0.1]).requires_grad_()
        f(many, torch.zeros(2, dtype=torch.float64))[:, 1].sum().backward()
        core = SolveLayer(model, ["points.y", "bias"], "[v, k]")
        for k in range(2):
            expected = core.pullback([Y + 0.1 * k, 0.0], [0, 1])[0]
            assert many.grad is not None
            assert many.grad[k].numpy() == pytest.approx(expected, rel=1e-9)
        single = torch.tensor(Y, dtype=torch.float32)
        assert f(single, torch.tensor(0.0)).dtype == torch.float32
