"""Demonstrations: synthetic problems, solved and compared with the truth."""
