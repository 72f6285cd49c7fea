"""Where two curves meet: crossings, tangent contacts, overlaps."""

from arael.sketch.geometry.contacts.contact import Contact
from arael.sketch.geometry.contacts.intersections import intersections

__all__ = ["Contact", "intersections"]
