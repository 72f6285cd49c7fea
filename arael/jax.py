"""A solve as a function of JAX arrays, differentiable in reverse mode.

    f = arael.jax.layer(model, data="points.y", of="[v, k]")
    jax.grad(lambda y: f(y)[0])(y)
    jax.vmap(f)(many)

The solve runs on the host (`jax.pure_callback`), so it can be part of what is jitted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import jax
import jax.numpy as jnp

from arael.layers.layer import SolveLayer

__all__ = ["layer"]


def layer(
    model: Any,
    data: str | Iterable[str],
    of: str | Iterable[str],
    *,
    exact: bool = True,
    **settings: Any,
) -> Callable[..., jax.Array]:
    """Return a function of as many arrays as there are paths in `data`.

    Parameters
    ----------
    model : an instance with all its data, from whose values every solve begins
    data : paths of columns (``"points.y"``); an argument has the shape of its column, (rows, ...),
        of the root's data that of one value
    of : a formula over the model, or several: the components of the result, in one vector
    exact : whether derivatives have all terms, or those of Gauss-Newton
    **settings : of `arael.Model.solve`

    Returns
    -------
    A function with a `jax.custom_vjp`, in f64 where JAX has it enabled, else in f32; `jax.vmap`
    solves for each element of a batch.

    Raises
    ------
    AraelError
        E1060, E0828: wrong paths or formulas.
    """
    core = SolveLayer(model, data, of, exact=exact, **settings)

    def dtype() -> Any:
        return jnp.zeros(0).dtype

    def forward_on_host(*arrays: Any) -> Any:
        return core.values(arrays).astype(arrays[0].dtype)

    def backward_on_host(weights: Any, *arrays: Any) -> Any:
        return tuple(one.astype(weights.dtype) for one in core.pullback(arrays, weights))

    @jax.custom_vjp
    def solved(*arrays: Any) -> jax.Array:
        arrays = tuple(jnp.asarray(one, dtype()) for one in arrays)
        shape = jax.ShapeDtypeStruct((core.size,), dtype())
        found: jax.Array = jax.pure_callback(
            forward_on_host, shape, *arrays, vmap_method="sequential"
        )
        return found

    def forward(*arrays: Any) -> tuple[jax.Array, Any]:
        return solved(*arrays), arrays

    def backward(arrays: Any, weights: Any) -> Any:
        kinds = [jnp.asarray(one).dtype for one in arrays]
        arrays = tuple(jnp.asarray(one, dtype()) for one in arrays)
        shapes = tuple(jax.ShapeDtypeStruct(one, dtype()) for one in core.shapes)
        found = jax.pure_callback(
            backward_on_host, shapes, weights, *arrays, vmap_method="sequential"
        )
        return tuple(one.astype(kind) for one, kind in zip(found, kinds, strict=True))

    solved.defvjp(forward, backward)
    solved.__doc__ = f"`{core.of}` of the solution, by {', '.join(core.data)}."
    return solved
