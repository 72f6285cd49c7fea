"""Solving a sketch after an edit, and dragging it."""
