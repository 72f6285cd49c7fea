"""What runs while a problem is solved: tables, kernels, the normal equations, the solvers."""
