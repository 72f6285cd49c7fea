"""The version of arael."""

__version__ = "0.1.0"
