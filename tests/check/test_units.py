"""Units form a group, and the rules of operations are those of dimensional analysis."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arael.check.units import DEG, ONE, RAD, Unit, interchangeable
from arael.check.units_parsing import BadUnit, parse_unit
from arael.check.units_quantities import NUMBER, UNKNOWN, Clash, Scalar, joined, power, times
from arael.check.units_table import known_names, powers_of
from tests.check.models import MODELS, codes, diagnostics, standard

NAMES = sorted({*known_names(), "mm", "km", "kHz", "mrad"})
POWERS = st.fractions(-3, 3, max_denominator=4)
UNITS = st.lists(st.tuples(st.sampled_from(NAMES), POWERS), max_size=4).map(Unit)
SCALARS: st.SearchStrategy[Scalar] = st.one_of(UNITS, st.sampled_from([NUMBER, UNKNOWN]))


@given(UNITS, UNITS, UNITS)
def test_products_are_associative_and_commutative(a: Unit, b: Unit, c: Unit) -> None:
    assert (a * b) * c == a * (b * c)
    assert a * b == b * a
    assert hash(a * b) == hash(b * a)


@given(UNITS)
def test_one_is_neutral_and_every_unit_has_an_inverse(a: Unit) -> None:
    assert a * ONE == a == ONE * a
    assert (a / a).is_one
    assert str(a / a) == "1"
    assert a * (ONE / a) == ONE


@given(UNITS, UNITS, POWERS, POWERS)
def test_powers(a: Unit, b: Unit, p: Fraction, q: Fraction) -> None:
    assert (a * b) ** p == a**p * b**p
    assert a ** (p + q) == a**p * a**q
    assert (a**p) ** q == a ** (p * q)
    assert a**0 == ONE


@given(st.lists(st.tuples(st.sampled_from(NAMES), st.integers(-4, 4)), max_size=4))
def test_the_text_of_a_unit_means_that_unit(factors: list[tuple[str, int]]) -> None:
    unit = Unit((name, Fraction(p)) for name, p in factors)
    assert parse_unit(str(unit)) == unit


@given(SCALARS, SCALARS, SCALARS)
def test_products_with_open_units(a: Scalar, b: Scalar, c: Scalar) -> None:
    assert times(a, b) == times(b, a)
    assert times(times(a, b), c) == times(a, times(b, c))
    assert times(a, NUMBER) == a


@given(SCALARS, SCALARS)
def test_a_sum_has_the_unit_that_is_known(a: Scalar, b: Scalar) -> None:
    try:
        both = joined(a, b)
    except Clash:
        assert isinstance(a, Unit) and isinstance(b, Unit) and a != b
        with pytest.raises(Clash):
            joined(b, a)
        return
    assert joined(b, a) == both
    assert joined(both, a) == both
    assert joined(a, NUMBER) == a
    known = [x for x in (a, b) if isinstance(x, Unit)]
    assert isinstance(both, Unit) == bool(known)


@given(UNITS)
def test_the_square_of_a_root(a: Unit) -> None:
    assert power(power(a, Fraction(1, 2)), 2) == a


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("N", "kg*m/s^2"),
        ("J", "N*m"),
        ("W", "J/s"),
        ("V", "W/A"),
        ("T", "Wb/m^2"),
        ("kN", "1/(mm/J)"),
        ("m/s^2", "m/(s*s)"),
        ("rad/(s*sqrt(Hz))", "rad*s^-0.5"),
        ("rpm", "rev/min"),
        ("gon^10", "deg^10*(gon/deg)^10"),
        ("l", "dm^3"),
    ],
)
def test_equal_units(one: str, other: str) -> None:
    assert parse_unit(one) == parse_unit(other)


@pytest.mark.parametrize(
    ("one", "other"), [("m", "mm"), ("rad", "deg"), ("Hz", "rad/s"), ("1", "rad"), ("s", "min")]
)
def test_different_units(one: str, other: str) -> None:
    assert parse_unit(one) != parse_unit(other)


def test_radians_beside_another_unit_count_as_a_number() -> None:
    assert interchangeable(parse_unit("rad*m/s"), parse_unit("m/s"))
    assert not interchangeable(parse_unit("rad*mm/s"), parse_unit("m/s"))
    assert not interchangeable(RAD, ONE)
    assert not interchangeable(RAD, DEG)
    assert not interchangeable(parse_unit("rad*mm/m"), parse_unit("mm/m"))


@pytest.mark.parametrize("text", ["metrs", "2*m", "m^99", "m^(1/0)", "(" * 50 + "m" + ")" * 50])
def test_what_is_no_unit(text: str) -> None:
    with pytest.raises(BadUnit):
        parse_unit(text)


@pytest.mark.parametrize("name", ["", "1", "xm", "mxyz", "mkg", "mm2", "kmin", "__class__"])
def test_unknown_names(name: str) -> None:
    assert powers_of(name) is None


@pytest.mark.parametrize(
    "name", ["slam", "localization", "linear", "pose_graph_2d", "pose_graph_3d"]
)
def test_the_standard_models_fit_and_are_checked(name: str) -> None:
    model = standard(name)
    assert any(c.unit for t in model.tables for c in t.columns)
    text = (MODELS / f"{name}.arael").read_text()
    assert codes(text) == []


def body(residual: str) -> list[str]:
    """Codes that `residual` gets, in a model where each letter has the unit of its name."""
    model = f"""
