"""Models that tests share, and strategies that make more of them."""

from __future__ import annotations

from pathlib import Path

from hypothesis import strategies as st
from hypothesis.extra.lark import from_lark
from lark import Lark

from arael.syntax import tables

STANDARD = sorted((Path(__file__).parents[2] / "models").glob("*.arael"))

# Everything the language has, in one file.
WHOLE = """\
import "geometry.arael"

# Degrees to radians.
const DEG = pi / 180
fn sigmoid(x) = 1 / (1 + exp(-x))
fn twice(x) derivs [2] = 2 * x
extern fn my_asin(x)
    derivs [1 / sqrt(identity(1 - x * x) + 1e-12)]

component UnitVec {
    param d: vec2        # the delta that the solver sees
    base:    mat3
    symbolic dir = base * unit([1, d.x, d.y])
    compute cached = base.col(0)
    update { base = recentred(base, d); d = 0 }
}

struct Pose {
    # Where it is.
    # In metres.
    param pos: vec3 [m]
    param a:   real [m] in 0 .. 10 = 4 [m]
    param b:   real in 0 ..
    param c:   vec<4> in .. -3
    param d = 2 * a + b
    gps:       GpsData?
    weight:    real [rad/s/sqrt(Hz)] = 1.0
    features:  list of PointFeature
    prev:      ref Pose in root.poses
    last:      ref Pose in root.poses?
    skip note: string = "a \\"b\\""
    hb:        block Pose
    hc:        block (a, b)
    hbt:       triplets
    loss:      mat<2,3>
    knots:     [ref Pose in root.poses; 4]
    h01:       block (knots[0], a)
    key note
    skip_self_block

    # Two clauses.
    constraint x
        when gps and not (a < 3 or b >= 2)
        loss |s| s / (1 + s)
        into [hb, root.hbt] {
        let z = a[0]^-2^x
        let y = M[0,
                  1]'' .* x
        if a < b then -c else d +
            parent.parent.e
    }
    fixed pos.x, a
    prior pos.z ~ normal(0, 1) when gps
    constraint y into prev.hb loss cauchy(2) when a != b { (x + y)' * [1, [2, true],] + a[1:3] }
    constraint s {
        let sum = sum(i, k in knots) { B[i] * k.pos }.x
        [sum, sum(x in self.features) {
            let a   = x.offset
            let out = 2 * sum(q in [prev, self]) { q.a }

            a + out
        }]
    }
}

root R : f32 {
    poses: deque of Pose
    pts:   arena of Point
    marginalize landmarks, points
    fit data as e when x > 2 loss huber(1) { a * e.x }

    solve {
        pass coarse { freeze poses.ea, x.y   x = 2   free z }
        pass fine {
            poses.x = 3
            y       = 4
        }
    }
}
"""

LARK = Lark(tables.grammar_text(), start=list(tables.STARTS), parser="lalr", lexer="basic")

_words = st.sampled_from(["a", "b2", "pos", "root_", "x", "Pose", "vec", "s"]).map(" {} ".format)


def _explicit() -> dict[str, st.SearchStrategy[str]]:
    """Tokens with blanks around them, so that neighbours do not run together."""
    known = {t.name: t for t in LARK.terminals}
    explicit = {
        name: st.just(f" {t.pattern.value} ")
        for name, t in known.items()
        if t.pattern.type == "str"
    }
    explicit["NAME"] = _words
    explicit["NUMBER"] = st.sampled_from([" 1 ", " 2.5 ", " 1e-3 "])
    explicit["STRING"] = st.sampled_from([' "a" ', ' "a\\\\b\\"c" '])
    explicit["_NEWLINE"] = st.sampled_from(["\n", "\n\n", "# c\n", "\n    # own line\n", "\r\n"])
    explicit["COMMENT"] = st.just("# d\n")
    explicit["BLANK"] = st.just(" ")
    return explicit


grammatical = from_lark(LARK, start="start", explicit=_explicit())
"""Texts that the grammar makes; some break the rules that the tree builder checks."""


@st.composite
def mutated(draw: st.DrawFn) -> str:
    """A good model with pieces deleted, doubled, swapped or replaced."""
    text = draw(st.sampled_from([WHOLE, *(p.read_text(encoding="utf-8") for p in STANDARD)]))
    for _ in range(draw(st.integers(1, 5))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 12)))
        piece = draw(
            st.one_of(
                st.sampled_from(
                    [
                        *"{}()[]<>|'\"#;:,.=+-*/^?\n\t\r\0!&@$\\é\u202e",
                        *("let ", "struct ", "constraint ", "param ", "if ", "then ", "root "),
                        *("pass ", "fn ", "..", "1e", "::"),
                    ]
                ),
                st.just(text[start:end] * 2),
                st.text(max_size=5),
                st.just(""),
            )
        )  # fmt: skip
        text = text[:start] + piece + text[end:]
    return text
