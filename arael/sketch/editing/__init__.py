"""Edits of a sketch: each validated, solved, judged, and one step of undo."""
