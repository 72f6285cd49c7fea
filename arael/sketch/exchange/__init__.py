"""Sketches to and from files of other programs: DXF, SVG, STEP, PDF, PNG."""

from arael.sketch.exchange.files import read, write
from arael.sketch.exchange.imported import Imported, Suggestion
from arael.sketch.exchange.recognition import recognised

__all__ = ["Imported", "Suggestion", "read", "recognised", "write"]
