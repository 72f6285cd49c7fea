"""g2o in and out: known start costs of public graphs, chains, and every mistake by file and line."""
# ruff: noqa: E501 - a case, or a column, is one line

from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from arael import io
from arael.diagnostics.records import AraelError
from arael.runtime.store import Store, rotations
from tests.hand_layouts import pose_graph, slam
from tests.public_data import public


def wrap(angle: np.ndarray) -> np.ndarray:
    return (angle + np.pi) % (2 * np.pi) - np.pi


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    w = a[:, 0] * b[:, 0] - (a[:, 1:] * b[:, 1:]).sum(axis=1)
    v = a[:, :1] * b[:, 1:] + b[:, :1] * a[:, 1:] + np.cross(a[:, 1:], b[:, 1:])
    return np.column_stack([w, v])


CONJ = np.array([1.0, -1, -1, -1])


def cost(store: Store) -> float:
    """Sum of squared residuals by the formulas of the standard models, in plain NumPy."""
    poses, edges, anchors = (store.tables[n] for n in ("poses", "edges", "anchors"))
    a, b, p = edges.target_rows("a"), edges.target_rows("b"), anchors.target_rows("pose")
    t = poses.column("t")
    if "th" in poses.data:
        th = poses.column("th")
        tm, thm = edges.column("t"), edges.column("th")

        def rot(angle: np.ndarray, v: np.ndarray) -> np.ndarray:
            c, s = np.cos(angle), np.sin(angle)
            return np.column_stack([c * v[:, 0] + s * v[:, 1], -s * v[:, 0] + c * v[:, 1]])

        error = np.column_stack([rot(thm, rot(th[a], t[b] - t[a]) - tm), wrap(th[b] - th[a] - thm)])
        prior = np.column_stack([t[p] - anchors.column("t"), wrap(th[p] - anchors.column("th"))])
    else:
        q = poses.column("q")
        ra = rotations.matrix_from_quaternion(q[a])
        dq = product(edges.column("q") * CONJ, product(q[a] * CONJ, q[b]))
        sign = np.where(dq[:, :1] < 0, -2.0, 2.0)
        dt = np.einsum("nji,nj->ni", ra, t[b] - t[a]) - edges.column("t")
        error = np.column_stack([dt, sign * dq[:, 1:]])
        dp = product(anchors.column("q") * CONJ, q[p])
        prior = np.column_stack([t[p] - anchors.column("t"), 2 * dp[:, 1:]])
    whitened = np.einsum("nij,nj->ni", edges.column("u"), error)
    return float((whitened**2).sum() + (prior**2).sum())


def load(n: int, path: Path) -> Store:
    store = Store(pose_graph(n))
    io.read(store, path)
    return store


@pytest.mark.parametrize(
    ("n", "name", "start"),
    [
        (2, "M3500", 2.5667e6),
        (2, "intel", 551.736),
        (2, "kitti_00", 538621),  # no vertices: from the spanning tree
        (2, "ringCity", 6.129e7),
        (3, "tinyGrid3D", 256.329),
        (3, "smallGrid3D", 120560),
        (3, "parking-garage", 16725.4),
        (3, "sphere2500", 2.5846e6),
        (3, "sphere_slambook", 9.54e9),
    ],
)
def test_public_graphs_have_their_known_start_cost_also_after_writing(
    tmp_path: Path, n: int, name: str, start: float
) -> None:
    store = load(n, public(f"pose_graph_{n}d/{name}.g2o"))
    found = cost(store)
    digits = len(f"{start:.6g}".replace(".", "").rstrip("0")) if start < 1e6 else 4
    assert found == pytest.approx(start, rel=0.6 * 10.0 ** (1 - digits))
    io.write(store, tmp_path / "out.g2o")
    again = load(n, tmp_path / "out.g2o")
    assert cost(again) == pytest.approx(found, rel=1e-9)


VERTICES2 = "VERTEX_SE2 7 0 0 0\nVERTEX_SE2 3 1 0 0.5\n"
EDGE2 = "EDGE_SE2 7 3 1 0 0.5 2 0 0 2 0 4\n"


