"""Texts to trees: what nodes, where, and how names, new lines and words are read."""

import subprocess
import sys
from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError, Source
from arael.syntax import tree
from arael.syntax.parser import parse, parse_expression
from arael.syntax.walk import walk
from tests.syntax.models import STANDARD, WHOLE


def expr(text: str) -> tree.Expr:
    return parse_expression(Source("formula", text))


def shape(e: tree.Expr) -> str:
    """Fully bracketed form of `e`."""
    match e:
        case tree.Number(text=text, unit=unit):
            return text if unit is None else f"{text} [{unit.text}]"
        case tree.Name(id=name):
            return name
        case tree.Binary(op=op, left=left, right=right):
            return f"({shape(left)} {op} {shape(right)})"
        case tree.Unary(op=op, operand=operand):
            return f"({op} {shape(operand)})"
        case tree.Transpose(operand=operand):
            return f"{shape(operand)}'"
        case tree.Attribute(obj=obj, name=name):
            return f"{shape(obj)}.{name}"
        case tree.Call(func=func, args=args):
            return f"{shape(func)}({', '.join(map(shape, args))})"
        case tree.Slice(low=low, high=high):
            return ":".join(shape(e) if e else "" for e in (low, high))
        case tree.Index(obj=obj, indices=indices):
            return f"{shape(obj)}[{', '.join(map(shape, indices))}]"
        case tree.ListExpr(items=items):
            return f"[{', '.join(map(shape, items))}]"
        case tree.Conditional(cond=cond, then=then, otherwise=otherwise):
            return f"if {shape(cond)} then {shape(then)} else {shape(otherwise)}"
    raise AssertionError(e)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a + b * c", "(a + (b * c))"),
        ("a - b - c", "((a - b) - c)"),
        ("a / b * c", "((a / b) * c)"),
        ("-x^2", "(- (x ^ 2))"),
        ("2^-x^y", "(2 ^ (- (x ^ y)))"),
        ("a .* b ./ c", "((a .* b) ./ c)"),
        ("2.*x", "(2 .* x)"),
        ("1./x", "(1 ./ x)"),
        ("R' * x.y'", "(R' * x.y')"),
        ("M''[0, 1]", "M''[0, 1]"),
        ("f(x).row(0)'", "f(x).row(0)'"),
        ("a[1:n - 1]", "a[1:(n - 1)]"),
        ("M[:, 2][: 3]", "M[:, 2][:3]"),
        ("2 [m] * a[2]", "(2 [m] * a[2])"),
        ("1e-3[m/s^2]'", "1e-3 [m/s^2]'"),
        ("not a and b or c", "(((not a) and b) or c)"),
        ("a < b and c >= d", "((a < b) and (c >= d))"),
        ("if a then b else if c then d else e", "if a then b else if c then d else e"),
        ("(if a then b else c) + 1", "(if a then b else c + 1)"),
        ("[a, b,]", "[a, b]"),
        ("[]", "[]"),
        ("f()", "f()"),
        ("parent.parent.x", "parent.parent.x"),
        ("- -x", "(- (- x))"),
        ("a\n", "a"),
        ("\na +\n\n b\n", "(a + b)"),
        ("key + loss.update", "(key + loss.update)"),
    ],
)
def test_precedence_and_shapes(text: str, expected: str) -> None:
    assert shape(expr(text)) == expected


def test_spans_point_at_the_text() -> None:
    source = Source("m", WHOLE)
    file = parse(source)
    for node in walk(file):
        text = node.span.text
        assert text == text.strip()
        if isinstance(node, (tree.Ident, tree.Name)):
            assert text == node.id
        if isinstance(node, tree.Number):
            assert text.split(" [")[0] == node.text
        if isinstance(node, tree.Attribute):
            assert node.name_span.text == node.name
        if isinstance(node, tree.Binary):
            assert node.left.span.start >= node.span.start
            assert node.right.span.end <= node.span.end
    pose = next(i for i in file.items if isinstance(i, tree.Struct) and i.name.id == "Pose")
    assert pose.span.text.startswith("struct Pose {")
    assert pose.span.text.endswith("}")


def test_fields_of_every_kind() -> None:
    (_, _, _, _, _, component, pose, root) = parse(Source("m", WHOLE)).items
    assert isinstance(component, tree.Struct) and isinstance(pose, tree.Struct)
    assert isinstance(root, tree.Struct)
    assert (component.kind, pose.kind, root.kind) == ("component", "struct", "root")
    assert (pose.precision, root.precision) == ("", "f32")
    fields = {m.name.id: m for m in pose.members if isinstance(m, tree.Field)}
    pos = fields["pos"]
    assert (pos.role, pos.doc) == ("param", "Where it is.\nIn metres.")
    assert isinstance(pos.type, tree.NamedType) and pos.type.unit is not None
    assert (pos.type.name, pos.type.unit.text) == ("vec3", "m")
    assert fields["a"].bounds is not None and fields["a"].bounds.low is not None
    assert fields["b"].bounds is not None and fields["b"].bounds.high is None
    assert fields["c"].bounds is not None and fields["c"].bounds.low is None
    assert fields["c"].type == tree.NamedType(span=pos.span, name="vec", dims=(4,))
    assert isinstance(fields["gps"].type, tree.OptionalType)
    assert isinstance(fields["weight"].type, tree.NamedType)
    assert fields["weight"].type.unit == tree.Unit(span=pos.span, text="rad/s/sqrt(Hz)")
    assert isinstance(fields["features"].type, tree.CollectionType)
    prev = fields["prev"].type
    assert isinstance(prev, tree.RefType) and str(prev.path) == "root.poses"
    assert fields["note"].role == "skip"
    assert fields["note"].default == tree.String(span=pos.span, value='a "b"')
    assert isinstance(fields["hc"].type, tree.BlockType) and len(fields["hc"].type.entities) == 2
    assert isinstance(fields["hbt"].type, tree.TripletsType)
    knots, pair = fields["knots"].type, fields["h01"].type
    assert isinstance(knots, tree.RefListType) and knots.count == 4
    assert str(knots.ref.path) == "root.poses" and knots.ref.target.id == "Pose"
    assert isinstance(pair, tree.BlockType)
    assert [entity.id for entity in pair.entities] == ["knots[0]", "a"]
    assert fields["loss"].type == tree.NamedType(span=pos.span, name="mat", dims=(2, 3))


