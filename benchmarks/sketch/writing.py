"""Sketches written down: as commands, and as a file of lines for programs of other languages."""

from __future__ import annotations

import numpy as np

from benchmarks.sketch.sketches import KINDS, Rule, Sketch


def script(sketch: Sketch) -> list[str]:
    """Commands that draw a sketch, one each; names follow from their order.

    Lines are ``L0``.., circles ``A0``.., arcs follow them. Ends that meet are connected
    automatically; tangents are among the rules, so arcs are made without.
    """
    x = [f"{a!r},{b!r}" for a, b in sketch.points.tolist()]
    made = [f"add_line {x[a]} {x[b]}" for a, b in sketch.lines]
    made += [
        f"add_circle {x[c]} {r!r}"
        for c, r in zip(sketch.circles, sketch.radii.tolist(), strict=True)
    ]
    for arc in sketch.arcs:
        center, start, end = sketch.points[list(arc)]
        turn = np.arctan2(*(start - center)[::-1])
        sweep = (np.arctan2(*(end - center)[::-1]) - turn) % (2 * np.pi)
        middle = center + np.linalg.norm(start - center) * np.array(
            [np.cos(turn + sweep / 2), np.sin(turn + sweep / 2)]
        )
        through = ",".join(repr(v) for v in middle.tolist())
        made.append(f"add_arc {x[arc[1]]} {x[arc[2]]} {through} notangent")
    return made + [command(sketch, rule) for rule in sketch.rules]


WORDS = {"equal_radius": "equal", "equal_arcs": "equal", "arc_radius": "radius"}
"""Words of commands where they are not the kind's."""


def command(sketch: Sketch, rule: Rule) -> str:
    """The command that adds a rule."""
    return " ".join(
        [WORDS.get(rule.kind, rule.kind), *operands(sketch, rule), amount(rule)]
    ).strip()


def operands(sketch: Sketch, rule: Rule) -> list[str]:
    """Names of what a rule is about."""
    offset = {"line": ("L", 0), "circle": ("A", 0), "arc": ("A", len(sketch.circles))}
    names = []
    for kind, number in zip(KINDS[rule.kind].operands, rule.of, strict=True):
        if kind == "point":
            names.append(handle(sketch, number))
        else:
            prefix, first = offset[kind]
            names.append(f"{prefix}{first + number}")
    return names


def amount(rule: Rule) -> str:
    """The values of a rule as a command has them."""
    return ",".join(repr(value) for value in rule.values)


def handle(sketch: Sketch, point: int) -> str:
    """The first name of a point."""
    for i, ends in enumerate(sketch.lines):
        if point in ends:
            return f"L{i}.p{1 + ends.index(point)}"
    for i, center in enumerate(sketch.circles):
        if point == center:
            return f"A{i}.center"
    for i, arc in enumerate(sketch.arcs):
        if point in arc:
            return f"A{len(sketch.circles) + i}.{('center', 'start', 'end')[arc.index(point)]}"
    raise ValueError(f"point {point} of {sketch.name} belongs to nothing")


def lines(sketch: Sketch) -> list[str]:
    """The sketch as lines of words, and its commands behind."""

    def rule(word: str, r: Rule) -> str:
        values = " ".join(repr(v) for v in r.values)
        return f"{word} {r.kind} {' '.join(str(n) for n in r.of)} | {values}".strip()

    found = [f"point {a!r} {b!r}" for a, b in sketch.points.tolist()]
    found += [f"line {a} {b}" for a, b in sketch.lines]
    found += [
        f"circle {c} {r!r}" for c, r in zip(sketch.circles, sketch.radii.tolist(), strict=True)
    ]
    found += [f"arc {a} {b} {c}" for a, b, c in sketch.arcs]
    found += [rule("rule", r) for r in sketch.rules]
    found += [rule(f"candidate {name}", r) for name, r in sketch.candidates.items()]
    found += [f"ask {name} {command(sketch, r)}" for name, r in sketch.candidates.items()]
    if sketch.changed >= 0:
        changed = sketch.rules[sketch.changed]
        word = WORDS.get(changed.kind, changed.kind)
        stem = " ".join([word, *operands(sketch, changed)])
        found.append(f"change {sketch.changed} {' '.join(repr(v) for v in sketch.targets)}")
        found.append(f"stem {stem}")
    if sketch.grabbed >= 0:
        found.append(f"grab {sketch.grabbed} {handle(sketch, sketch.grabbed)}")
        found += [f"frame {a!r} {b!r}" for a, b in sketch.path.tolist()]
    return found + [f"command {word}" for word in script(sketch)]
