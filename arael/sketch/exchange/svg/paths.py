"""Path data and transforms of SVG."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import radians, tan

from arael.sketch.geometry import Affine, Arc, Bezier, Curve, EllipticArc, Line, Point, elliptic_arc

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_TOKEN = re.compile(rf"\s*,?\s*(?:([MmZzLlHhVvCcSsQqTtAa])|({NUMBER}))")
_FLAG = re.compile(r"\s*,?\s*([01])")
_COUNTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2, "A": 7}


class PathError(ValueError):
    """Raised for path data that does not follow the grammar."""


def path_curves(data: str) -> Iterator[Curve]:
    """Curves of the ``d`` attribute, in its coordinates.

    Closed sub-paths end with a line unless it has no length; quadratic curves are raised to cubic
    ones. A line without length is kept: it stands for a point.

    Raises
    ------
    PathError
        Where the data does not follow the grammar; curves before that were yielded, as SVG demands.
    """
    here: Point = (0.0, 0.0)
    first: Point = (0.0, 0.0)
    cubic: Point | None = None  # last inner pole, for smooth continuations
    quadratic: Point | None = None
    for index, (command, n) in enumerate(_commands(data)):
        upper = command.upper()
        if index == 0 and upper != "M":
            raise PathError("a path begins with `M`")
        ox, oy = here if command.islower() else (0.0, 0.0)
        next_cubic = next_quadratic = None
        if upper == "M":
            here = first = (n[0] + ox, n[1] + oy)
        elif upper == "Z":
            if here != first:
                yield Line(here, first)
            here = first
        elif upper in "LHV":
            x = n[0] + ox if upper in "LH" else here[0]
            y = n[-1] + oy if upper in "LV" else here[1]
            yield Line(here, (x, y))
            here = x, y
        elif upper in "CS":
            if upper == "C":
                q = n[0] + ox, n[1] + oy
            else:
                q = (2 * here[0] - cubic[0], 2 * here[1] - cubic[1]) if cubic else here
            r, s = (n[-4] + ox, n[-3] + oy), (n[-2] + ox, n[-1] + oy)
            yield Bezier((here, q, r, s))
            here, next_cubic = s, r
        elif upper in "QT":
            if upper == "Q":
                q = n[0] + ox, n[1] + oy
            else:
                q = (2 * here[0] - quadratic[0], 2 * here[1] - quadratic[1]) if quadratic else here
            s = n[-2] + ox, n[-1] + oy
            yield Bezier((here, _third(here, q), _third(s, q), s))
            here, next_quadratic = s, q
        else:
            end = n[5] + ox, n[6] + oy
            yield from _arc(here, n, end)
            here = end
        cubic, quadratic = next_cubic, next_quadratic


def _third(end: Point, pole: Point) -> Point:
    return end[0] + 2 / 3 * (pole[0] - end[0]), end[1] + 2 / 3 * (pole[1] - end[1])


def _arc(here: Point, n: list[float], end: Point) -> Iterator[Curve]:
    if here == end:
        return  # SVG leaves such an arc out
    found = elliptic_arc(here, end, n[0], n[1], radians(n[2]), large=bool(n[3]), clockwise=not n[4])
    yield simplest(found) if found is not None else Line(here, end)


def simplest(curve: Curve) -> Curve:
    """A circular arc in place of an elliptic one of equal radii."""
    if isinstance(curve, EllipticArc) and abs(curve.rx - curve.ry) <= 1e-12 * curve.rx:
        return Arc(curve.center, curve.rx, curve.angle + curve.rotation, curve.sweep)
    return curve


def _commands(data: str) -> Iterator[tuple[str, list[float]]]:
    """Commands with their numbers; repeated numbers repeat the command, after ``M`` as ``L``."""
    at, command, numbers = 0, "", list[float]()
    end = len(data.rstrip())
    fresh = False  # a command without its numbers yet
    while at < end:
        if command in ("A", "a") and len(numbers) in (3, 4):
            flag = _FLAG.match(data, at)
            if flag is None:
                raise PathError(f"expected a flag, 0 or 1, at {data[at : at + 20]!r}")
            numbers.append(float(flag[1]))
            at = flag.end()
            continue
        match = _TOKEN.match(data, at)
        if match is None:
            raise PathError(f"expected a command or a number at {data[at : at + 20]!r}")
        at = match.end()
        if match[1]:
            if numbers or fresh:
                raise PathError(f"too few numbers for `{command}`")
            command, fresh = match[1], True
            if command in "Zz":
                yield "Z", []
                fresh = False
            continue
        if not command or command in "Zz":
            raise PathError(f"expected a command at {match[2]!r}")
        numbers.append(float(match[2]))
        if len(numbers) == _COUNTS[command.upper()]:
            yield command, numbers
            numbers, fresh = [], False
            command = {"M": "L", "m": "l"}.get(command, command)
    if numbers or fresh:
        raise PathError(f"too few numbers for `{command}`")


_FUNCTION = re.compile(r"\s*,?\s*(\w+)\s*\(([^()]*)\)")


def transform_of(text: str) -> Affine:
    """The map of a ``transform`` attribute; raises `PathError` if it is none."""
    found, at = Affine(), 0
    end = len(text.rstrip())
    while at < end:
        match = _FUNCTION.match(text, at)
        if match is None:
            raise PathError(f"expected a transform at {text[at : at + 30]!r}")
        at = match.end()
        numbers = [float(x) for x in re.findall(NUMBER, match[2])]
        found = found.after(_function(match[1], numbers))
    return found


def _function(name: str, n: list[float]) -> Affine:
    if name == "matrix" and len(n) == 6:
        return Affine(*n)
    if name == "translate" and len(n) in (1, 2):
        return Affine.shift((n[0], n[1] if len(n) == 2 else 0.0))
    if name == "scale" and len(n) in (1, 2):
        return Affine(n[0], 0.0, 0.0, n[-1])
    if name == "rotate" and len(n) in (1, 3):
        return Affine.rotation(radians(n[0]), (n[1], n[2]) if len(n) == 3 else (0.0, 0.0))
    if name == "skewX" and len(n) == 1:
        return Affine(c=tan(radians(n[0])))
    if name == "skewY" and len(n) == 1:
        return Affine(b=tan(radians(n[0])))
    raise PathError(f"`{name}` with {len(n)} numbers is not a transform")
