"""Verdicts and freedoms against the exact rank of rational sketches.

Points have integer coordinates, lines the directions of Pythagorean triples, so that every
equation's gradient, scaled, is rational. SymPy finds the rank without rounding.
"""

from __future__ import annotations

import random
from fractions import Fraction

import pytest
from sympy import Rational
from sympy.polys.domains import QQ
from sympy.polys.matrices import DomainMatrix

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session

Gradient = dict[int, Fraction]

#: Relative to the nodes of a grid: every pair of them is at an integer distance or has none.
NODES = [(0, 0), (4, 0), (4, 3), (0, 3), (8, 0), (8, 3), (0, 6), (8, 6), (4, 6), (12, 3)]


class Exact:
    """A sketch of points and lines between integer places, with its gradients over the rationals.

    Attributes
    ----------
    place : coordinates by handle
    rows : gradients of what was let in
    """

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.session = Session()
        self.place: dict[str, tuple[int, int]] = {}
        self.lines: list[str] = []
        self.rows: list[Gradient] = []
        self.used: set[str] = set()
        for _ in range(self.random.randint(3, 4)):
            (ax, ay), (bx, by) = self.random.sample(NODES, 2)
            (name,) = self.session.run(f"add_line {ax},{ay} {bx},{by} noconnect")[0].names
            self.lines.append(name)
            self.place |= {f"{name}.p1": (ax, ay), f"{name}.p2": (bx, by)}
        for _ in range(3):
            x, y = self.random.choice(NODES)
            (name,) = self.session.run(f"add_point {x},{y} noconnect")[0].names
            self.place[name] = (x, y)
        self.column = {handle: 2 * k for k, handle in enumerate(self.place)}

    # --- equations --------------------------------------------------------------------------

    def row(self, *terms: tuple[str, float, float]) -> Gradient:
        """A gradient from the derivatives by the coordinates of points."""
        found: Gradient = {}
        for handle, x, y in terms:
            for k, part in enumerate((x, y)):
                at = self.column[handle] + k
                found[at] = found.get(at, Fraction(0)) + Fraction(part)
        return found

    def direction(self, line: str) -> tuple[int, int]:
        (ax, ay), (bx, by) = self.place[f"{line}.p1"], self.place[f"{line}.p2"]
        return bx - ax, by - ay

    def candidates(self) -> list[tuple[str, list[Gradient]]]:
        """Commands that hold where the points are, with their gradients."""
        found: list[tuple[str, list[Gradient]]] = []
        handles, row = list(self.place), self.row
        for handle in handles:
            found.append((f"lock {handle}", [row((handle, 1, 0)), row((handle, 0, 1))]))
        for i, a in enumerate(handles):
            for b in handles[i + 1 :]:
                dx, dy = (self.place[b][k] - self.place[a][k] for k in (0, 1))
                if (dx, dy) == (0, 0):
                    if a.partition(".")[0] != b.partition(".")[0]:
                        both = [row((a, 1, 0), (b, -1, 0)), row((a, 0, 1), (b, 0, -1))]
                        found.append((f"coincident {a} {b}", both))
                    continue
                if dy == 0:
                    found.append((f"horizontal {a} {b}", [row((a, 0, 1), (b, 0, -1))]))
                if dx == 0:
                    found.append((f"vertical {a} {b}", [row((a, 1, 0), (b, -1, 0))]))
                found.append((f"distance {a} {b} driven", [row((a, -dx, -dy), (b, dx, dy))]))
                found += [
                    (f"symmetry {a} {c} {b}", both)
                    for c in handles
                    if 2 * self.place[c][0] == self.place[a][0] + self.place[b][0]
                    and 2 * self.place[c][1] == self.place[a][1] + self.place[b][1]
                    for both in [
                        [
                            row((a, 1, 0), (b, 1, 0), (c, -2, 0)),
                            row((a, 0, 1), (b, 0, 1), (c, 0, -2)),
                        ]
                    ]
                ]
        for line in self.lines:
            found += self._of_line(line)
        return found

    def _of_line(self, line: str) -> list[tuple[str, list[Gradient]]]:
        found: list[tuple[str, list[Gradient]]] = []
        row = self.row
        p, q = f"{line}.p1", f"{line}.p2"
        (px, py), (qx, qy) = self.place[p], self.place[q]
        dx, dy = self.direction(line)
        found.append((f"length {line} driven", [row((p, -dx, -dy), (q, dx, dy))]))
        for other in self.lines:
            if other <= line:
                continue
            ex, ey = self.direction(other)
            r, s = f"{other}.p1", f"{other}.p2"
            if dx * ey - dy * ex == 0:
                # of the cross product of the directions
                gradient = row((p, -ey, ex), (q, ey, -ex), (r, dy, -dx), (s, -dy, dx))
                found.append((f"parallel {line} {other}", [gradient]))
            if dx * ex + dy * ey == 0:
                gradient = row((p, -ex, -ey), (q, ex, ey), (r, -dx, -dy), (s, dx, dy))
                found.append((f"perpendicular {line} {other}", [gradient]))
            if dx * dx + dy * dy == ex * ex + ey * ey:
                gradient = row((p, -dx, -dy), (q, dx, dy), (r, ex, ey), (s, -ex, -ey))
                found.append((f"equal {line} {other}", [gradient]))
        for handle, (x, y) in self.place.items():
            if handle in (p, q):
                continue
            if (2 * x, 2 * y) == (px + qx, py + qy):
                both = [
                    row((handle, 2, 0), (p, -1, 0), (q, -1, 0)),
                    row((handle, 0, 2), (p, 0, -1), (q, 0, -1)),
                ]
                found.append((f"midpoint {handle} {line}", both))
            if dx * (y - py) - dy * (x - px) == 0:
                # of cross(q - p, point - p)
                gradient = row(
                    (handle, -dy, dx), (p, dy - (y - py), (x - px) - dx), (q, y - py, -(x - px))
                )
                found.append((f"point_on {handle} {line}", [gradient]))
            for second, (u, v) in self.place.items():
                if second <= handle or second in (p, q) or (u, v) == (x, y):
                    continue
                middle = dx * (y + v - 2 * py) - dy * (x + u - 2 * px)
                across = dx * (u - x) + dy * (v - y)
                if middle == 0 and across == 0:
                    found.append(
                        (f"symmetry {handle} {line} {second}", self._mirror(line, handle, second))
                    )
        return found

    def _mirror(self, line: str, a: str, b: str) -> list[Gradient]:
        p, q = f"{line}.p1", f"{line}.p2"
        px, py = self.place[p]
        (x, y), (u, v) = self.place[a], self.place[b]
        dx, dy = self.direction(line)
        ex, ey = u - x, v - y
        mx, my = x + u - 2 * px, y + v - 2 * py
        across = self.row((a, -dx, -dy), (b, dx, dy), (p, -ex, -ey), (q, ex, ey))
        middle = self.row((a, -dy, dx), (b, -dy, dx), (p, 2 * dy - my, mx - 2 * dx), (q, my, -mx))
        return [across, middle]

    # --- rank -------------------------------------------------------------------------------

    def rank(self, more: list[Gradient]) -> int:
        """Exact rank of what was let in and more."""
        rows = [*self.rows, *more]
        if not rows:
            return 0
        width = 2 * len(self.place)
        matrix = [[QQ.from_sympy(Rational(r.get(k, 0))) for k in range(width)] for r in rows]
        return int(DomainMatrix(matrix, (len(rows), width), QQ).rank())


