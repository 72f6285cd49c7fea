"""The 2D sketch editor: geometry tied by constraints and dimensions."""
