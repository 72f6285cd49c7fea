"""Units of lengths."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

MILLIMETRES: Mapping[str, float] = MappingProxyType(
    {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
)
"""Millimetres of each unit of a document."""