def agreed(seed: int, steps: int) -> tuple[int, int]:
    """Let in random relations; how many were independent, how many were not."""
    exact = Exact(seed)
    candidates = exact.candidates()
    exact.random.shuffle(candidates)
    gained_ones = refused_ones = 0
    rank = 0
    for line, gradients in candidates[:steps]:
        gained = exact.rank(gradients) - rank
        try:
            (reply,) = exact.session.run(line)
        except AraelError as error:
            code = error.diagnostics[0].code
            if code == "E1221":  # the same once more
                continue
            assert gained == 0, (line, code, gained)
            assert code == "E1230", line  # it holds already: never impossible
            refused_ones += 1
        else:
            if gained == 0 and not line.startswith(
                "lock"
            ):  # see test_a_lock_that_adds_nothing_is_redundant_is_redundant
                verdict = exact.session.editor.judge.verdict(reply.names[-1])
                assert verdict.kind == "here", line
            gained_ones += 1
            exact.rows += gradients
            rank += gained
        total = exact.session.editor.judge.freedoms().total
        assert total == 2 * len(exact.place) - rank, line
    return gained_ones, refused_ones


@pytest.mark.sweep(3)
@pytest.mark.parametrize("seed", range(7))
def test_verdicts_are_those_of_the_exact_rank(seed: int) -> None:
    gained, _ = agreed(seed, 30)
    assert gained > 3


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(100, 300))
def test_verdicts_of_many_sketches_are_those_of_the_exact_rank(seed: int) -> None:
    agreed(seed, 80)
