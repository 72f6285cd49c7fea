"""Commands that make constraints, and dry runs of any command."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from arael.diagnostics.records import AraelError
from arael.sketch.commands.describing import constraint_line, noticed
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command, find
from arael.sketch.commands.tokens import fail
from arael.sketch.document.kinds import CONSTRAINTS
from arael.sketch.document.records import Constraint

_FORCE = """
Append `force` to let in a constraint that is redundant.
"""


class _Kind(NamedTuple):
    """How a kind of constraint is written.

    `share` says how more than the smallest number of operands is meant: ``each``: one constraint
    each; ``first``: the first with each of the others; empty: not at all.
    """

    usage: tuple[str, ...]
    summary: str
    aliases: tuple[str, ...] = ()
    share: str = ""
    keywords: tuple[str, ...] = ()
    details: str = ""


_KINDS = {
    "horizontal": _Kind(
        ("horizontal L0 [L1 ...]", "horizontal L0.p1 L1.p2"),
        "Make lines, or two points, horizontal.",
        share="each",
    ),
    "vertical": _Kind(
        ("vertical L0 [L1 ...]", "vertical L0.p1 L1.p2"),
        "Make lines, or two points, vertical.",
        share="each",
    ),
    "parallel": _Kind(
        ("parallel L0 L1 [L2 ...]", "parallel L0 EA0", "parallel EA0 EA1"),
        "Make lines parallel; of an ellipse the major axis counts.",
        share="first",
    ),
    "perpendicular": _Kind(
        ("perpendicular L0 L1", "perpendicular L0 EA0"),
        "Make two lines perpendicular; of an ellipse the major axis counts.",
        aliases=("perp",),
    ),
    "equal": _Kind(
        ("equal L0 L1 [L2 ...]", "equal A0 A1"),
        "Equal length of lines, or equal radius of circles and arcs.",
        aliases=("equal_length", "equal_radius"),
        share="first",
    ),
    "equal_angle": _Kind(
        ("equal_angle L0 L1 L2 L3",),
        "The angle from L0 to L1 is that from L2 to L3.",
    ),
    "collinear": _Kind(
        ("collinear L0 L1 [L2 ...]",), "Put lines on one straight line.", share="first"
    ),
    "tangent": _Kind(
        ("tangent L0 A0", "tangent A0 A1 [outside] [inside]", "tangent L0.p2 S0.p1"),
        "Make a line and an arc, two arcs, or two ends that meet, tangent.",
        keywords=("outside", "inside"),
        details="`outside` and `inside` choose how two circles touch; without them, as they lie.",
    ),
    "smooth": _Kind(("smooth S0.p2 S1.p1",), "The same curvature at two ends that meet."),
    "coincident": _Kind(("coincident L0.p2 L1.p1",), "Put two points at one place."),
    "concentric": _Kind(
        ("concentric A0 A1 [A2 ...]",), "One centre for circles, arcs, ellipses.", share="first"
    ),
    "point_on": _Kind(
        ("point_on P0 L0", "point_on L0.p1 A0", "point_on A0.center L0"),
        "Put a point on a line (also beyond its ends) or a curve.",
    ),
    "midpoint": _Kind(
        ("midpoint P0 L0", "midpoint L0.p1 A0"), "Put a point in the middle of a line or an arc."
    ),
    "symmetry": _Kind(
        (
            "symmetry P0 L0 P1",
            "symmetry L0 L1 L2",
            "symmetry A0 L0 A1",
            "symmetry P0 P1 P2",
        ),
        "Make two points, lines or arcs mirror images about a line or a point, the middle operand.",
        aliases=("symmetric",),
        details="Of arcs the centres and the radii are mirrored. About a point: P1 is the middle.",
    ),
    "on_normal": _Kind(
        ("on_normal L1.p2 L0.p2", "on_normal A1.start A0.start"),
        "Put a point on the normal of a curve at the curve's end.",
    ),
    "fix": _Kind(("fix L0 [L1 ...]",), "Hold all numbers of entities as they are.", share="each"),
}

#: Forms of constraints by their words, for deletion by what they relate.
WORDS_OF_KINDS = {
    **{kind: kind for kind in CONSTRAINTS},
    **{alias: kind for kind, one in _KINDS.items() for alias in one.aliases},
}


def _groups(kind: str, operands: Sequence[Operand]) -> list[tuple[str, ...]]:
    """Operands of each constraint that is meant."""
    handles = [one.handle for one in operands]
    share = _KINDS[kind].share
    if share == "each" and (
        kind == "fix" or all(one.entity.kind == "line" and not one.point for one in operands)
    ):
        return [(handle,) for handle in handles]
    if share == "first" and len(handles) > 2:
        return [(handles[0], other) for other in handles[1:]]
    return [tuple(handles)]


def _constrain(kind: str) -> Callable[[Session, Words], Reply]:
    def run(session: Session, words: Words) -> Reply:
        words.refuse_together("outside", "inside")
        operands = words.operands("an entity or point", whole=True)
        words.end()
        mode = next((word for word in ("outside", "inside") if word in words.flags), "")
        made = [
            session.editor.constrain(kind, args, mode=mode, force="force" in words.flags)
            for args in _groups(kind, operands)
        ]
        return _reply(session, made)

    run.__name__ = kind
    run.__doc__ = _KINDS[kind].summary
    return run


def _reply(session: Session, made: Sequence[Constraint]) -> Reply:
    return Reply(
        noticed(session, "\n".join(f"Added {constraint_line(one)}" for one in made)),
        tuple(one.name for one in made),
        remembered=False,
        data={"constraints": [one.name for one in made]},
    )


for _name, _one in _KINDS.items():
    _freedoms = sorted({form.freedoms for form in CONSTRAINTS[_name].forms})
    _takes = " or ".join(map(str, _freedoms))
    _unit = "degree" if _takes == "1" else "degrees"
    command(
        _name,
        group="constrain",
        usage=[f"{line} [force]" for line in _one.usage],
        summary=_one.summary,
        details=f"{_one.details}\n\nTakes {_takes} {_unit} of freedom.{_FORCE}"
        if _name != "fix"
        else "Takes every degree of freedom that the entities have.",
        aliases=_one.aliases,
        keywords=(*_one.keywords, "force"),
        arguments=("*operands",),
    )(_constrain(_name))


_TRIED = ("create", "modify", "constrain", "dimension", "parameters")


def inner_command(session: Session, words: Words) -> int:
    """Where the command within a dry run begins; E1252 if it is none that changes the sketch."""
    token = words.next("a command")
    found = find(token.text)
    if found is not None and found.group not in _TRIED:
        names = "commands that change the sketch are tried"
        fail("E1252", f"`{token.text}` cannot be tried", token.span, "", names)
    words.items = []
    return token.span.start


@command(
    "explain",
    group="ask",
    usage=["explain <command>"],
    summary="Say what a command would do, without doing it.",
    details="""
The command runs, is solved and judged, and is taken back; nothing is entered into the history.

```
explain perpendicular L0 L1
explain length L0 5
```
""",
    arguments=("*command",),
)
def explain(session: Session, words: Words) -> Reply:
    """Dry run."""
    start = inner_command(session, words)
    statement = words.statement
    text = statement.source.text[start : statement.end]
    with session.dry_run():
        try:
            reply: Reply = session.editor.explain(lambda: session.call(statement, start))
        except AraelError as error:
            return rejected(text, error)
    return Reply(
        f"'{text}': accepts -- {reply.text}",
        remembered=False,
        data={"accepted": True, "reply": reply.text},
    )


def rejected(text: str, error: AraelError) -> Reply:
    """The answer of a dry run that a command refuses."""
    first = error.diagnostics[0]
    more = "".join(f"; {one}" for one in (*first.notes, *first.help))
    return Reply(
        f"'{text}': rejects -- {first.message}{more}",
        remembered=False,
        data={"accepted": False, "code": first.code, "message": first.message},
    )
