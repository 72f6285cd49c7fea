"""Readers and writers of data files, one module per format."""

from arael.io.formats import FORMATS, format_of, read, write

__all__ = ["FORMATS", "format_of", "read", "write"]
