"""Printing of kernels as Cython source."""
