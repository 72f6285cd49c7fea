"""Tests of arael.diagnose."""
