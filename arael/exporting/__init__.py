"""Export of models to source code that runs without Python."""

from __future__ import annotations

from arael.exporting.exporter import Export, export

__all__ = ["Export", "export"]
