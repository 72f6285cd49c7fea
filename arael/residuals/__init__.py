"""Residuals given as text at run time."""
