"""The symbolic engine: scalar graphs, their derivatives, and the language's functions."""
