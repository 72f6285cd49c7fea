"""A solve as a differentiable function of its data; `arael.jax` and `arael.torch` wrap it."""
