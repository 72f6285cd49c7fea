"""Free directions of a sketch as motions that a person recognises.

A free direction is a vector of velocities of the unknowns that no constraint resists. Directions
of a part of a sketch are only known up to their combinations, so the ones that have a name are
looked for first: the part moves along x, along y, turns about a point; a line slides along
itself, an end moves along its line, a circle grows. A motion counts if it lies in the space of
free directions. What is left is described by what its entities do.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.document import Document
from arael.sketch.document.handles import ends, point_offsets
from arael.sketch.document.records import Entity

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A motion is free if at most this part of it is outside of the space of free directions.
_OUTSIDE = 1e-6
#: Numbers of an entity that move by less than this part of the fastest one are at rest.
_AT_REST = 1e-6
#: From so many free directions of a part on, BLAS is limited to one thread.
_MANY = 100


@dataclass(frozen=True, slots=True)
class Motion:
    """One free direction.

    Attributes
    ----------
    sentence : ``L3 can slide along itself``
    entities : names of what moves, in the order of the document
    velocity : of every unknown of the part
    """

    sentence: str
    entities: tuple[str, ...]
    velocity: Floats


@dataclass(frozen=True, slots=True)
class Part:
    """A connected part of a sketch with its free directions.

    Attributes
    ----------
    entities : of the part
    unknown_of : for every number of the document the unknown of this part that it is, or -1
    basis : (n, f) free directions as columns, n unknowns of the part
    """

    entities: tuple[str, ...]
    unknown_of: Ints
    basis: Floats


def motions(document: Document, part: Part) -> list[Motion]:
    """As many independent motions as the part has free directions, named ones first."""
    count = part.basis.shape[1]
    if not count:
        return []
    if count < _MANY:
        return _Search(document, part).found(count)
    # imported here: start-up time
    from threadpoolctl import threadpool_limits  # type: ignore[import-untyped, unused-ignore]

    # Thousands of small products: threads of BLAS make each slower, ten times on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        return _Search(document, part).found(count)


class _Search:
    def __init__(self, document: Document, part: Part) -> None:
        self.document = document
        self.part = part
        self.values = document.values
        self.free, _ = np.linalg.qr(part.basis)
        # What was taken, as orthonormal combinations of the free directions.
        self.taken = np.zeros((self.free.shape[1],) * 2, order="F")
        self.count = 0
        self.entities = [document.entities[name] for name in part.entities]
        unknowns = [part.unknown_of[one.at : one.at + one.size] for one in self.entities]
        owners = np.repeat(np.arange(len(unknowns)), [len(one) for one in unknowns])
        known = np.concatenate([*unknowns, np.zeros(0, dtype=np.int64)])
        self.owned = owners[known >= 0], known[known >= 0]

    def found(self, count: int) -> list[Motion]:
        result: list[Motion] = []
        said: set[str] = set()
        for sentence, velocity in self._candidates():
            if len(result) == count:
                return result
            if self._is_free(velocity) and self._take(velocity):
                said.add(sentence)
                result.append(Motion(sentence, self._moving(velocity), velocity))
        # What has no name: the free directions themselves, the most local ones first.
        order = np.argsort((np.abs(self.part.basis) > _AT_REST).sum(axis=0), kind="stable")
        for column in order:
            if len(result) == count:
                break
            velocity = self.part.basis[:, column]
            if self._take(velocity):
                sentence = self._described(velocity)
                # Of several such motions each is a way of its own, beside what has a name.
                known = sentence in said
                said.add(sentence)
                sentence += " in another way" if known else ""
                result.append(Motion(sentence, self._moving(velocity), velocity))
        return result

    # --- the space of free directions -------------------------------------------------------

    def _is_free(self, velocity: Floats) -> bool:
        length = float(np.linalg.norm(velocity))
        if length == 0.0:
            return False
        inside = float(np.linalg.norm(self._inside(velocity)))
        return length**2 - inside**2 <= (_OUTSIDE * length) ** 2

    def _inside(self, velocity: Floats) -> Floats:
        """Shares of the free directions in a velocity, most numbers of which are 0."""
        some = np.flatnonzero(velocity)
        found: Floats = velocity[some] @ self.free[some]
        return found

    def _take(self, velocity: Floats) -> bool:
        """Add a velocity to those taken, if it is independent of them."""
        rest = self._inside(velocity)
        rest /= np.linalg.norm(rest)
        taken = self.taken[:, : self.count]
        for _ in range(2):
            rest -= taken @ (taken.T @ rest)
        left = float(np.linalg.norm(rest))
        if left < 1e-6:
            return False
        self.taken[:, self.count] = rest / left
        self.count += 1
        return True

    # --- motions with a name ----------------------------------------------------------------

    def _candidates(self) -> Iterator[tuple[str, Floats]]:
        yield from self._whole()
        for entity in self.entities:
            yield from self._single(entity)

    def _whole(self) -> Iterator[tuple[str, Floats]]:
        """The part as one body."""
        names = self._names(self.part.entities)
        points = self._points()
        if not points:
            return
        along_x, along_y, turn = self._rigid(points)
        held = self._held()
        if not held:
            yield f"{names} can move along x", along_x
            yield f"{names} can move along y", along_y
        center = self._center(along_x, along_y, turn) if not held else held[0]
        x, y = center
        if all(math.hypot(hx - x, hy - y) <= 1e-9 * self._size() for hx, hy in held):
            yield f"{names} can turn about {self._place(x, y)}", turn + y * along_x - x * along_y

    def _size(self) -> float:
        return float(np.abs(self.values).max(initial=0.0)) or 1.0

    def _held(self) -> list[tuple[float, float]]:
        """Points of the part's entities that are fixed."""
        return [
            (float(self.values[at]), float(self.values[at + 1]))
            for entity in self.entities
            for at in point_offsets(entity).values()
            if self.part.unknown_of[at] < 0
        ]

    def _points(self) -> list[tuple[int, int]]:
        """Offset in the document and unknown of the x of every point of the part that moves."""
        found: dict[int, int] = {}
        for entity in self.entities:
            for at in point_offsets(entity).values():
                unknown = int(self.part.unknown_of[at])
                if unknown >= 0:
                    found.setdefault(unknown, at)
        return [(at, unknown) for unknown, at in found.items()]

    def _rigid(self, points: Sequence[tuple[int, int]]) -> tuple[Floats, Floats, Floats]:
        n = len(self.part.basis)
        along_x, along_y, turn = np.zeros(n), np.zeros(n), np.zeros(n)
        for at, unknown in points:
            x, y = self.values[at : at + 2]
            along_x[unknown] = 1.0
            along_y[unknown + 1] = 1.0
            turn[unknown], turn[unknown + 1] = -y, x
        for entity in self.entities:
            if entity.kind in ("ellipse", "earc"):
                rotation = int(self.part.unknown_of[entity.at + entity.size - 1])
                if rotation >= 0:
                    turn[rotation] = 1.0
        return along_x, along_y, turn

    def _center(self, along_x: Floats, along_y: Floats, turn: Floats) -> tuple[float, float]:
        """About which point the part can turn, if it can; its middle if about any."""
        shifts = np.column_stack([along_x, along_y])
        scale = np.linalg.norm(shifts, axis=0)
        outside = (shifts - self.free @ (self.free.T @ shifts)) / scale
        away = turn - self.free @ (self.free.T @ turn)
        if (np.linalg.norm(outside, axis=0) <= _OUTSIDE).all():
            points = np.array([self.values[at : at + 2] for at, _ in self._points()])
            x, y = points.mean(axis=0)
            return float(x), float(y)
        # turn + y along_x - x along_y is to lie in the space: solved for (y, -x).
        weights, *_ = np.linalg.lstsq(outside, -away, rcond=1e-8)
        return float(-weights[1] / scale[1]), float(weights[0] / scale[0])

    def _single(self, entity: Entity) -> Iterator[tuple[str, Floats]]:
        """One entity, with everything else at rest."""
        name, at = entity.name, entity.at
        if entity.kind == "point":
            yield from self._shifts(f"{name} can move", [at])
        elif entity.kind == "line":
            direction = self._unit(at, at + 2)
            both = [at, at + 2]
            yield f"{name} can slide along itself", self._shift(both, direction)
            yield f"{name} can move sideways", self._shift(both, (-direction[1], direction[0]))
            for end in ("p1", "p2"):
                here = at if end == "p1" else at + 2
                yield (
                    f"{name} can become longer at {end}",
                    self._shift([here], direction),
                )
                yield (
                    f"{name} can turn about {self._other(name, end)}",
                    self._shift([here], (-direction[1], direction[0])),
                )
        elif entity.kind in ("circle", "arc", "ellipse", "earc"):
            yield from self._round(entity)
        else:
            for i in range(entity.size // 2):
                yield from self._shifts(f"pole {i + 1} of {name} can move", [at + 2 * i])

    def _round(self, entity: Entity) -> Iterator[tuple[str, Floats]]:
        name, at = entity.name, entity.at
        points = list(point_offsets(entity).values())
        yield from self._shifts(f"{name} can move", points)
        if entity.kind in ("circle", "ellipse"):
            yield f"{name} can grow", self._number(at + 2)
        if entity.kind in ("arc", "earc"):
            for end in ends(entity):
                here = point_offsets(entity)[end]
                tangent = self._unit(at, here)
                yield (
                    f"the {end} of {name} can move along it",
                    self._shift([here], (-tangent[1], tangent[0])),
                )
        if entity.kind == "arc":
            grow = self._number(at + 6)
            for here in points[1:]:
                unknown = self.part.unknown_of[here]
                if unknown >= 0:
                    grow[unknown : unknown + 2] += self._unit(at, here)
            yield f"{name} can grow", grow
        if entity.kind == "ellipse":
            yield f"{name} can grow across its major axis", self._number(at + 3)
            yield f"{name} can turn about its center", self._number(at + 4)

    def _shifts(self, sentence: str, points: Sequence[int]) -> Iterator[tuple[str, Floats]]:
        yield f"{sentence} along x", self._shift(points, (1.0, 0.0))
        yield f"{sentence} along y", self._shift(points, (0.0, 1.0))

    def _shift(self, points: Sequence[int], direction: tuple[float, float]) -> Floats:
        velocity = np.zeros(len(self.part.basis))
        for at in points:
            unknown = int(self.part.unknown_of[at])
            if unknown < 0:
                return np.zeros(len(self.part.basis))
            velocity[unknown : unknown + 2] = direction
        return velocity

    def _number(self, at: int) -> Floats:
        velocity = np.zeros(len(self.part.basis))
        unknown = int(self.part.unknown_of[at])
        if unknown >= 0:
            velocity[unknown] = 1.0
        return velocity

    def _unit(self, start: int, end: int) -> tuple[float, float]:
        x, y = self.values[end : end + 2] - self.values[start : start + 2]
        length = math.hypot(x, y) or 1.0
        return float(x / length), float(y / length)

    def _other(self, name: str, end: str) -> str:
        return f"{name}.{'p2' if end == 'p1' else 'p1'}"

    # --- words ------------------------------------------------------------------------------

    def _described(self, velocity: Floats) -> str:
        """What the entities do in a motion without a name: as one body, or each by itself."""
        moving = self._moving(velocity)
        if not moving:
            return "a number of the solution that moves nothing drawn can change"
        body = self._as_body(velocity, moving)
        if body is not None:
            return body
        said = [self._deed(self.document.entities[name], velocity) for name in moving[:3]]
        more = len(moving) - 3
        if more > 0:
            said.append(f"{more} more follow{'s' if more == 1 else ''}")
        return listed(said) + (" together" if len(said) > 1 else "")

    def _as_body(self, velocity: Floats, moving: tuple[str, ...]) -> str | None:
        """The sentence of a rigid motion of everything that moves, None if it is not one."""
        rows, target = [], []
        for name in moving:
            entity = self.document.entities[name]
            for at in point_offsets(entity).values():
                unknown = int(self.part.unknown_of[at])
                vx, vy = velocity[unknown : unknown + 2] if unknown >= 0 else (0.0, 0.0)
                x, y = self.values[at : at + 2]
                rows += [[1.0, 0.0, -y], [0.0, 1.0, x]]
                target += [vx, vy]
        for name in moving:
            for at in self._scalars(self.document.entities[name]):
                unknown = int(self.part.unknown_of[at])
                if unknown >= 0 and abs(velocity[unknown]) > 1e-6 * np.abs(velocity).max():
                    return None
        matrix, wanted = np.array(rows), np.array(target)
        scale = np.linalg.norm(matrix, axis=0)
        scale[scale == 0.0] = 1.0
        weights = np.linalg.lstsq(matrix / scale, wanted, rcond=1e-10)[0] / scale
        if np.abs(matrix @ weights - wanted).max(initial=0.0) > 1e-6 * np.abs(wanted).max():
            return None
        tx, ty, w = weights
        names = self._names(moving)
        extent = np.abs(matrix[:, 2]).max(initial=0.0)
        if abs(w) * extent <= 1e-9 * max(abs(tx), abs(ty)):
            return f"{names} can move along ({tx:.3g}, {ty:.3g})"
        return f"{names} can turn about {self._place(-ty / w, tx / w)}"

    def _deed(self, entity: Entity, velocity: Floats) -> str:
        """What one entity does."""
        points = {
            name: velocity[u : u + 2] if (u := int(self.part.unknown_of[at])) >= 0 else np.zeros(2)
            for name, at in point_offsets(entity).items()
        }
        fastest = max((float(np.hypot(*v)) for v in points.values()), default=0.0)
        top = float(np.abs(velocity).max())
        if entity.kind == "line":
            along = np.array(self._unit(entity.at, entity.at + 2))
            across = np.array([-along[1], along[0]])
            v1, v2 = points["p1"], points["p2"]
            turns = abs(float(across @ (v2 - v1))) > 1e-6 * fastest
            grows = abs(float(along @ (v2 - v1))) > 1e-6 * fastest
            if turns:
                return f"{entity.name} can turn" + (" and change its length" if grows else "")
            return f"{entity.name} can {'change its length' if grows else 'move'}"
        for at in self._scalars(entity):
            unknown = int(self.part.unknown_of[at])
            if unknown >= 0 and abs(velocity[unknown]) > _AT_REST * top:
                moves = np.abs(points["center"]).max() > _AT_REST * top
                return f"{entity.name} can grow" + (" as its center moves" if moves else "")
        return f"{entity.name} can move"

    def _scalars(self, entity: Entity) -> list[int]:
        count = {"circle": 1, "arc": 1, "ellipse": 2, "earc": 2}.get(entity.kind, 0)
        last = 1 if entity.kind in ("ellipse", "earc") else 0
        end = entity.at + entity.size - last
        return list(range(end - count, end))

    def _moving(self, velocity: Floats) -> tuple[str, ...]:
        limit = _AT_REST * float(np.abs(velocity).max(initial=0.0))
        moves = np.abs(velocity) > limit
        owners, unknowns = self.owned
        found = np.unique(owners[moves[unknowns]])
        return tuple(self.entities[i].name for i in found.tolist())

    def _names(self, names: Sequence[str]) -> str:
        return listed(shortened(names))

    def _place(self, x: float, y: float) -> str:
        """A point that is drawn there, else coordinates."""
        size = self._size()
        for entity in self.entities:
            for point, at in point_offsets(entity).items():
                if math.hypot(self.values[at] - x, self.values[at + 1] - y) <= 1e-6 * size:
                    return entity.name if entity.kind == "point" else f"{entity.name}.{point}"
        return f"({x:.4g}, {y:.4g})"


def shortened(names: Sequence[str], most: int = 4) -> list[str]:
    """Names with runs of numbers joined: ``L0..L3``; at most some of them, then how many more."""
    runs: list[list[str]] = []
    for name in names:
        prefix = name.rstrip("0123456789")
        if runs and prefix != name:
            last = runs[-1][-1]
            if last == f"{prefix}{int(name[len(prefix) :]) - 1}":
                runs[-1].append(name)
                continue
        runs.append([name])
    said = []
    for run in runs:
        said += [f"{run[0]}..{run[-1]}"] if len(run) > 2 else run
    if len(said) > most:
        rest = len(said) - most
        said = [*said[:most], f"{rest} more"]
    return said


def listed(words: Sequence[str]) -> str:
    """Words with commas and `and`."""
    if len(words) < 2:
        return words[0] if words else "nothing"
    return ", ".join(words[:-1]) + " and " + words[-1]
