"""A solve as a function of PyTorch tensors, differentiable in reverse mode.

    f = arael.torch.layer(model, data="points.y", of="[v, k]")
    f(y).sum().backward()

Tensors may have axes of a batch in front, the same for all. The solve runs on the host.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import torch

from arael.layers.layer import SolveLayer

__all__ = ["layer"]


def layer(
    model: Any,
    data: str | Iterable[str],
    of: str | Iterable[str],
    *,
    exact: bool = True,
    **settings: Any,
) -> Callable[..., torch.Tensor]:
    """Return a function of as many tensors as there are paths in `data`.

    Parameters and errors are those of `arael.jax.layer`. The result has the type and the device of
    the first tensor, and axes of a batch in front if the tensors have.
    """
    core = SolveLayer(model, data, of, exact=exact, **settings)

    class Solved(torch.autograd.Function):
        """One call of the layer."""

        @staticmethod
        def forward(ctx: Any, *tensors: torch.Tensor) -> torch.Tensor:
            axes, each = core.batch([one.detach().cpu().numpy() for one in tensors])
            ctx.save_for_backward(*tensors)
            found = np.array([core.values(one) for one in each]).reshape(*axes, core.size)
            return torch.as_tensor(found, dtype=tensors[0].dtype, device=tensors[0].device)

        @staticmethod
        @torch.autograd.function.once_differentiable
        def backward(ctx: Any, weights: torch.Tensor) -> tuple[torch.Tensor, ...]:
            tensors = ctx.saved_tensors
            _, each = core.batch([one.detach().cpu().numpy() for one in tensors])
            rows = weights.detach().cpu().numpy().reshape(-1, core.size)
            parts = [core.pullback(one, row) for one, row in zip(each, rows, strict=True)]
            return tuple(
                torch.as_tensor(
                    np.array([part[k] for part in parts]).reshape(one.shape),
                    dtype=one.dtype,
                    device=one.device,
                )
                for k, one in enumerate(tensors)
            )

    def solved(*tensors: torch.Tensor) -> torch.Tensor:
        found: torch.Tensor = Solved.apply(*tensors)
        return found

    solved.__doc__ = f"`{core.of}` of the solution, by {', '.join(core.data)}."
    return solved
