"""Text of a model file to its tree, and back in the standard layout."""
