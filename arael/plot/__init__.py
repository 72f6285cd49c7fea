"""Figures of problems and solutions, drawn with matplotlib where it is installed."""
