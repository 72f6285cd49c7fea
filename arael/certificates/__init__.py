"""Certificates of the global optimum, for costs that are quadratic in rotations and positions."""
