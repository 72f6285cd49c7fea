"""Measurements: ``python -m benchmarks [suite ...]`` writes a Markdown report."""