def test_ids_order_and_information(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text("# a comment\n" + VERTICES2 + "EDGE_SE2 7 3 1 0 0.5 4 1 0.5 5 0.25 6\r\n\n")
    store = load(2, path)
    assert store.tables["poses"].column("id").tolist() == [7, 3]
    assert store.tables["edges"].target_rows("a").tolist() == [0]
    u = store.tables["edges"].column("u")[0]
    assert np.allclose(u.T @ u, [[4, 1, 0.5], [1, 5, 0.25], [0.5, 0.25, 6]])
    assert np.array_equal(u, np.triu(u))
    io.write(store, tmp_path / "b.g2o")
    lines = (tmp_path / "b.g2o").read_text().splitlines()
    assert lines[:2] == ["VERTEX_SE2 7 0.0 0.0 0.0", "VERTEX_SE2 3 1.0 0.0 0.5"]


def test_toro_tags_have_their_own_order_of_the_information(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 4 1 5 6 0.5 0.25\n")
    u = load(2, path).tables["edges"].column("u")[0]
    assert np.allclose(u.T @ u, [[4, 1, 0.5], [1, 5, 0.25], [0.5, 0.25, 6]])


def test_fix_takes_the_place_of_the_held_pose_and_is_written(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text(VERTICES2 + EDGE2 + "FIX 3\n")
    store = load(2, path)
    poses = store.tables["poses"]
    assert poses.fixed("t").tolist() == [False, True] == poses.fixed("th").tolist()
    assert not poses.column("held").any()
    assert store.tables["anchors"].size == 0
    io.write(store, tmp_path / "b.g2o")
    assert "FIX 3" in (tmp_path / "b.g2o").read_text().splitlines()
    poses.fixed("t")[:] = False
    with pytest.raises(AraelError, match="whole poses"):
        io.write(store, tmp_path / "b.g2o")


COMPONENTS = """\
VERTEX_SE2 8 0.0 0.0 0.0
VERTEX_SE2 1 5.0 0.0 0.5
VERTEX_SE2 2 9.0 0.0 0.0
VERTEX_SE2 3 1.0 0.0 0.5
VERTEX_SE2 4 5.0 1.0 0.5
VERTEX_SE2 5 9.0 1.0 0.0
VERTEX_SE2 6 7.0 7.0 0.0
VERTEX_SE2 7 8.0 7.0 0.0
VERTEX_SE2 0 2.0 0.0 0.5
FIX 4
EDGE_PRIOR_SE2 5 9.0 1.0 0.0 1.0 0.0 0.0 1.0 0.0 1.0
EDGE_SE2 3 8 1.0 0.0 0.5 4.0 0.0 0.0 4.0 0.0 4.0
EDGE_SE2 0 3 1.0 0.0 0.5 4.0 0.0 0.0 4.0 0.0 4.0
EDGE_SE2 1 4 1.0 0.0 0.5 4.0 0.0 0.0 4.0 0.0 4.0
EDGE_SE2 2 5 1.0 0.0 0.5 4.0 0.0 0.0 4.0 0.0 4.0
EDGE_SE2 7 6 1.0 0.0 0.5 4.0 0.0 0.0 4.0 0.0 4.0
"""
"""Components {8, 3, 0}, {1, 4} with a FIX, {2, 5} with a prior, {6, 7}."""


def test_the_first_pose_of_each_component_that_nothing_holds_is_fixed(tmp_path: Path) -> None:
    (tmp_path / "a.g2o").write_text(COMPONENTS)
    store = load(2, tmp_path / "a.g2o")
    poses = store.tables["poses"]
    ids = poses.column("id")
    assert ids[poses.column("held")].tolist() == [8, 6]
    for path in ("t", "th"):
        assert ids[poses.fixed(path)].tolist() == [8, 4, 6]
    assert ids[store.tables["anchors"].target_rows("pose")].tolist() == [5]


def test_a_graph_written_again_is_the_same_file(tmp_path: Path) -> None:
    """Also by way of JSON and NPZ: FIX stands where the file had it, and nowhere else."""
    (tmp_path / "a.g2o").write_text(COMPONENTS)
    store = load(2, tmp_path / "a.g2o")
    for way in ("b.json", "b.npz"):
        io.write(store, tmp_path / way)
        again = load(2, tmp_path / way)
        assert again.tables["poses"].fixed("t").sum() == 3
        io.write(again, tmp_path / "c.g2o")
        assert (tmp_path / "c.g2o").read_text() == COMPONENTS


def test_a_model_without_held_keeps_the_gauge_as_fix(tmp_path: Path) -> None:
    layout = pose_graph(2)
    tables = tuple(
        replace(t, columns=tuple(c for c in t.columns if c.path != "held")) for t in layout.tables
    )
    store = Store(replace(layout, tables=tables))
    (tmp_path / "a.g2o").write_text(VERTICES2 + EDGE2)
    io.read(store, tmp_path / "a.g2o")
    io.write(store, tmp_path / "b.g2o")
    assert "FIX 7" in (tmp_path / "b.g2o").read_text().splitlines()


@pytest.mark.parametrize("n", [2, 3])
def test_anchors_are_written_as_priors(tmp_path: Path, n: int) -> None:
    store = load(n, public(f"pose_graph_{n}d/{'intel' if n == 2 else 'tinyGrid3D'}.g2o"))
    for path in ("t", "th" if n == 2 else "q"):
        store.tables["poses"].fixed(path)[:] = False
    for row in (0, 2):
        store.tables["anchors"].append(pose=row, **{
            p: store.tables["poses"].column(p)[row] for p in ("t", "th" if n == 2 else "q")})  # fmt: skip
    store.tables["poses"].column("t")[:] += 0.25
    before = cost(store)
    io.write(store, tmp_path / "b.g2o")
    again = load(n, tmp_path / "b.g2o")
    assert cost(again) == pytest.approx(before, rel=1e-12)
    anchors = again.tables["anchors"]
    assert anchors.column("t").tolist() == store.tables["anchors"].column("t").tolist()
    assert anchors.target_rows("pose").tolist() == [0, 2]
    assert not again.tables["poses"].fixed("t").any()


def test_a_graph_without_vertices_starts_along_its_edges(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    edges = ["EDGE_SE2 0 1 1 0 1.5707963267948966", "EDGE_SE2 1 2 2 0 0"]
    edges += ["EDGE_SE2 5 2 1 0 1.5707963267948966"]  # against the direction
    information = ["1 0 0 1 0 1\n"] * 3 + ["1 0 0 1 0 0.1\n"]  # the last heading is less certain
    edges += ["EDGE_SE2 2 0 9 9 9"]
    path.write_text("".join(f"{e} {u}" for e, u in zip(edges, information, strict=True)))
    poses = load(2, path).tables["poses"]
    assert poses.column("id").tolist() == [0, 1, 2, 5]
    half = np.pi / 2
    assert np.allclose(poses.column("t"), [[0, 0], [1, 0], [1, 2], [0, 2]])
    assert np.allclose(wrap(poses.column("th") - [0, half, half, 0]), 0)


def test_without_vertices_a_component_starts_at_its_prior(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text(
        "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n"
        "EDGE_PRIOR_SE2 3 10 20 1.5707963267948966 1 0 0 1 0 1\n"
    )
    poses = load(2, path).tables["poses"]
    assert np.allclose(poses.column("t"), [[0, 0], [1, 0], [10, 19], [10, 20]])
    assert poses.column("held").tolist() == [True, False, False, False]


def test_a_spatial_chain_closes_its_own_edges(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    lines = []
    for a, b in ((0, 1), (1, 2), (4, 2), (4, 3)):
        q = rng.normal(size=4)
        numbers = [*rng.normal(size=3), *(q / np.linalg.norm(q))]
        eye = [1.0 if i == j else 0.0 for i in range(6) for j in range(i, 6)]
        lines.append(" ".join(map(str, ("EDGE_SE3:QUAT", a, b, *numbers, *eye))))
    path = tmp_path / "a.g2o"
    path.write_text("\n".join(lines))
    assert cost(load(3, path)) < 1e-28


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        (VERTICES2 + "EDGE_SE2 7 3 1 0\n", "E0716", "a.g2o:3:1: error[E0716]: expected 11 values after `EDGE_SE2`, found 4"),
        (VERTICES2 + "EDGE_SE2 7 3 1 x 0.5 2 0 0 2 0 4", "E0716", "a.g2o:3:16: error[E0716]: expected a number, found `x`"),
        (VERTICES2 + "EDGE_SE2 7 3.5 1 0 0.5 2 0 0 2 0 4", "E0716", "found `3.5`"),
        (VERTICES2 + "EDGE_SE2 7 3 1 1_0 0.5 2 0 0 2 0 4", "E0716", "found `1_0`"),
        (VERTICES2 + "EDGE_SE2 7 3 1 nan 0.5 2 0 0 2 0 4", "E0705", "a.g2o:3"),
        (VERTICES2 + "EDGE_SE2 7 4 1 0 0.5 2 0 0 2 0 4", "E0720", "a.g2o:3:12: error[E0720]: vertex 4 is not in the file"),
        (VERTICES2 + "EDGE_SE2 7 7 1 0 0.5 2 0 0 2 0 4", "E0716", "from vertex 7 to itself"),
        (VERTICES2 + "EDGE_SE2 7 3 1 0 0.5 2 0 0 -2 0 4", "E0723", "a.g2o:3"),
        (VERTICES2 + "VERTEX_SE2 7 0 0 0", "E0719", "a.g2o:3:1: error[E0719]: vertex 7 is given twice"),
        (VERTICES2 + EDGE2 + "EGDE_SE2 7 3", "E0717", "a.g2o:4:1: error[E0717]: unknown tag `EGDE_SE2`"),
        (VERTICES2 + "EDGE_SE3:QUAT 7 3", "E0722", "of an SE3 graph"),
        (VERTICES2 + "EDGE_PRIOR_SE2 7 0 0 0 1 0 0 1 0 2", "E0722", "unit weight"),
        (VERTICES2 + "EDGE_PRIOR_SE2 8 0 0 0 1 0 0 1 0 1", "E0720", "vertex 8"),
        (VERTICES2 + "FIX 12", "E0720", "vertex 12"),
        (VERTICES2 + "FIX", "E0716", "FIX names no vertex"),
        ("VERTEX_SE2 9223372036854775808 0 0 0", "E0716", "found `9223372036854775808`"),
    ],
)  # fmt: skip
def test_each_mistake_is_named_with_its_line(
    tmp_path: Path, text: str, code: str, words: str
) -> None:
    path = tmp_path / "a.g2o"
    path.write_text(text)
    with pytest.raises(AraelError) as error:
        load(2, path)
    assert [d.code for d in error.value.diagnostics] == [code]
    assert words in str(error.value)


def test_several_mistakes_in_one_run(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text(VERTICES2 + "EDGE_SE2 7 9 1 0 0 -1 0 0 1 0 1\nEDGE_SE2 7 8 1 0 0 1 0 0 1 0 1\n")
    with pytest.raises(AraelError) as error:
        load(2, path)
    assert [d.code for d in error.value.diagnostics] == ["E0720", "E0720", "E0723"]
    assert error.value.diagnostics[2].notes == ("its smallest eigenvalue is -1",)


def test_other_models_do_not_take_g2o(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text(VERTICES2)
    with pytest.raises(AraelError, match="E0722"):
        io.read(Store(slam()), path)
    with pytest.raises(AraelError, match="E0722"):
        io.write(Store(slam()), tmp_path / "b.g2o")


def test_quaternions_are_normalised_and_may_not_be_zero(tmp_path: Path) -> None:
    path = tmp_path / "a.g2o"
    path.write_text("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 2\n")
    assert load(3, path).tables["poses"].column("q").tolist() == [[1, 0, 0, 0]]
    path.write_text("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n")
    with pytest.raises(AraelError, match="E0721"):
        load(3, path)
