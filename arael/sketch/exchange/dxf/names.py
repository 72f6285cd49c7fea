"""What marks our own data in a DXF file."""

from __future__ import annotations

APPLICATION = "ARAEL"
"""Name of the application of extended data: the name of each entity."""

RECORD = "ARAEL_SKETCH"
"""Key of the record of the whole sketch, as JSON, in the dictionary of the file."""

OUTLINE, CONSTRUCTION, DIMENSIONS = "OUTLINE", "CONSTRUCTION", "DIMENSIONS"
"""Layers."""

LINETYPES = {"solid": "CONTINUOUS", "dashed": "DASHED", "dashdot": "DASHDOT"}

UNITS = {"in": 1, "mm": 4, "cm": 5, "m": 6}
"""Codes of the header's ``$INSUNITS``."""