def test_constraints_and_clauses() -> None:
    pose = parse(Source("m", WHOLE)).items[6]
    assert isinstance(pose, tree.Struct)
    x, y, _ = (m for m in pose.members if isinstance(m, tree.Constraint))
    assert x.doc == "Two clauses."
    assert isinstance(x.loss, tree.Lambda) and x.loss.params[0].id == "s"
    assert [str(p) for p in x.into] == ["hb", "root.hbt"]
    assert x.guard is not None and shape(x.guard) == "(gps and (not ((a < 3) or (b >= 2))))"
    assert [let.name.id for let in x.body.lets] == ["z", "y"]
    assert isinstance(x.body.result, tree.Conditional)
    assert isinstance(y.loss, tree.Call) and [str(p) for p in y.into] == ["prev.hb"]


def test_sums() -> None:
    pose = parse(Source("m", WHOLE)).items[6]
    assert isinstance(pose, tree.Struct)
    body = [m for m in pose.members if isinstance(m, tree.Constraint)][2].body
    (let,) = body.lets  # `sum` is no reserved word
    assert let.name.id == "sum" and isinstance(let.value, tree.Attribute)
    first, listed = let.value.obj, body.result
    assert isinstance(first, tree.Sum) and first.index is not None
    assert (first.index.id, first.element.id, shape(first.over)) == ("i", "k", "knots")
    assert isinstance(listed, tree.ListExpr)
    second = listed.items[1]
    assert isinstance(second, tree.Sum) and second.index is None
    assert [one.name.id for one in second.body.lets] == ["a", "out"]
    assert shape(second.body.result) == "(a + out)"


def test_passes() -> None:
    root = parse(Source("m", WHOLE)).items[7]
    assert isinstance(root, tree.Struct)
    solve = next(m for m in root.members if isinstance(m, tree.Solve))
    coarse, fine = solve.passes
    freeze, setting, free = coarse.steps
    assert isinstance(freeze, tree.Freeze) and not freeze.free
    assert [str(p) for p in freeze.paths] == ["poses.ea", "x.y"]
    assert isinstance(setting, tree.Setting) and str(setting.target) == "x"
    assert isinstance(free, tree.Freeze) and free.free
    assert [str(s.target) for s in fine.steps if isinstance(s, tree.Setting)] == ["poses.x", "y"]


def test_documentation_is_the_block_right_above() -> None:
    text = """\
# not of A

# of A
# second line
struct A {  # trailing
    x: real  # of x, not y
    y: real

    # apart

    z: real
    # of w
    w: real; v: real
}
"""
    (a,) = parse(Source("m", text)).items
    assert isinstance(a, tree.Struct)
    assert a.doc == "of A\nsecond line"
    docs = {m.name.id: m.doc for m in a.members if isinstance(m, tree.Field)}
    assert docs == {"x": "", "y": "", "z": "", "w": "of w", "v": ""}


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\n\n", "  # c\n", ";", " ; \n"])
def test_line_ends(newline: str) -> None:
    plain = parse(Source("m", "struct A {\nx: real\ny: real\n}\nstruct B { z: real }\n"))
    text = newline.join(["struct A {", "x: real", "y: real", "}", "struct B { z: real }", ""])
    assert parse(Source("m", text)) == plain


def test_words_are_names_where_they_mean_nothing() -> None:
    words = [
        "list",
        "deque",
        "arena",
        "block",
        "triplets",
        "key",
        "loss",
        "into",
        "fit",
        "pass",
        "solve",
        "marginalize",
        "skip",
        "skip_self_block",
        "freeze",
        "free",
        "symbolic",
        "compute",
        "update",
        "derivs",
    ]
    fields = "\n".join(f"    {w}: real\n    param {w}_: real\n    skip {w}: real" for w in words)
    uses = " + ".join(words)
    text = f"root R {{\n{fields}\n    constraint loss when key loss cauchy(loss) {{ {uses} }}\n"
    text += "".join(f"    constraint {w} {{ {w}.{w}({w}) }}\n" for w in words) + "}"
    parse(Source("m", text))


@pytest.mark.parametrize("path", STANDARD, ids=lambda p: p.stem)
def test_standard_models_parse(path: Path) -> None:
    file = parse(Source(path.name, path.read_text(encoding="utf-8")))
    assert any(isinstance(i, tree.Struct) and i.kind == "root" for i in file.items)


def test_a_good_model_needs_neither_lark_nor_the_messages() -> None:
    code = (
        "import sys\nfrom arael.diagnostics.records import Source\n"
        "from arael.syntax.parser import parse\nparse(Source('m', 'root R { x: real }'))\n"
        "bad = [m for m in sys.modules if m == 'lark' or m.startswith('arael.syntax.mistakes')]\n"
        "sys.exit(', '.join(bad) or None)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


@pytest.mark.parametrize("text", ["", "a b", "a; b", "let x = 1", "a +", "struct A { }", "1 = 2"])
def test_a_formula_is_one_expression(text: str) -> None:
    with pytest.raises(AraelError):
        expr(text)
