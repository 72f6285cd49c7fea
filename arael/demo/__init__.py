"""Demonstrations: problems made, solved and judged against the truth."""
