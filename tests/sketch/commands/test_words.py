"""Every word of the command language is a command, an alias, or a word of a form."""

from __future__ import annotations

import re

import pytest

from arael.sketch.commands import table
from arael.sketch.commands.session import Session

#: The vocabulary, as scripts of the reference editor use it and as it was extended.
COMMANDS = """
add_line add_rect add_rect3 add_rectcenter add_point add_circle add_circle2 add_circle3
add_circle2t add_circle3t add_arc add_ellipse add_earc add_earc3 add_earc_center add_earc_tangent
add_earc_rtangent add_spline add_slot add_polygon add_text
offset_line offset pattern mirror fillet chamfer split trim extend scale rotate move drag delete
constr quiet style lock unlock set_text
horizontal vertical parallel perpendicular collinear equal equal_angle tangent smooth coincident
concentric point_on midpoint symmetry on_normal image fix explain
length distance hdistance vdistance radius diameter radius_b sweep arc_length angle xangle
total_length area freeze set_derived set_driven dim_pos
param del_param rename_param rename
select deselect print info list measure find dof cost why free what_if sensitivity
undo redo history goto center zoom cursor msg save load export import clear help exit
"""

FORMS = {
    "add_rect": "hv driven strict noconnect noconstraint",
    "add_line": "noconnect nocursor driven quiet constr notangent",
    "add_polygon": "corner flat",
    "add_earc": "large cw",
    "add_text": "height angle noconnect nocursor quiet constr",
    "offset": "sequence selection left right flip symmetric two one inward outward round sharp pin "
    "nopin caps line none",
    "pattern": "circular rect about full partial symmetric by extent spacing along noalong one",
    "mirror": "about noconstraint strict",
    "trim": "by forward backward",
    "angle": "supplement closest acute obtuse derived driven force",
    "select": "all chain linked sequence",
    "dof": "analyze eigenvalues singular jacobian",
}


def _names() -> set[str]:
    return {word for one in table.commands().values() for word in (one.name, *one.aliases)}


@pytest.mark.parametrize("word", COMMANDS.split())
def test_every_word_is_a_command(word: str) -> None:
    assert word in _names()


@pytest.mark.parametrize("name", FORMS)
def test_every_word_of_a_form_is_in_its_usage_or_keywords(name: str) -> None:
    one = table.commands()[name]
    known = set(re.findall(r"[a-z]+", " ".join([*one.usage, one.details]))) | set(one.keywords)
    assert set(FORMS[name].split()) <= known


def test_let_assigns_like_an_equals_sign() -> None:
    session = Session()
    session.run("let n = 3; add_line 0,0 n,0")
    assert session.document.values.tolist() == [0.0, 0.0, 3.0, 0.0]
