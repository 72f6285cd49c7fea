"""The command language of the sketch editor."""
