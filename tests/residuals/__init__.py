"""Tests of residuals given as text at run time."""
