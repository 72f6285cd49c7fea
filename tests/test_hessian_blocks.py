"""Blocks of the Hessian, read from Python, against the whole Hessian and the formulas."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.loading import load
from arael.model import Model

MODEL = """
struct Lens {
    param f: real
    hb: block Lens
    constraint near { f - f.value }
}

struct Pose {
    param pos: vec2
    param h: real
    lens: Lens
    hb_pose: block Pose
    hb_lens: block (Pose, Lens)
    constraint ground into hb_lens { pos.x * lens.f }
    constraint shifted into [hb_pose, root.hbt] { 2 * pos - root.offset * h }
}

struct Landmark {
    param pos: vec2
    frines: list of Frine
}

struct Frine {
    pose: ref Pose in root.poses
    w: real = 1
    hb: block (Landmark, Pose)
    hb_root: block (Pose, Path)
    constraint bearing into [pose.hb_pose, hb] { w * (parent.pos - pose.pos) * pose.h }
    constraint moved into [pose.hb_pose, hb_root] { pose.pos.x * root.offset.y + pose.pos.y }
}

struct Pair {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    hb: block (Pose, Pose)
    constraint odometry into hb { a.pos + 3 * b.pos }
}

root Path {
    param offset: vec2 = [0.5, -0.25]
    hb: block Path
    hbt: triplets
    poses: deque of Pose
    landmarks: arena of Landmark
    pairs: list of Pair
    constraint own into hb { offset }
}
"""


def model_of(tmp_path: Path, interpret: bool = False, single: bool = False) -> Model:
    path = tmp_path / "blocks.arael"
    path.write_text(MODEL.replace("root Path {", "root Path : f32 {") if single else MODEL)
    model = load(path, interpret=interpret)()
    rng = np.random.default_rng(2)
    model.poses.extend(pos=rng.normal(size=(4, 2)), h=rng.normal(size=4), **{"lens.f": np.ones(4)})
    for k in range(3):
        landmark = model.landmarks.append(pos=rng.normal(size=2))
        for i in {k, (2 * k + 1) % 4}:
            landmark.frines.append(pose=model.poses[i], w=rng.normal())
    for a, b in ((0, 1), (3, 2), (1, 1)):
        model.pairs.append(a=model.poses[a], b=model.poses[b])
    model.poses[2].h.fixed = True
    return model


def columns(model: Model, head: str) -> list[int]:
    """Columns of the Hessian whose names begin so."""
    return [i for i, name in enumerate(model.parameter_names()) if name.startswith(head)]


def part(model: Model, a: str, b: str) -> Any:
    return model.hessian()[np.ix_(columns(model, a), columns(model, b))]


@pytest.mark.parametrize("interpret", [False, True])
def test_self_blocks(interpret: bool, tmp_path: Path) -> None:
    model = model_of(tmp_path, interpret)
    blocks = model.poses.hb_pose
    assert blocks.shape == (4, 3, 3)
    for i in (0, 1, 3):
        own = [n for n in columns(model, f"poses[{i}].")
               if ".lens." not in model.parameter_names()[n]]  # fmt: skip
        whole = model.hessian()[np.ix_(own, own)]
        np.testing.assert_allclose(blocks[i], whole, rtol=1e-12)
        np.testing.assert_allclose(model.poses[i].hb_pose, whole, rtol=1e-12)
        np.testing.assert_allclose(model.hessian_block("poses.hb_pose", i), whole, rtol=1e-12)
    np.testing.assert_allclose(model.hessian_block("poses.hb_pose"), blocks, rtol=1e-12)
    np.testing.assert_allclose(model.hb, part(model, "offset", "offset"), rtol=1e-12)
    np.testing.assert_allclose(model.hessian_block("hb"), model.hb)
    x = np.array(model.poses.pos.value)[:, 0]
    assert model.poses[1].lens.hb == pytest.approx(2.0 + 2 * x[1] ** 2)
    np.testing.assert_allclose(model.poses.lens.hb[:, 0, 0], 2 + 2 * x**2)
    assert model.poses[1].hb_lens[0] == pytest.approx(2 * x[1])


def test_what_is_held_has_zeros(tmp_path: Path) -> None:
    model = model_of(tmp_path)
    block = model.poses[2].hb_pose
    assert not block[2].any()
    assert not block[:, 2].any()
    np.testing.assert_allclose(block[:2, :2], part(model, "poses[2].pos", "poses[2].pos"))
    model.poses[0].pos.fixed = model.poses[0].h.fixed = True
    assert not model.poses[0].hb_pose.any()
    assert not model.pairs[0].hb.any()


@pytest.mark.parametrize("interpret", [False, True])
def test_cross_blocks_whatever_the_order_of_their_ends(interpret: bool, tmp_path: Path) -> None:
    model = model_of(tmp_path, interpret)
    for k, landmark in enumerate(model.landmarks):
        for frine in landmark.frines:
            i = frine.pose.row
            if i == 2:
                continue
            names = model.parameter_names()
            pose = [n for n in columns(model, f"poses[{i}].") if ".lens." not in names[n]]
            land = columns(model, f"landmarks[{k}].")
            hessian = model.hessian()
            np.testing.assert_allclose(frine.hb, hessian[np.ix_(land, pose)], rtol=1e-12)
            np.testing.assert_allclose(
                frine.hb_root, hessian[np.ix_(pose, columns(model, "offset"))], rtol=1e-12
            )
    assert model.landmarks.frines.hb.shape == (len(model.landmarks.frines.w), 2, 3)
    assert model.pairs[0].hb[0, 0] == pytest.approx(2 * 1 * 3)
    assert model.pairs[1].hb[1, 1] == pytest.approx(2 * 1 * 3)
    # Both refs meet in one pose: the block is that pose's own.
    np.testing.assert_allclose(model.pairs[2].hb, model.poses[1].hb_pose, rtol=1e-12)


def test_blocks_without_names(tmp_path: Path) -> None:
    model = model_of(tmp_path)
    a, b = model.landmarks[1], model.poses[1]
    whole = part(model, "landmarks[1].", "poses[1].")
    np.testing.assert_allclose(model.hessian_block(a, b), whole, rtol=1e-12)
    np.testing.assert_allclose(model.hessian_block(b, a), whole.T, rtol=1e-12)
    np.testing.assert_allclose(model.hessian_block(b), part(model, "poses[1].", "poses[1]."))
    np.testing.assert_allclose(
        model.hessian_block(model, b), part(model, "offset", "poses[1]."), rtol=1e-12
    )
    assert not model.hessian_block(model.landmarks[0], model.landmarks[1]).any()


def test_triplets_hold_the_pairs_that_go_there(tmp_path: Path) -> None:
    model = model_of(tmp_path)
    found = model.hbt.toarray()
    names = model.parameter_names()
    hessian = model.hessian()
    expected = np.zeros_like(hessian)
    for i, a in enumerate(names):
        for j, b in enumerate(names):
            own = a.startswith("poses") and ".lens." not in a and b.startswith("offset")
            if own:
                expected[min(i, j), max(i, j)] = hessian[i, j]
    assert expected.any()
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    np.testing.assert_allclose(model.hessian_block("hbt").toarray(), expected, rtol=1e-12)


@pytest.mark.slow
def test_single_precision(tmp_path: Path) -> None:
    single, double = model_of(tmp_path, single=True), model_of(tmp_path)
    assert single.poses.hb_pose.dtype == np.float64
    np.testing.assert_allclose(single.poses.hb_pose, double.poses.hb_pose, rtol=1e-4, atol=1e-4)


def test_unknown_blocks_and_rows_without_parameters(tmp_path: Path) -> None:
    model = model_of(tmp_path)
    with pytest.raises(AraelError, match=r"E0701.*names no block `poses.hb_pos`"):
        model.hessian_block("poses.hb_pos")
    with pytest.raises(AraelError, match=r"E1009.*`pairs` has no parameters"):
        model.hessian_block(model.pairs[0])
    with pytest.raises(AraelError, match="a row of this model"):
        model.hessian_block(model.poses, model.poses[0])
    with pytest.raises(IndexError, match=r"row 4 of `poses`, which has 4"):
        model.hessian_block("poses.hb_pose", 4)
    with pytest.raises(AttributeError, match="hb_none"):
        _ = model.poses[0].hb_none
    assert {"hb", "hbt"} <= set(dir(model))
    assert "hb_pose" in dir(model.poses[0])


def test_naming_blocks_changes_nothing(tmp_path: Path) -> None:
    named = model_of(tmp_path)
    plain = tmp_path / "plain.arael"
    lines = (tmp_path / "blocks.arael").read_text().split("\n")
    kept = [x.split(" into ")[0] + " {" + x.split("{", 1)[1] if " into " in x else x for x in lines
            if ": block" not in x and "triplets" not in x]  # fmt: skip
    plain.write_text("\n".join(kept))
    other = load(plain)()
    named.write(tmp_path / "data.npz")
    other.read(tmp_path / "data.npz")
    np.testing.assert_array_equal(other.hessian(), named.hessian())


def test_root_parameters_coupled_to_thousands_are_one_dense_column_of_the_pattern(
    tmp_path: Path,
) -> None:
    path = tmp_path / "many.arael"
    path.write_text(
        "struct P { param x: vec2; m: vec2\n"
        "    constraint c { x + root.g - m }\n    constraint d { 10 * (x - m) } }\n"
        "root R { param g: vec2 = [0, 0]; points: list of P\n    constraint own { 0.1 * g } }\n"
    )
    model = load(path)()
    n = 20_000
    m = np.random.default_rng(0).normal(size=(n, 2))
    model.points.extend(x=np.zeros((n, 2)), m=m)
    problem = model._problem()
    assert problem.structure.pattern.block_count == n + 1
    assert len(problem.structure.pattern.rows) == 2 * n + 1  # diagonals, and one row of the root
    result = model.solve()
    assert result.status == "converged"
    # Fill of the factor stays what the pattern has: the points are eliminated before the root.
    factor = np.sum((m + 0.0) ** 2)
    assert model.cost() < factor
    gradient = model.gradient()
    assert np.abs(gradient).max() < 1e-4


def test_blocks_of_a_model_with_native_functions_and_runtime_residuals(tmp_path: Path) -> None:
    path = tmp_path / "native.arael"
    path.write_text(
        "extern fn half(x) derivs [0.5]\n"
        "root R { param x: real = 2\n hb: block R\n constraint c into hb { half(x) } }",
        encoding="utf-8",
    )
    with pytest.warns(UserWarning, match="half"):
        model = load(path, interpret=True, functions={"half": lambda x: 0.5 * x})()
    assert model.hb.tolist() == [[0.5]]
    added = model.residuals.add("3 * x", label="more")
    np.testing.assert_array_equal(model.hb, model.hessian())
    assert model.hb.tolist() == [[18.5]]
    assert model.hessian_block(model).tolist() == [[18.5]]
    assert added.residuals.tolist() == [[6.0]]
