"""What a solve found of the rows that hold exactly: multipliers, which act, violations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from arael.runtime.constrained.rows import Bools, Floats, Part

# Rows of the largest multipliers that a report shows.
SHOWN = 3
# Relative violation from which a report calls a row violated.
VIOLATED = 1e-6


@dataclass(frozen=True, eq=False)
class Requirement:
    """One `require` of a model, or the bounds of its parameters.

    Attributes
    ----------
    label : ``Pose.clearance``; ``bounds`` of parameters
    text : the comparison as written
    places : name of each row
    values : (n, m) left side minus right side, so that an inequality holds where it is positive
    multipliers : (n, m), see `Result.multipliers`
    active : (n, m) whether an inequality holds as an equality; True for equalities
    units : of each of the m rows, "" where unknown or none
    equal : whether it is an equality
    """

    label: str
    text: str
    places: tuple[str, ...]
    values: Floats
    multipliers: Floats
    active: Bools
    units: tuple[str, ...]
    equal: bool


@dataclass(frozen=True, eq=False)
class Required(Mapping[str, Requirement]):
    """All of them, by label.

    Attributes
    ----------
    layout : which rows belong to what
    row_values, row_multipliers, row_active : (rows,), as of `Requirement`
    violation : largest violation, relative to the scale of its row
    worst : name of that row
    conflict : of an infeasible problem, rows that cannot hold together; each of them can be left
        out to make the others hold
    """

    layout: tuple[Part, ...]
    row_values: Floats
    row_multipliers: Floats
    row_active: Bools
    violation: float
    worst: str
    conflict: tuple[str, ...] = ()

    @cached_property
    def parts(self) -> tuple[Requirement, ...]:
        """One for each label."""
        return tuple(
            Requirement(
                one.label,
                one.text,
                one.places,
                self.row_values[one.rows],
                self.row_multipliers[one.rows],
                self.row_active[one.rows],
                one.units,
                one.equal,
            )
            for one in self.layout
        )

    def __getitem__(self, label: str) -> Requirement:
        for one in self.parts:
            if one.label == label:
                return one
        raise KeyError(
            f"nothing required is called {label!r}; there is {', '.join(self) or 'none'}"
        )

    def __iter__(self) -> Iterator[str]:
        return (one.label for one in self.parts)

    def __len__(self) -> int:
        return len(self.parts)

    def multipliers(self) -> dict[str, Floats]:
        """Multipliers by label."""
        return {one.label: one.multipliers for one in self.parts}

    def sentences(self, cost: float) -> list[str]:
        """What is required, in words: what holds, which inequalities cost most, or the conflict."""
        if self.conflict:
            lines = ["cannot hold together; without any one of them, the others can:"]
            return [*lines, *(f"  {name}" for name in self.conflict)]
        rows = sum(one.values.size for one in self.parts)
        sided = [one for one in self.parts if not one.equal]
        acting = sum(int(one.active.sum()) for one in sided)
        of = sum(one.values.size for one in sided)
        if self.violation > VIOLATED:
            head = f"`{self.worst}` is violated by {self.violation:.2g} of its scale"
        else:
            head = f"{rows} required row{'s' * (rows != 1)} hold{'s' * (rows == 1)}"
        if of:
            head += f"; {acting} of {of} inequalities {'acts' if acting == 1 else 'act'}"
        # Without a cost nothing pulls, and multipliers are rounding.
        return [head, *(_price(*one, cost) for one in self._largest() if cost > 0.0)]

    def _largest(self) -> list[tuple[Requirement, int, int]]:
        """The rows of the largest multipliers."""
        found = [
            (one, *divmod(int(k), one.values.shape[1]))
            for one in self.parts
            for k in np.argsort(-np.abs(one.multipliers), axis=None)[:SHOWN]
            if one.multipliers.ravel()[k] != 0.0
        ]
        found.sort(key=lambda each: -abs(each[0].multipliers[each[1], each[2]]))
        return found[:SHOWN]

    def to_dict(self) -> dict[str, object]:
        """Plain data for JSON."""
        return {
            "violation": self.violation,
            "worst": self.worst,
            "conflict": list(self.conflict),
            "rows": [
                {
                    "label": one.label,
                    "text": one.text,
                    "places": list(one.places),
                    "values": one.values.tolist(),
                    "multipliers": one.multipliers.tolist(),
                    "active": one.active.tolist(),
                    "units": list(one.units),
                }
                for one in self.parts
            ],
        }


def _price(one: Requirement, instance: int, row: int, cost: float) -> str:
    """What a row costs: a sentence with a change of the limit that lowers the cost a little."""
    price = float(one.multipliers[instance, row])
    unit = one.units[row] if one.units else ""
    change = _rounded(0.01 * cost / abs(price))
    amount = f"{change:g} {unit}".strip()
    how = f"raised by {amount}" if one.equal else f"relaxed by {amount}"
    if one.equal and price < 0:
        how = f"lowered by {amount}"
    part = f"[{row}]" if one.values.shape[1] > 1 else ""
    per = f" per {unit}" if unit else ""
    return (
        f"`{one.label}`{part} at {one.places[instance]} costs {abs(price):.3g}{per}: {how}, the "
        f"cost would fall by about {abs(price) * change:.2g}"
    )


def _rounded(value: float) -> float:
    """One digit."""
    return float(f"{value:.0e}")
