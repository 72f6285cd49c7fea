"""Curve fitting: a formula and a table of points; see README.md."""
