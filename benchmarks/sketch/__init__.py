"""The sketch editor beside ezpz, the Rust framework's editor, SolveSpace and planegcs."""