fn twice(x) = x + x
fn wave(x) = sin(x)
root R {{
    param m: real [m]
    param kg: real [kg]
    param rad: real [rad]
    param deg: real [deg]
    param mm: real [mm]
    param s: real [s]
    param one: real [1]
    param free: real
    param mv: vec3 [m]
    param radv: vec3 [rad]
    param ea: euler
    param q: quaternion
    param T: transform [m]
    rot: mat3 [1]
    m2: mat3 [m^2]
    freem: mat3
    n: int [px]
    constraint c {{
        {residual}
    }}
}}
"""
    return [d.code for d in diagnostics(model) if d.code != "W0601"]


@pytest.mark.parametrize(
    "residual",
    [
        "m / m",
        "twice(m) / m",
        "wave(rad)",
        "wave(free)",
        "wave(one)",
        "sin(deg2rad(deg))",
        "if m + 1 - 2 < 3 and free > 0 and 1 < m then 1 * one else one",
        "(m + free) / m",
        "(free + m) / m",
        "[mv, radv].x / m",
        "[mv, radv][4] / rad",
        "[mv, radv] .* [mv, radv] ./ [mv .* mv, radv .* radv]",
        "dot([m, rad], [1 / m, 1 / rad])",
        "(rot * mv).x / m",
        "rot' * mv / norm(mv)",
        "m2.inverse() * mv * m",
        "m2 * mv / m^3",
        "sqrt(m^2) / m",
        "m^0.5 * m^(1/2) / m",
        "cbrt(m^3) / m",
        "pow(m, 2) / m2[0, 0]",
        "m2.det() / m^6",
        "m2.trace() / m^2",
        "norm2(mv) / m^2",
        "unit(mv)",
        "atan2(m, m) / rad",
        "hypot(m, m) / m",
        "min(m, m, 3) / m",
        "clamp(m, 0, 1) / m",
        "exp(m / m)",
        "exp(free)",
        "log(m / m)",
        "(ea - radv) / rad",
        "(ea.x - rad) / rad",
        "ea.rotation_matrix() * mv / m",
        "rotation_matrix(radv) * mv / m",
        "euler_angles(rot) / rad",
        "rotation_vector(rot) / rad",
        "q.log() / rad",
        "(T * mv - mv) / m",
        "(T.inverse() * mv - mv) / m",
        "((T * T).inverse() * mv - mv) / m",
        "T.rotation_matrix() * mv / m",
        "T.log() ./ [m, m, m, rad, rad, rad]",
        "q.vec",
        "q.rotate(mv) / m",
        "(cross(radv / s, mv) - mv / s) / (m / s)",
        "skew(mv) * radv / (m * rad)",
        "(mv - mv.value) / m",
        "starship(m / m, one)",
        "starship(m / m, 3)",
        "starship(m, 2 * m) / m",
        "sign(m) * one",
        "floor(m) / m",
        "abs(m) / m",
        "n / n * one",
        "rad_diff(rad, ea.z) / rad",
        "rad2deg(rad) / deg",
        "freem * [m, rad, 1]",
        "(identity3 * mv) / m",
        "(if m > 0 then m else 2) / m",
    ],
)
def test_what_fits(residual: str) -> None:
    assert body(residual) == []


@pytest.mark.parametrize(
    ("residual", "code"),
    [
        ("(m + rad) / m", "E0321"),
        ("(m - mm) / m", "E0321"),
        ("(rad - deg) / rad", "E0321"),
        ("(m - one) / m", "E0321"),
        ("(mv - radv) / m", "E0321"),
        ("(mv.x - ea.x) / m", "E0321"),
        ("([m, rad] + [rad, m]).x / m", "E0321"),
        ("(rot * mv - radv) / m", "E0321"),
        ("rot * [m, rad, m] / m", "E0321"),
        ("norm([m, rad]) / m", "E0321"),
        ("twice(m) + rad", "E0321"),
        ("atan2(m, rad) / rad", "E0321"),
        ("hypot(m, kg) / m", "E0321"),
        ("min(m, kg) / m", "E0321"),
        ("clamp(m, 0, kg) / m", "E0321"),
        ("if m < rad then one else one", "E0321"),
        ("(if one > 0 then m else rad) / m", "E0321"),
        ("(atan2(m, m) - m) / m", "E0321"),
        ("sin(rad) - m", "E0321"),
        ("starship(m, one) / m", "E0321"),
        ("(m2.inverse() * mv - mv) / m", "E0321"),
        ("(T * mv - radv) / m", "E0321"),
        ("T * radv / m", "E0321"),
        ("(T.rotation_matrix() * mv - radv) / m", "E0321"),
        ("T * mv", "W0301"),
        ("sin(m)", "E0322"),
        ("sin(deg)", "E0322"),
        ("wave(m)", "E0322"),
        ("exp(m)", "E0322"),
        ("log(m)", "E0322"),
        ("asin(rad)", "E0322"),
        ("one ^ m", "E0322"),
        ("m ^ free", "E0322"),
        ("deg2rad(rad) / rad", "E0322"),
        ("rad2deg(deg) / deg", "E0322"),
        ("rotation_matrix(mv).col(0)", "E0322"),
        ("rad_diff(rad, deg) / rad", "E0322"),
        ("euler_angles(m2) / rad", "E0322"),
        ("m", "W0301"),
        ("mv - mv.value", "W0301"),
        ("rad - ea.x", "W0301"),
        ("[m / m, rad]", "W0301"),
        ("m / mm", "W0301"),
        ("[m, rad] * one", "W0301"),
        ("n * one", "W0301"),
    ],
)
def test_what_does_not(residual: str, code: str) -> None:
    assert code in body(residual)


def test_a_model_without_units_is_not_held_to_radians() -> None:
    assert (
        codes("""
