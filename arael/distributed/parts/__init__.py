"""One problem in parts: see README.md."""
