"""Checks a parsed model: names, shapes, guards; the result is its typed schema."""
