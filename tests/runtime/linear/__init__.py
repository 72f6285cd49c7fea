"""Tests of the linear solvers."""
