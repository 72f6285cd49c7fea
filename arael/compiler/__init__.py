"""From a typed model to compiled kernels and the layout that the runtime reads."""
