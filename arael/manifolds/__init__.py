"""The mathematics of parameters on graphs: matrices, rotations, transforms, directions."""
