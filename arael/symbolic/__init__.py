"""The symbolic engine: scalar graphs, their derivatives, and the mathematics built on them."""
