"""Lists of refs of fixed length: of one row, and of many rows together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.face.fields import Part
from arael.runtime.store.messages import describe, error

if TYPE_CHECKING:
    from arael.face.ref import Ref, Refs


class RefList(Part):
    """The list of refs of one row, ``samples[3].knots``, or of many rows, ``samples.knots``.

    Of one row it has k `Ref`s; of n rows its k elements are `Refs`, n each. Elements are read and
    assigned by number, ``samples[3].knots[0] = model.knots[2]``; the whole list is assigned to the
    field, ``samples[3].knots = [a, b, c, d]``.
    """

    def __len__(self) -> int:
        return self._group.refs

    def __getitem__(self, at: Any) -> Any:
        """Return an element: `Ref` of one row, `Refs` of many; or a list of them for a slice."""
        if isinstance(at, slice):
            return [self[k] for k in range(*at.indices(len(self)))]
        return super().__getitem__(at if isinstance(at, str) else self._name(at))

    def __setitem__(self, at: Any, value: Any) -> None:
        super().__setitem__(at if isinstance(at, str) else self._name(at), value)

    def __iter__(self) -> Iterator[Ref | Refs]:
        for k in range(len(self)):
            yield self[k]

    def _name(self, at: Any) -> str:
        place = self._origin(self._group.path)
        if isinstance(at, bool) or not isinstance(at, int | np.integer):
            text = f"expected the number of a ref, 0 .. {len(self) - 1}, found {describe(at)}"
            raise error("E0703", text, place)
        if not -len(self) <= at < len(self):
            raise IndexError(f"{place}[{at}]: there are {len(self)} refs")
        return str(int(at) % len(self))

    @property
    def index(self) -> NDArray[np.int64]:
        """Indices of the targets within their collections: (k,) of one row, (n, k) of many."""
        return np.stack([np.asarray(self[k].index) for k in range(len(self))], axis=-1)

    @property
    def rows(self) -> NDArray[np.int64]:
        """Row numbers of the targets in their table: (k,) of one row, (n, k) of many."""
        one = isinstance(self._rows(), int)
        found = [self[k].row if one else self[k].rows for k in range(len(self))]
        return np.stack([np.asarray(rows) for rows in found], axis=-1)

    def __repr__(self) -> str:
        names = [self.short_text(member) for member in self._group.members.values()]
        return f"<{self._origin(self._group.path)}: {', '.join(names)}>"


def elements(value: Any, count: int, origin: Any, text: str) -> dict[str, Any]:
    """Values of the elements of a list of refs, by number.

    Parameters
    ----------
    value : refs, indices or keys of one row (count,), or those of many rows (n, count)
    count : length of the list
    origin : name of the field for messages
    text : what its elements refer to

    Raises
    ------
    AraelError
        E0703 no list; E0704 another number of refs, with the row; E0707 null.
    """
    # imported here: the circle of fields, collections and refs
    from arael.face.ref import Refs

    if isinstance(value, RefList):
        value = list(value)
        many = bool(value) and isinstance(value[0], Refs)
        _check_length(len(value), count, origin, text, None)
        return {str(k): list(one) if many else one for k, one in enumerate(value)}
    if isinstance(value, np.ndarray) and value.ndim == 2:
        _check_length(value.shape[1], count, origin, text, 0 if len(value) else None)
        return {str(k): value[:, k] for k in range(count)}
    if not isinstance(value, (list, tuple, np.ndarray, Refs)):
        raise error(
            "E0703",
            f"expected a list of {count} refs, found {type(value).__name__}",
            origin,
            help=f"give {count} refs, indices or keys of {text}",
        )
    items = list(value)
    if items and all(isinstance(one, (list, tuple, np.ndarray, Refs, RefList)) for one in items):
        for row, one in enumerate(items):
            _check_length(len(one), count, origin, text, row)
        return {str(k): [one[k] for one in items] for k in range(count)}
    _check_length(len(items), count, origin, text, None)
    null = next((k for k, one in enumerate(items) if one is None), None)
    if null is not None:
        raise error("E0707", "null where a ref is needed", f"{origin}[{null}]")
    return {str(k): one for k, one in enumerate(items)}


def _check_length(found: int, count: int, origin: Any, text: str, row: int | None) -> None:
    if found != count:
        where = "" if row is None else f" in row {row}"
        raise error("E0704", f"expected {count} refs to {text}, found {found}{where}", origin)
