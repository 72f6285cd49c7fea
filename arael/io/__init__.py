"""Data files in and out, one format a file."""

from arael.io.formats import FORMATS, format_of, read, write

__all__ = ["FORMATS", "format_of", "read", "write"]
