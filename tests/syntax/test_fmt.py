"""The formatter's conventions; that it is sound on any text is in test_fuzz."""

from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError, Source
from arael.syntax.fmt import format_source
from tests.syntax.models import STANDARD, WHOLE


def fmt(text: str) -> str:
    return format_source(Source("m", text))


@pytest.mark.parametrize("path", STANDARD, ids=lambda p: p.stem)
def test_standard_models_are_formatted(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert fmt(text) == text


def test_the_whole_language_keeps_its_layout() -> None:
    assert fmt(WHOLE) == WHOLE


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("root R{x:real}", "root R { x: real }\n"),
        ("root R{\nx:real\n}\n\n\n", "root R {\n    x: real\n}\n"),
        ("struct A{x:real;y:real;}", "struct A { x: real; y: real }\n"),
        ("struct A {\nx: real; y: real }", "struct A {\n    x: real\n    y: real\n}\n"),
        ("struct A { }\nroot R : f32 { }", "struct A { }\nroot R : f32 { }\n"),
        ("struct A\n{\nx: real\n}", "struct A {\n    x: real\n}\n"),
        (
            "struct A {\n\n\nx: real\n\n\n\ny: real\n\n}",
            "struct A {\n    x: real\n\n    y: real\n}\n",
        ),
        (
            "fn f(x,y)=-x^2*( x+y )'.row( 0 )[1 ,2]",
            "fn f(x, y) = -x^2 * (x + y)'.row(0)[1, 2]\n",
        ),
        ("const a=[1,-2,not b,a-b]", "const a = [1, -2, not b, a - b]\n"),
        (
            "root R { prior  a.x~normal( 1,2 )when b loss huber( 1 ); prior: real }",
            "root R { prior a.x ~ normal(1, 2) when b loss huber(1); prior: real }\n",
        ),
        ("struct A { param  b=2*a+1 }", "struct A { param b = 2 * a + 1 }\n"),
        (
            "struct A { fixed  f.x,g; fixed: real }",
            "struct A { fixed f.x, g; fixed: real }\n",
        ),
        ("const a = b[ 0:3 ]+M[1 , : ]+M[ :,2][:]", "const a = b[0:3] + M[1, :] + M[:, 2][:]\n"),
        # `1.b` would be a malformed number
        ("const a = 1 . b + 2.5 . c . d", "const a = 1 .b + 2.5 .c.d\n"),
        ("const a = [[1,2],[ 3,4]]", "const a = [[1, 2], [3, 4]]\n"),
        ("const g=9.81[m / s^2]*( 2 [ s ] )", "const g = 9.81 [m/s^2] * (2 [s])\n"),
        ("const a = if(x)then(y)else(z)", "const a = if (x) then (y) else (z)\n"),
        ("#c\nconst a = 1 #d", "# c\nconst a = 1  # d\n"),
        (
            "struct A { k:[ref A in root.rows;4];h:block(k[0],k[ 1 ]); x: real }",
            "struct A { k: [ref A in root.rows; 4]; h: block (k[0], k[1]); x: real }\n",
        ),
        (
            "struct A {\nconstraint c{\nsum(i,k in[a,b]){k}-sum (x in y){\nlet a=1 #b\na}+1\n}\n}",
            "struct A {\n    constraint c {\n        sum(i, k in [a, b]) { k } - sum(x in y) {\n"
            "            let a = 1  # b\n            a\n        } + 1\n    }\n}\n",
        ),
        ("const a = 1\r\nconst b = 2\r\n", "const a = 1\nconst b = 2\n"),
        (
            "struct A {\nlonger: real [1/m]=1\nx: real [m]=2\ny: real=3\n}",
            "struct A {\n    longer: real [1/m] = 1\n    x:      real [m]   = 2\n"
            "    y:      real = 3\n}\n",
        ),
        (
            "root R { constraint a {\nlet a = 1\nlet long = (a +\nb)\nlong\n} }",
            "root R {\n    constraint a {\n        let a    = 1\n        let long = (a +\n"
            "                    b)\n        long\n    }\n}\n",
        ),
        (
            "root R {\nconstraint a { f(\na,\nb\n) }\n}",
            "root R {\n    constraint a {\n        f(\n            a,\n            b\n        )\n"
            "    }\n}\n",
        ),
        (
            "struct A {\np:ref A in root . ps ?\nskip q: ref A in root.ps? # c\n}",
            "struct A {\n    p:      ref A in root.ps?\n    skip q: ref A in root.ps?  # c\n}\n",
        ),
        (
            "root R { x: mat< 2 , 3 > [ rad / s ]; y: block( a,b ) }",
            "root R { x: mat<2,3> [rad/s]; y: block (a, b) }\n",
        ),
        (
            "root R { solve { pass a { x=1 y=2; z = 3 } } }",
            "root R { solve { pass a { x = 1   y = 2; z = 3 } } }\n",
        ),
    ],
)
def test_layout(before: str, after: str) -> None:
    assert fmt(before) == after
    assert fmt(after) == after


def test_comments_line_up_with_the_rightmost() -> None:
    before = "struct A {\n    x: real # a\n    longer: real   # b\n\n    y: real # c\n}\n"
    after = "struct A {\n    x:      real   # a\n    longer: real   # b\n\n    y: real  # c\n}\n"
    assert fmt(before) == after


def test_parameters_and_data_share_a_column_if_the_writer_began_so() -> None:
    apart = "struct A {\n    param pos: vec3\n    info: Info\n    x: real\n}\n"
    assert "    info: Info\n    x:    real\n" in fmt(apart)
    joined = "struct A {\n    param pos: vec3\n    info:      Info\n    x: real\n}\n"
    assert "    info:      Info\n    x:         real\n" in fmt(joined)


def test_a_broken_model_is_left_alone() -> None:
    with pytest.raises(AraelError):
        fmt("root R { x real }")
