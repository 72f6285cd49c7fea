"""Expressions of dimensions and parameters: reading, values, dependencies, renaming."""
