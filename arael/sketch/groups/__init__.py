"""Geometry made together: copies by mirror and pattern, offsets, slots and polygons."""
