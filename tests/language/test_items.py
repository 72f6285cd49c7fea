"""The language page on `import`, `const` and default values, sentence by sentence."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import arael
from tests.language.models import loaded, refusal

ROOT = "root R { param a: real = 0; constraint c { a - GOAL } }"


# --- import ---------------------------------------------------------------------------------------


def test_names_of_an_imported_file_become_visible(tmp_path: Path) -> None:
    """Structs, constants and functions alike, and a constraint of an imported struct acts."""
    model = loaded(
        tmp_path,
        'import "parts.arael"\n'
        "root R { marks: list of Mark; param a: real = 0; constraint d { a - half(K) } }",
        parts="const K = 3\nfn half(x) = x / 2\n"
        "struct Mark { param x: real; constraint c { x - K } }",
    )(marks=[{"x": 0}])
    model.solve()
    assert (model.marks[0].x.value, model.a.value) == pytest.approx((3, 1.5))


def test_a_diamond_counts_once(tmp_path: Path) -> None:
    model = loaded(
        tmp_path,
        'import "left.arael"\nimport "right.arael"\n' + ROOT,
        left='import "base.arael"\nconst L = B',
        right='import "base.arael"\nconst GOAL = B + L',
        base="const B = 2",
    )()
    model.solve()
    assert model.a.value == pytest.approx(4)


def test_names_of_an_importing_file_are_visible_to_what_it_imports(tmp_path: Path) -> None:
    """All files of a model share one set of names, whatever the order."""
    model = loaded(tmp_path, 'import "f.arael"\nconst B = 5\n' + ROOT, f="const GOAL = 2 * B")()
    model.solve()
    assert model.a.value == pytest.approx(10)


@pytest.mark.parametrize(
    ("files", "circle"),
    [
        ({"one": 'import "model.arael"'}, "model.arael -> one.arael -> model.arael"),
        (
            {"one": 'import "two.arael"', "two": 'import "one.arael"'},
            "one.arael -> two.arael -> one.arael",
        ),
        ({"one": 'import "one.arael"'}, "one.arael -> one.arael"),
    ],
)
def test_a_circle_is_told_with_its_files(
    tmp_path: Path, files: dict[str, str], circle: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = refusal(tmp_path, 'import "one.arael"\nconst GOAL = 1\n' + ROOT, **files)
    assert found.code == "E0212"
    assert found.message.replace(f"{tmp_path}/", "").endswith(circle)


def test_an_import_binds_no_native_code(tmp_path: Path) -> None:
    made = loaded(
        tmp_path, 'import "n.arael"\nconst GOAL = 1\n' + ROOT, n="extern fn f(x) derivs [1]"
    )
    assert not made.functions["f"].bound


# --- const ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("const GOAL = pi / 180", math.pi / 180),
        ("const GOAL = 2 * LATER\nconst LATER = 3", 6),
        ("fn f(x) = x ^ 2\nconst GOAL = f(3) + 1", 10),
        ("const V = [1, 2, 3]\nconst GOAL = V[1] * V[2]", 6),
        ("const GOAL = if 2 > 1 then 5 else 6", 5),
        ("const GOAL = starship_gamma(25)", 10 / math.pi),
    ],
)
def test_values_of_constants(tmp_path: Path, text: str, value: float) -> None:
    model = loaded(tmp_path, f"{text}\n{ROOT}")()
    assert model.cost() == pytest.approx(value**2, rel=1e-14)


@pytest.mark.parametrize(
    "text",
    [
        "norm(V)", "norm2(V)", "dot(V, M * V)", "cross(V, [1, 0, 3])[1]", "unit(V).z", "det(M)",
        "trace(M)", "(M * M')[0, 1]", "M.inverse()[1, 0]", "(M' * V).x", "dot([1, 2], [3, 4])",
        "norm(2 * V - [1, 0, 0])", "skew(V)[0, 1]", "(V * 2 .* V).y",
    ],
)  # fmt: skip
def test_constants_of_vectors_and_matrices(tmp_path: Path, text: str) -> None:
    """As a constant, and the same formula of data in a constraint, which is compiled."""
    data = text.replace("V", "root.v").replace("M", "(2 * identity3() + skew(root.v))")
    model = loaded(
        tmp_path,
        f"const V = [1, 2, -4]\nconst M = 2 * identity3() + skew(V)\nconst GOAL = {text}\n"
        "root R { v: vec3 = [1, 2, -4]; param a: real = 0\n"
        f"constraint c {{ a - GOAL }}\nconstraint d {{ a - ({data}) }} }}",
    )()
    by_constant, by_formula = model.jacobian().residuals
    assert by_constant == pytest.approx(by_formula, rel=1e-12)
    assert abs(by_constant) > 1e-3


def test_a_singular_matrix_has_no_constant_inverse(tmp_path: Path) -> None:
    text = "const GOAL = skew([1, 2, 3]).inverse()[0, 0]\n" + ROOT
    assert refusal(tmp_path, text).code == "E0309"


def test_a_constant_is_visible_everywhere(tmp_path: Path) -> None:
    """In defaults, bounds, guards, losses, functions, passes, and other constants."""
    text = """
    const N = 2
    const HALF = N / 4
    fn f(x) = HALF * x
    struct P { x: real = N; constraint c when x > HALF loss huber(N) { f(root.a) - x } }
    root R {
        param a: real in 0 .. N + 1 = HALF
        gain: real = 0
        ps: list of P
        solve { pass one { gain = N * HALF; max_iters = 10 * N } }
    }
    """
    made = loaded(tmp_path, text)
    model = made(ps=[{}, {"x": 0.25}])
    assert (model.a.value, model.ps.x.tolist()) == (0.5, [2.0, 0.25])
    assert model.cost() == pytest.approx((0.25 - 2) ** 2)
    assert made.layout.passes[0].config == {"max_iters": 20}
    model.solve()
    assert model.gain == 1
    assert model.a.value == pytest.approx(3, abs=1e-6), "at the bound"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("const GOAL = LATER\nconst LATER = GOAL", "E0213"),
        ("const GOAL = GOAL", "E0213"),
        ("const GOAL = 1 / 0", "E0309"),
        ("const GOAL = a", "E0201"),
        ("const GOAL = 1\nconst GOAL = 2", "E0206"),
        ("const GOAL = 1\nfn GOAL(x) = x", "E0206"),
        ("const pi = 3\nconst GOAL = 1", "E0208"),
    ],
)
def test_what_is_no_constant(tmp_path: Path, text: str, code: str) -> None:
    assert refusal(tmp_path, f"{text}\n{ROOT}").code == code


# --- default values -------------------------------------------------------------------------------

DEFAULTS = """
const S = 2
struct Info { w: real = S; v: vec2 = [1, S] }
struct Pose {
    param pos: vec3 = [1, 2, 3]
    param ea: euler = [0, 0, 0.5]
    param q: quaternion = [1, 0, 0, 0]
    n: int = 4
    on: bool = true
    name: string = "none"
    m: mat2 = [[1, 2], [3, 4]]
    info: Info
    must: real
    constraint c when on { [pos * info.w, ea, pos.x * (q.w + n)] }
}
root R { poses: list of Pose; gain: real = S ^ 2 }
"""


def test_a_default_stands_where_the_data_leaves_a_field_out(tmp_path: Path) -> None:
    made = loaded(tmp_path, DEFAULTS)
    model = made()
    pose = model.poses.append(must=1)
    other = model.poses.append(must=2, n=5, pos=[0, 0, 0], info={"w": 7})
    assert model.gain == 4
    np.testing.assert_array_equal(pose.pos.value, [1, 2, 3])
    np.testing.assert_array_equal(pose.ea.value, [0, 0, 0.5])
    np.testing.assert_array_equal(pose.q.value, [1, 0, 0, 0])
    assert (pose.n, pose.on, pose.name, pose.info.w) == (4, True, "none", 2)
    np.testing.assert_array_equal(pose.m, [[1, 2], [3, 4]])
    assert (other.n, other.info.w) == (5, 7)
    np.testing.assert_array_equal(other.info.v, [1, 2])
    data = tmp_path / "data.json"
    data.write_text('{"poses": [{"must": 3, "info": {}}]}')
    model.read(data)
    assert (len(model.poses), model.poses[0].info.w, model.poses[0].must) == (1, 2, 3)


def test_what_has_no_default_must_be_given(tmp_path: Path) -> None:
    model = loaded(tmp_path, DEFAULTS)()
    with pytest.raises(arael.AraelError) as caught:
        model.poses.append(n=2)
    assert caught.value.diagnostics[0].code == "E0702"
    assert "must" in caught.value.diagnostics[0].message


@pytest.mark.parametrize(
    ("field", "code"),
    [
        ("x: real = [1, 2]", "E0310"),
        ("x: vec2 = 1", "E0310"),
        ("x: int = 0.5", "E0310"),
        ("x: bool = 1", "E0310"),
        ("x: string = 1", "E0310"),
        ("x: real = y", "E0201"),
        ("x: real = 1 / 0", "E0309"),
        ("param x: real in 0 .. 1 = 2", "E0310"),
    ],
)
def test_a_default_that_does_not_fit(tmp_path: Path, field: str, code: str) -> None:
    text = f"root R {{ {field}; y: real = 1; param a: real; constraint c {{ a - y }} }}"
    assert refusal(tmp_path, text).code == code
