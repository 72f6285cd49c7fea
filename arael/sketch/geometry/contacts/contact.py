"""The record of a meeting of two curves."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

from arael.sketch.geometry.vectors import Point

Kind: TypeAlias = Literal["crossing", "tangent", "overlap"]


class Contact(NamedTuple):
    """A point common to two curves, its parameters on both, and how they meet there.

    ``tangent``: the directions agree, and the curves part again by less than the tolerance.
    ``overlap``: one end of a stretch that both share; the other end is the next contact.
    """

    point: Point
    t: float
    u: float
    kind: Kind


class Candidate(NamedTuple):
    """Parameters where two carriers may meet; `tangent` is known for some pairs of kinds."""

    t: float
    u: float
    tangent: bool = False
