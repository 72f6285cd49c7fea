"""Tests of arael.analysis."""
