"""Recipes of common shapes: each script runs as written and leaves the stated freedom.

The comment ``# N`` at the end of a line of a script states the degrees of freedom after it.
"""

from __future__ import annotations

import re

import pytest

from arael.sketch.commands.session import Session

_STATED = re.compile(r"#\s*(\d+)\s*$")

RECIPES = {
    "triangle of two lengths and an angle": """\
a = add_line 0,0 6,0
b = add_line 6,0 4,5
c = add_line 4,5 0,0            # 6
length a 6
length b 5
angle a b 65 closest            # 3
lock a.p1 0,0
horizontal a                    # 0
""",
    "equilateral triangle": """\
a = add_line 1,1 5,1
b = add_line 5,1 3,4.4
c = add_line 3,4.4 1,1
equal a b
equal b c                       # 4
length a 4                      # 3
lock a.p1 1,1                   # 1
horizontal a                    # 0
""",
    "rectangle from relative corners": """\
a = add_line 0,0 @8,0
b = add_line @0,3
c = add_line @-8,0
d = add_line @0,-3              # 8
perpendicular a b
perpendicular b c
perpendicular c d               # 5
length a 8
length b 3                      # 3
lock a.p1 0,0                   # 1
horizontal a                    # 0
""",
    "rhombus by its diagonals": """\
a = add_line -4,0 0,3
b = add_line 0,3 4,0
c = add_line 4,0 0,-3
d = add_line 0,-3 -4,0
equal a b; equal b c; equal c d
across = add_line a.p1 c.p1
up = add_line b.p1 d.p1
style across dashdot; style up dashdot
length across 8
length up 6                     # 3
""",
    "semicircle": """\
bow = add_arc -3,0 3,0 0,3      # 5
sweep bow 180                   # 4
radius bow 3                    # 3
lock bow.center 0,0             # 1
chord = add_line bow.start bow.end
style chord dashdot
horizontal chord                # 0
""",
    "slot": """\
top = add_line 0,1.5 7,1.5
low = add_line 8,-2 1,-2
right = add_arc top.p2 low.p1 9.5,0
left = add_arc low.p2 top.p1 -1.5,0
tangent top right
tangent low right
tangent top left
tangent low left
equal right left
length top 7
radius right 1.5                # 3
lock top.p1 0,1.5
horizontal top                  # 0
""",
    "hexagon with one named angle": """\
a = add_line 4,0 2,3.464
b = add_line 2,3.464 -2,3.464
c = add_line -2,3.464 -4,0
d = add_line -4,0 -2,-3.464
e = add_line -2,-3.464 2,-3.464
f = add_line 2,-3.464 4,0       # 12
equal a b; equal b c; equal c d; equal d e; equal e f
corner = angle a b 120 closest
angle b c corner closest; angle c d corner closest
length a 4                      # 3
lock a.p1 4,0                   # 1
horizontal b                    # 0
""",
    "rectangle of parameters": """\
param wide 7
param tall 2
low = add_line 0,0 7,0
right = add_line @0,2
top = add_line @-7,0
left = add_line top.p2 low.p1
lock low.p1 0,0
horizontal low
horizontal top
vertical left
vertical right
length low wide
length right tall               # 0
param wide 9                    # 0
""",
    "isosceles triangle of parameters": """\
param b 6
param h 4
base = add_line 0,0 6,0
side1 = add_line base.p2 3,4
side2 = add_line side1.p2 base.p1
lock base.p1 0,0
horizontal base
length base b
hdistance base.p1 side1.p2 b/2
vdistance base.p1 side1.p2 h    # 0
param b 8                       # 0
""",
    "rounded rectangle": """\
add_rect 0,0 8,4 hv             # 4
fillet L0 L1 0.75
fillet L1 L2 0.75
fillet L2 L3 0.75
fillet L3 L0 0.75               # 4
""",
    "beveled rectangle": """\
add_rect 0,0 8,4 hv
chamfer L0 L1 0.75              # 4
""",
    "far part of a line cut away": """\
a = add_line 0,0 9,0
b = add_line 3,-2 3,2
near, far = split a by b
delete far                      # 7
""",
}


@pytest.mark.parametrize("recipe", RECIPES)
def test_a_recipe_leaves_the_stated_freedom(recipe: str) -> None:
    session = Session()
    for line in RECIPES[recipe].splitlines():
        session.run(line)
        if stated := _STATED.search(line):
            (reply,) = session.run("dof")
            assert reply.text.split()[0] == stated[1], f"{line.strip()}: {reply.text}"


def test_elliptic_arcs_chain_by_tangents_as_in_its_manual() -> None:
    session = Session()
    session.run("add_line 0,0 5,0\nadd_earc_rtangent 10,3 0,1 0.5\nadd_earc_rtangent 15,0 1,0 0.5")
    session.run("add_line 0,9 5,9\nadd_earc_tangent @cursor @tangent 10,12 0,1")
    session.run("add_earc_tangent 20,0 0,1 30,0 0,-1 1")
    arcs = [e for e in session.document.entities.values() if e.kind == "earc"]
    assert len(arcs) == 4
    center_x, _, *_, rx, ry, _ = session.document.numbers_of(arcs[-1].name)
    assert (center_x, rx, ry) == pytest.approx((25.0, 5.0, 5.0))