root R {
    param ea: euler
    param x: real
    constraint c { [ea - [x, x, x], exp(ea.x), atan2(x, x) + cos(x), ea.y * sin(ea.y) + ea.z] }
}
""")
        == []
    )


def test_constants_keep_the_unit_of_their_formula() -> None:
    text = """
const STEP = deg2rad(5)
root R {{
    param x: real [m]
    isigma: real [1/m] = 1
    constraint c {{ (x - {0}) * isigma }}
}}
"""
    assert codes(text.format("STEP")) == ["E0321"]
    assert codes(text.format("-STEP")) == ["E0321"]
    assert codes(text.format("2")) == []


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("w: real [m] = deg2rad(3)", ["E0323"]),
        ("w: real [rad] = deg2rad(3)", []),
        ("w: real [1/rad] = 1 / deg2rad(3)", []),
        ("w: real [deg] = rad2deg(1)", []),
        ("w: real [deg] = deg2rad(1)", ["E0323"]),
        ("w: vec2 [m] = [1, deg2rad(1)]", ["E0323"]),
        ("w: real = deg2rad(3)", []),
        ("w: quat [m]", ["E0323"]),
        ("w: quat [1]", []),
        ("w: bool [m]", ["E0323"]),
        ("w: string [m]", ["E0323"]),
        ("param w: real [m] in 0 .. deg2rad(9)", ["E0323"]),
        ("param w: angle [deg]", ["E0323"]),
        ("param w: euler [rad]", []),
        ("param w: rotation [m]", ["E0323"]),
        ("w: real [2*m]", ["E0320"]),
        ("w: real [m] = 2 [m]", []),
        ("w: real [m] = -2 [m]", []),
        ("w: real [m/s] = 6 [m] / 2 [s]", []),
        ("w: real [m] = 2 [mm]", ["E0323"]),
        ("w: real [rad] = 2 [deg]", ["E0323"]),
        ("w: real [rad] = deg2rad(2 [deg])", []),
        ("w: real [m] = 2 [metrs]", ["E0320"]),
        ("w: real = 2 [m]", []),
        ("w: vec2 [m] = [1 [m], 2]", []),
        ("w: vec2 [m] = [1 [m], 2 [s]]", ["E0323"]),
        ("param w: real [m] in 0 [m] .. 9 [mm]", ["E0323"]),
        ("param w: real [m] in 0 [m] .. 9 [m] = 1 [m]", []),
    ],
)
def test_declarations(line: str, found: list[str]) -> None:
    model = f"root R {{\n    param x: real\n    {line}\n    constraint c {{ x }}\n}}\n"
    assert [c for c in codes(model) if c != "W0601"] == found


def test_literals_have_units_in_formulas_and_constants() -> None:
    text = """
