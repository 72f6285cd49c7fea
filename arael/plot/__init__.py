"""Figures of problems and solutions, drawn with matplotlib."""
