"""Values of formulas over rotations and positions: products of rotations, sums of moved points.

A formula is evaluated on whole columns of data, with the parameters as letters. A rotation is a
word of letters, each a parameter or data, inverted or not; a point is a sum of words applied to
positions and to data. Errors of rotations and points, weighted by data, are what residuals are.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Unreadable(Exception):
    """A formula that is not quadratic in rotations and positions; its text says what it has."""


@dataclass(frozen=True)
class Atom:
    """A parameter: a rotation, or a position, reached through a slot."""

    slot: int
    column: str
    part: str  # "R" or "t"


@dataclass(frozen=True, eq=False)
class Letter:
    """A rotation: of a parameter, or data (n, d, d)."""

    atom: Atom | None
    data: Floats | None = None
    inverse: bool = False

    @property
    def inverted(self) -> Letter:
        """Its inverse; of data the transpose."""
        if self.data is not None:
            return Letter(None, self.data.transpose(0, 2, 1))
        return Letter(self.atom, None, not self.inverse)


Word = tuple[Letter, ...]


def joined(*words: Word) -> Word:
    """The product of words: data beside data is multiplied, a letter beside its inverse cancels."""
    found: list[Letter] = []
    for letter in (one for word in words for one in word):
        last = found[-1] if found else None
        if last is not None and last.data is not None and letter.data is not None:
            found[-1] = Letter(None, last.data @ letter.data)
        elif (
            last is not None
            and letter.atom is not None
            and last.atom == letter.atom
            and last.inverse != letter.inverse
        ):
            found.pop()
        else:
            found.append(letter)
    # What cancelled may leave data beside data.
    again = tuple(found)
    if any(a.data is not None and b.data is not None for a, b in pairwise(again)):
        return joined(again)
    return again


def inverse(word: Word) -> Word:
    """The inverse of a product."""
    return tuple(letter.inverted for letter in reversed(word))


def is_linear(word: Word) -> bool:
    """Whether it has one parameter at most, and that not inverted."""
    moving = [letter for letter in word if letter.atom is not None]
    return len(moving) < 2 and not any(letter.inverse for letter in moving)


def has_left(word: Word) -> bool:
    """Whether data stands before a parameter."""
    return len(word) > 1 and word[0].data is not None


@dataclass(frozen=True, eq=False)
class Rotation:
    """A product of rotations."""

    word: Word


@dataclass(frozen=True, eq=False)
class Term:
    """A word applied to a position, or to data (n, d), with a sign."""

    sign: float
    word: Word
    atom: Atom | None
    data: Floats | None = None


@dataclass(frozen=True, eq=False)
class Point:
    """A sum of terms, a vector of `size` scalars."""

    terms: tuple[Term, ...]
    size: int

    def moved(self, word: Word) -> Point:
        """Rotated."""
        terms = (Term(t.sign, joined(word, t.word), t.atom, t.data) for t in self.terms)
        return Point(tuple(terms), self.size)

    def plus(self, other: Point, sign: float) -> Point:
        """A sum or a difference."""
        more = (Term(sign * t.sign, t.word, t.atom, t.data) for t in other.terms)
        return Point((*self.terms, *more), self.size)


@dataclass(frozen=True, eq=False)
class Rigid:
    """A rotation, and a position after it."""

    rotation: Word
    position: Point

    def times(self, other: Rigid) -> Rigid:
        """A product."""
        moved = other.position.moved(self.rotation)
        return Rigid(joined(self.rotation, other.rotation), moved.plus(self.position, 1.0))

    def inverted(self) -> Rigid:
        """The inverse."""
        back = inverse(self.rotation)
        nothing = Point((), self.position.size)
        return Rigid(back, nothing.plus(self.position.moved(back), -1.0))


@dataclass(frozen=True, eq=False)
class Error:
    """How far a rotation is from none: a vector of length ``2 sin(angle / 2)``, or of the angle.

    Attributes
    ----------
    chordal : whether of the first length, whose square is half that of ``W - I``
    size : number of its scalars: 3, or 1 in the plane
    """

    word: Word
    chordal: bool
    size: int


@dataclass(frozen=True, eq=False)
class Weighted:
    """Errors multiplied by data: the sum of ``weights[k] @ errors[k]``, each (n, m, size)."""

    errors: tuple[Point | Error, ...]
    weights: tuple[Floats, ...]

    @classmethod
    def of(cls, error: Point | Error, n: int) -> Weighted:
        """An error itself."""
        return cls((error,), (np.broadcast_to(np.eye(error.size), (n, error.size, error.size)),))

    @property
    def rows(self) -> int:
        """Number of scalars."""
        return int(self.weights[0].shape[1])

    def times(self, matrix: Floats) -> Weighted:
        """Multiplied by (n, k, m) from the left."""
        return Weighted(self.errors, tuple(matrix @ one for one in self.weights))

    def plus(self, other: Weighted, sign: float) -> Weighted:
        """A sum or a difference; equal errors are one."""
        errors, weights = list(self.errors), list(self.weights)
        for error, weight in zip(other.errors, other.weights, strict=True):
            if error in errors:
                k = errors.index(error)
                weights[k] = weights[k] + sign * weight
            else:
                errors.append(error)
                weights.append(sign * weight)
        return Weighted(tuple(errors), tuple(weights))