const G = 9.81 [m/s^2]
const START = [1 [m], 2 [m]]
root R {{
    param x: vec2 [m]
    t: real [s]
    constraint c {{ {0} }}
}}
"""
    assert codes(text.format("(x - START) / 1e-3 [m]")) == []
    assert codes(text.format("(x.x - G * t^2) / 1e-3 [m]")) == []
    assert codes(text.format("(x.x - G * t) / 1e-3 [m]")) == ["E0321"]
    assert codes(text.format("(x - START * t) / 1e-3 [m]")) == ["E0321"]
    assert codes(text.format("x[1 [m]] / 1 [m]")) == ["E0305"]
    assert codes(text.format("sin(3 [m]) + x.x / 1 [m]")) == ["E0322"]


def test_a_literal_in_another_unit_is_not_converted() -> None:
    text = "root R { param x: real [m] = 5 [mm]; constraint c { x / 1 [m] } }"
    (error,) = diagnostics(text)
    assert error.help == ("units are not converted: write `0.005 [m]`",)


def test_passes_set_values_in_the_unit_of_the_field() -> None:
    text = """
root R {{
    param x: real [rad]
    isigma: real [1/rad] = 1
    constraint c {{ x * isigma }}
    solve {{ pass a {{ isigma = {0} }} }}
}}
"""
    assert codes(text.format("10.0")) == []
    assert codes(text.format("1 / deg2rad(2)")) == []
    assert codes(text.format("deg2rad(2)")) == ["E0323"]


@pytest.mark.parametrize(
    ("text", "factor"), [("mm", 1e-3), ("m", 1), ("h/s", 3600), ("mm^0.5", 1e-3**0.5)]
)
def test_factor(text: str, factor: float) -> None:
    assert parse_unit(text).factor == pytest.approx(factor)
