"""What a layout holds."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.document import Document
from arael.sketch.document.kinds import ENTITIES
from arael.sketch.document.records import Entity
from arael.sketch.layout import model
from arael.sketch.layout.columns import Columns
from arael.sketch.layout.laid import Laid
from arael.sketch.layout.linearisation import Numbering
from arael.sketch.layout.places import Places


class State:
    """Rows, unknowns and bookkeeping of a layout; see `Layout` for its attributes."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.rows, self.guards = model.rows(), model.rows()
        self.x = np.zeros(0)
        self.low, self.high = np.zeros(0), np.zeros(0)
        self.places = Places()
        self.owner: list[str] = []
        self._is_equation = np.zeros(0, dtype=bool)  # by row: not empty, nor a quantity's
        self.guard_owner: list[str] = []
        self.version = 0
        self._drawn = 0  # counts the entities that came and went
        # Changes of the document's numbers, and version, for which `x` and the size are known.
        self._gathered = (-1, -1)
        self._sized = (-1, -1, 1.0)
        self._columns = Columns()
        self._laid: dict[str, Laid] = {}
        self._users: dict[str, dict[str, None]] = {}
        self._on: dict[str, dict[str, int]] = {}
        self._pending: dict[tuple[str, str], None] = {}
        # By offset in the document's values:
        self._column = np.zeros(0, dtype=np.int64)  # its own column, -1 where nothing is
        self._root = np.zeros(0, dtype=np.int64)  # the column it is read from
        self._use = np.zeros(0, dtype=np.int64)  # what rows use: the same, or a constant
        self._axis = np.zeros(0, dtype=np.int8)  # what it is, see `axes`
        self._first = np.zeros(0, dtype=np.int64)  # offset of its entity's first number
        self._entity_at: list[str] = []
        # By column:
        self._source = np.zeros(0, dtype=np.int64)  # offset that gives its number, -1 without
        # What is fixed:
        self._holds: dict[int, dict[str, tuple[float, ...] | None]] = {}
        self._constants: dict[int, int] = {}  # offset of the constant by root column
        self._unused: list[int] = []  # constants that no row will use when all are laid out
        # Why a record cannot hold; by record and the point where it is held, -1 for its plan.
        self._impossible: dict[tuple[str, int], str] = {}
        self._seen = np.zeros(0)
        self._live = np.zeros(0, dtype=np.int64)
        self._with_hidden: dict[str, None] = {}
        self._unguarded: dict[str, None] = {}  # entities with a radius that was not above 0
        self._amid_changes: dict[str, None] = {}  # records laid out in a transaction that is open
        self._with_turning: dict[str, None] = {}  # whose guards follow their values
        # Dimensions that follow geometry, by the parameters and dimensions they read.
        self._readers: dict[str, dict[str, None]] = {}
        self._stale: set[str] = set()  # those that have to be laid out anew
        self._changes: dict[tuple[str, int], tuple[float, float]] = {}
        self._numbering: Numbering | None = None
        self._components: tuple[int, NDArray[np.int32]] | None = None
        # Records that changed since all equations held last, entities that moved; None: not known.
        self._touched: dict[str, None] | None = None
        # Offsets of the x of all points, and of other lengths, of a version.
        self._extent: tuple[int, NDArray[np.int64], NDArray[np.int64]] | None = None
        # Pieces on which points are, of splines with several; where those are that are at an end.
        self._pieces: dict[str, int] = {}
        self._at_knots: dict[str, int] = {}
        self._turning: tuple[int, NDArray[np.int64]] | None = None
        self._slacks: tuple[int, NDArray[np.int64]] | None = None
        self._angles: tuple[int, NDArray[np.int64], list[tuple[int, int]]] | None = None

    def _grow(self) -> None:
        """More columns where they do not suffice, with some to spare."""
        if self._columns.count <= len(self.x):
            return
        old, count = len(self.x), max(64, self._columns.count + self._columns.count // 2)
        self.x = np.concatenate([self.x, np.zeros(count - old)])
        self.low = np.concatenate([self.low, np.full(count - old, -np.inf)])
        self.high = np.concatenate([self.high, np.full(count - old, np.inf)])
        self._source = np.concatenate([self._source, np.full(count - old, -1, dtype=np.int64)])
        self.rows.resize(count)
        self.guards.resize(count)

    def _take_constant(self, numbers: Iterable[float]) -> int:
        values = list(numbers)
        at = int(self.rows.constant(values))
        also = int(self.guards.constant(values))
        if at != also:
            raise AssertionError("constants of rows and guards are numbered alike")
        return at

    def _drop_constant(self, column: int) -> None:
        at = self._constants.pop(column, None)
        if at is not None:
            self._unused.append(at)

    @staticmethod
    def _point_starts(entity: Entity) -> list[int]:
        kind = ENTITIES[entity.kind]
        if kind.poles:
            return list(range(entity.at, entity.at + entity.size, 2))
        return [entity.at + offset for _, offset in kind.points]

    def _width(self, at: int) -> int:
        """2 for a point, 1 for another number."""
        entity = self.document.entities[self._entity_at[at]]
        return 2 if at in self._point_starts(entity) else 1

    @staticmethod
    def _hidden_blocks(laid: Laid) -> list[tuple[int, int]]:
        hidden = laid.plan.hidden if laid.plan else []
        return [(at, len(one.names)) for at, one in zip(laid.hidden, hidden, strict=True)]
