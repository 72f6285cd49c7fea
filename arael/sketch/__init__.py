"""A parametric sketch in the plane: geometry tied by constraints and dimensions."""
