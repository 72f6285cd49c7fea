"""A solve as a differentiable function of its data; `arael.jax` wraps it."""
