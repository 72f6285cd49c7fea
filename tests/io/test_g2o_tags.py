"""Landmarks, priors, offsets and the tags of other tools: costs by g2o's formulas in NumPy.

The formulas are those of ``computeError`` in g2o's ``types/slam2d`` and ``types/slam3d``. Only the
rotation of poses in space differs: the models take twice the vector part of the quaternion, which
is the angle in radians, g2o the vector part itself.
"""
# ruff: noqa: E501 - a case, or a line of a file, is one line

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.cli import main as cli
from arael.diagnostics.records import AraelError
from arael.io import DataWarning
from arael.runtime.store import Store
from tests.hand_layouts import pose_graph

Array = Any


def run(arguments: list[str]) -> int:
    """The exit code of the command, in this process."""
    return int(cli.run(arguments))


def planar(x: float, y: float, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, x], [s, c, y], [0, 0, 1.0]])


def spatial(numbers: list[float]) -> Array:
    """A rotation by Rodrigues' formula from x y z qx qy qz qw."""
    x, y, z, *q = numbers
    v, w = np.array(q[:3]), q[3]
    n = np.hypot(np.linalg.norm(v), w)
    v, w = v / n, w / n
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    found = np.eye(4)
    found[:3, :3] = np.eye(3) + 2 * w * k + 2 * k @ k
    found[:3, 3] = x, y, z
    return found


def log2(m: Array) -> Array:
    return np.array([m[0, 2], m[1, 2], np.arctan2(m[1, 0], m[0, 0])])


def log3(m: Array) -> Array:
    """Translation and 2 sin(angle / 2) of the axis, from the antisymmetric part."""
    r = m[:3, :3]
    w = 0.5 * np.sqrt(max(1 + np.trace(r), 0.0))
    v = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / (4 * w)
    return np.array([*m[:3, 3], *2 * v])


def information(numbers: list[float]) -> Array:
    n = round((np.sqrt(8 * len(numbers) + 1) - 1) / 2)
    found, it = np.zeros((n, n)), iter(numbers)
    for i in range(n):
        for j in range(i, n):
            found[i, j] = found[j, i] = next(it)
    return found


def chi2(text: str) -> float:
    """The cost of the values in a file."""
    at: dict[int, Array] = {}
    offset: dict[int, Array] = {}
    lines = [line.split() for line in text.splitlines()]
    numbers = {i: list(map(float, words[1:])) for i, words in enumerate(lines)}
    for i, (tag, *_) in enumerate(lines):
        id, *v = numbers[i]
        if tag == "VERTEX_SE2":
            at[int(id)] = planar(*v)
        elif tag == "VERTEX_SE3:QUAT":
            at[int(id)] = spatial(v)
        elif tag in ("VERTEX_XY", "VERTEX_TRACKXYZ"):
            at[int(id)] = np.array([*v, 1.0])
        elif tag == "PARAMS_SE2OFFSET":
            offset[int(id)] = planar(*v)
        elif tag == "PARAMS_SE3OFFSET":
            offset[int(id)] = spatial(v)
    inv, cost = np.linalg.inv, 0.0
    for i, (tag, *_) in enumerate(lines):
        v = numbers[i]
        a, b = (at.get(int(v[k])) for k in (0, 1))
        if tag == "EDGE_SE2":
            e, w = log2(inv(planar(*v[2:5])) @ inv(a) @ b), v[5:]
        elif tag == "EDGE_SE3:QUAT":
            e, w = log3(inv(spatial(v[2:9])) @ inv(a) @ b), v[9:]
        elif tag == "EDGE_PRIOR_SE2":
            e, w = log2(inv(planar(*v[1:4])) @ a), v[4:]
        elif tag == "EDGE_PRIOR_SE2_XY":
            e, w = a[:2, 2] - v[1:3], v[3:]
        elif tag == "EDGE_SE3_PRIOR":
            e, w = log3(inv(spatial(v[2:9])) @ a @ offset[int(v[1])]), v[9:]
        elif tag == "EDGE_SE3_XYZ_PRIOR":
            e, w = (a @ offset[int(v[1])])[:3, 3] - v[2:5], v[5:]
        elif tag == "EDGE_SE2_XY":
            e, w = (inv(a) @ b)[:2] - v[2:4], v[4:]
        elif tag == "EDGE_SE2_POINTXY_OFFSET":
            e, w = (inv(a @ offset[int(v[2])]) @ b)[:2] - v[3:5], v[5:]
        elif tag == "EDGE_BEARING_SE2_XY":
            d = inv(a) @ b
            e = np.array([(v[2] - np.arctan2(d[1], d[0]) + np.pi) % (2 * np.pi) - np.pi])
            w = v[3:]
        elif tag == "EDGE_SE3_TRACKXYZ":
            e, w = (inv(a @ offset[int(v[2])]) @ b)[:3] - v[3:6], v[6:]
        elif tag in ("EDGE_PRIOR_XY", "EDGE_POINTXYZ_PRIOR"):
            d = len(a) - 1
            e, w = a[:d] - v[1 : 1 + d], v[1 + d :]
        else:
            assert tag.startswith(("VERTEX", "PARAMS", "FIX")), tag
            continue
        cost += float(e @ information(w) @ e)
    return cost


PLANAR = """\
PARAMS_SE2OFFSET 3 0.2 -0.1 0.7
VERTEX_SE2 0 0.1 0.2 0.3
VERTEX_SE2 1 1.1 0.3 3.0
VERTEX_XY 7 2.0 1.0
VERTEX_XY 8 -1.0 2.0
EDGE_PRIOR_SE2 0 0.0 0.1 0.2 4.0 1.0 0.5 5.0 0.25 6.0
EDGE_PRIOR_SE2_XY 1 1.0 0.0 3.0 1.0 2.0
EDGE_PRIOR_XY 8 -1.1 2.2 3.0 -1.0 2.0
EDGE_SE2_XY 0 7 1.9 0.4 5.0 1.0 4.0
EDGE_SE2_POINTXY_OFFSET 1 8 3 0.5 -1.5 5.0 1.0 4.0
EDGE_BEARING_SE2_XY 1 7 -3.0 9.0
EDGE_BEARING_SE2_XY 0 8 1.7 9.0
EDGE_SE2 0 1 1.0 0.2 2.6 4.0 1.0 0.5 5.0 0.25 6.0
"""

EYE6 = "4.0 0.1 0.2 0.3 0.4 0.5 5.0 0.1 0.2 0.3 0.4 6.0 0.1 0.2 0.3 7.0 0.1 0.2 8.0 0.1 9.0"
SPATIAL = f"""\
PARAMS_SE3OFFSET 0 0.0 0.0 0.0 0.0 0.0 0.0 1.0
PARAMS_SE3OFFSET 4 0.2 -0.1 0.3 0.1 0.2 0.3 0.9273618495495704
VERTEX_SE3:QUAT 0 0.1 0.2 0.3 0.0 0.0 0.6 0.8
VERTEX_SE3:QUAT 1 1.1 0.3 0.2 0.0 0.6 0.0 0.8
VERTEX_TRACKXYZ 7 2.0 1.0 0.5
EDGE_SE3_PRIOR 0 4 0.2 0.1 0.2 0.1 0.1 0.5 0.8544003745317531 {EYE6}
EDGE_SE3_XYZ_PRIOR 1 0 1.0 0.2 0.3 3.0 1.0 0.5 2.0 0.2 1.0
EDGE_POINTXYZ_PRIOR 7 2.1 1.0 0.6 3.0 1.0 0.5 2.0 0.2 1.0
EDGE_SE3_TRACKXYZ 0 7 0 1.5 -1.2 0.3 3.0 1.0 0.5 2.0 0.2 1.0
EDGE_SE3_TRACKXYZ 1 7 4 0.5 0.7 0.1 3.0 1.0 0.5 2.0 0.2 1.0
EDGE_SE3:QUAT 0 1 0.9 -0.7 0.1 -0.2 0.5 -0.4 0.7416198487095663 {EYE6}
"""


def graph_of(path: Path, text: str, **options: Any) -> Any:
    path.write_text(text)
    spatial = "SE3" in text.split("\n")[0] or text.startswith("VERTEX3")
    model = arael.load(f"pose_graph_{3 if spatial else 2}d")()
    model.read(path, **options)
    return model


def test_the_oracle_reads_every_tag_that_is_tested() -> None:
    """Each line counts: without it the cost is another."""
    for text in (PLANAR, SPATIAL):
        whole = chi2(text)
        lines = text.splitlines()
        for line in lines:
            if line.startswith("EDGE"):
                assert chi2("\n".join(x for x in lines if x != line)) < whole - 1e-4, line


@pytest.mark.parametrize("text", [PLANAR, SPATIAL], ids=["planar", "spatial"])
def test_costs_are_those_of_g2o_s_formulas(tmp_path: Path, text: str) -> None:
    model = graph_of(tmp_path / "a.g2o", text)
    assert model.cost() == pytest.approx(chi2(text), rel=1e-12)


@pytest.mark.parametrize("text", [PLANAR, SPATIAL], ids=["planar", "spatial"])
def test_a_graph_is_written_back_by_tag(tmp_path: Path, text: str) -> None:
    """Offsets of landmarks become part of the measurement, all else stays."""
    model = graph_of(tmp_path / "a.g2o", text)
    result = model.solve()
    assert result.converged
    model.write(tmp_path / "b.g2o")
    written = (tmp_path / "b.g2o").read_text()
    assert chi2(written) == pytest.approx(result.end_cost, rel=1e-9)
    assert result.end_cost < 0.5 * chi2(text)
    again = graph_of(tmp_path / "c.g2o", written)
    assert again.cost() == pytest.approx(result.end_cost, rel=1e-9)
    tags = [line.split()[0] for line in text.splitlines() if "OFFSET 3 " not in line]
    tags = [tag.replace("POINTXY_OFFSET", "XY") for tag in tags]
    assert sorted(line.split()[0] for line in written.splitlines()) == sorted(tags)


def test_a_graph_with_landmarks_is_solved_by_the_command(tmp_path: Path) -> None:
    """One name for graphs with and without; the optimum by a scan of SciPy."""
    text = (
        "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0.8 0.1 0.05\nVERTEX_XY 2 1.3 0.8\n"
        "EDGE_SE2 0 1 1 0 0 10 0 0 10 0 10\nEDGE_SE2_XY 0 2 1.1 1 5 0 5\n"
        "EDGE_SE2_XY 1 2 0 1 5 0 5\nEDGE_BEARING_SE2_XY 1 2 1.57 100\n"
    )
    from scipy.optimize import minimize

    def cost(x: Array) -> float:
        head = f"VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 {x[0]} {x[1]} {x[2]}\nVERTEX_XY 2 {x[3]} {x[4]}\n"
        return chi2(head + "".join(f"{line}\n" for line in text.splitlines()[3:]))

    best = minimize(cost, [1, 0, 0, 1, 1], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-13, "maxiter": 9000, "maxfev": 9000})  # fmt: skip
    (tmp_path / "lm.g2o").write_text(text)
    out = tmp_path / "out.json"
    assert run(["solve", "pose_graph_2d", str(tmp_path / "lm.g2o"), "-o", str(out)]) == 0
    found = json.loads(out.read_text())
    pose, landmark = found["poses"][1], found["landmarks"][0]
    values = [*pose["t"], pose["th"], *landmark["t"]]
    assert np.allclose(values, best.x, atol=1e-5)
    assert found["poses"][0]["held"] and not landmark["held"]
    assert run(["convert", str(tmp_path / "lm.g2o"), str(tmp_path / "again.g2o")]) == 0
    assert "EDGE_BEARING_SE2_XY 1 2 1.57 100.0" in (tmp_path / "again.g2o").read_text()


def test_a_prior_in_the_tag_without_parameters_is_at_the_pose(tmp_path: Path) -> None:
    text = f"VERTEX_SE3:QUAT 1 0.3 0 0 0 0 0 1\nEDGE_SE3_PRIOR 1 1 0 0 0 0 0 0 1 {EYE6}\n"
    model = graph_of(tmp_path / "a.g2o", text)
    assert model.cost() == pytest.approx(4 * 0.09)
    assert not model.poses[0].held


TUTORIAL = """\
TUTORIAL_PARAMS_SE2_OFFSET 0 0.2 -0.1 0.7
TUTORIAL_VERTEX_SE2 0 0.1 0.2 0.3
TUTORIAL_VERTEX_SE2 1 1.1 0.3 0.5
TUTORIAL_VERTEX_POINT_XY 2 2.0 1.0
TUTORIAL_EDGE_SE2 0 1 1.0 0.0 0.1 10 0 0 10 0 10
TUTORIAL_EDGE_SE2_POINT_XY 1 2 0 1.0 0.5 5 1 4
"""


def test_tags_of_the_tutorial_are_those_without_the_prefix(tmp_path: Path) -> None:
    model = graph_of(tmp_path / "a.g2o", TUTORIAL)
    plain = TUTORIAL.replace("TUTORIAL_", "").replace("POINT_XY 2 2", "XY 2 2")
    plain = plain.replace("SE2_OFFSET", "SE2OFFSET").replace("SE2_POINT_XY", "SE2_POINTXY_OFFSET")
    assert model.cost() == pytest.approx(chi2(plain), rel=1e-12) and chi2(plain) > 1


def test_toro_in_space_has_roll_pitch_and_yaw(tmp_path: Path) -> None:
    """Rz(yaw) Ry(pitch) Rx(roll), and the information row by row."""
    r, p, y = 0.3, -0.4, 2.0
    rows = "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1 2 3 0.3 -0.4 2.0\n"
    model = graph_of(tmp_path / "a.graph", rows + f"EDGE3 0 1 1.5 2 3 0.3 -0.4 2.0 {EYE6}\n")
    x = np.array([[1, 0, 0], [0, np.cos(r), -np.sin(r)], [0, np.sin(r), np.cos(r)]])
    b = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
    z = np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]])
    assert np.allclose(model.poses[1].q.matrix, z @ b @ x)
    e = np.array([*(z @ b @ x).T @ [-0.5, 0, 0], 0, 0, 0])
    assert model.cost() == pytest.approx(float(e @ information(list(map(float, EYE6.split()))) @ e))
    model.write(tmp_path / "b.graph")
    tags = [line.split()[0] for line in (tmp_path / "b.graph").read_text().splitlines()]
    assert tags == ["VERTEX3", "VERTEX3", "EDGE3"]
    again = graph_of(tmp_path / "b.graph", (tmp_path / "b.graph").read_text())
    assert again.cost() == pytest.approx(model.cost(), rel=1e-12)


def test_equiv_makes_one_vertex_of_two(tmp_path: Path) -> None:
    text = (
        "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nVERTEX2 2 1.2 0 0\nEQUIV 2 1\n"
        "EDGE2 0 1 1.1 0 0 1 0 1 1 0 0\nEDGE2 0 2 0.7 0 0 1 0 1 1 0 0\nEDGE2 1 2 9 0 0 1 0 1 1 0 0\n"
    )
    with pytest.warns(DataWarning, match=r"ids of vertices that EQUIV joins to others \(2\)"):
        model = graph_of(tmp_path / "a.graph", text)
    assert model.poses.id.tolist() == [0, 1]
    assert model.edges.b.index.tolist() == [1, 1]
    model.solve()
    assert model.poses[1].t.value == pytest.approx([0.9, 0.0])


def test_a_tag_may_be_written_with_blanks(tmp_path: Path) -> None:
    text = SPATIAL.replace("SE3:QUAT", "SE3 : QUAT", 1).replace("SE3:QUAT", "SE3: QUAT", 1)
    model = graph_of(tmp_path / "a.g2o", text)
    assert model.cost() == pytest.approx(chi2(SPATIAL), rel=1e-12)
    with pytest.raises(
        AraelError, match=r"a.g2o:1:21: error\[E0716\]: expected a number, found `x`"
    ):
        graph_of(tmp_path / "a.g2o", "VERTEX_SE3 : QUAT 0 x 0 0 0 0 0 1\n")


BARE = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.2\nVERTEX_XY 2 1 1\n"
BARE_EDGES = "EDGE_SE2 0 1 1.5 0 0\nEDGE_SE2_XY 0 2 1 1.5\nEDGE_BEARING_SE2_XY 0 2 0.9\n"


def test_information_that_the_file_lacks_is_given(tmp_path: Path) -> None:
    given = "EDGE_SE2 0 1 1.5 0 0 100 0 0 100 0 400\nEDGE_SE2_XY 0 2 1 1.5 100 0 100\n"
    given += "EDGE_BEARING_SE2_XY 0 2 0.9 400\nEDGE_SE2 0 1 1.3 0 0 1 0 0 2 0 3\n"
    text = BARE + BARE_EDGES + "EDGE_SE2 0 1 1.3 0 0 1 0 0 2 0 3\n"
    model = graph_of(tmp_path / "a.g2o", text, information=(100, 400))
    assert model.cost() == pytest.approx(chi2(BARE + given), rel=1e-12)
    with pytest.raises(AraelError) as error:
        graph_of(tmp_path / "a.g2o", text)
    assert [d.code for d in error.value.diagnostics] == ["E0716"] * 3
    assert "--information 100" in str(error.value)

    path = str(tmp_path / "a.g2o")
    assert run(["solve", "pose_graph_2d", path]) == 2
    assert run(["solve", "pose_graph_2d", path, "--information", "100,400"]) == 0
    assert run(["convert", path, str(tmp_path / "b.g2o"), "--information", "100,400"]) == 0
    written = chi2((tmp_path / "b.g2o").read_text())
    assert written == pytest.approx(chi2(BARE + given), rel=1e-9)
    assert run(["solve", "pose_graph_2d", path, "--information", "0"]) == 2


@pytest.mark.parametrize(
    "given", [0, -1.0, float("inf"), (1, 2, 3), "100", (1, None)], ids=lambda x: str(x)
)
def test_information_is_one_or_two_positive_numbers(tmp_path: Path, given: Any) -> None:
    with pytest.raises(AraelError, match="positive number"):
        graph_of(tmp_path / "a.g2o", BARE + BARE_EDGES, information=given)


def test_information_in_the_order_of_toro(tmp_path: Path) -> None:
    model = graph_of(
        tmp_path / "a.toro", "VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0\n",
        information=(100, 400),
    )  # fmt: skip
    assert np.allclose(model.edges.u, [np.diag([10, 10, 20])])


GPS = (
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_SE2 2 2 0 0\n"
    "EDGE_SE2 0 1 1 0 0 9 0 0 9 0 9\nEDGE_SE2 1 2 1 0 0 9 0 0 9 0 9\n"
)


@pytest.mark.parametrize(
    ("priors", "position", "heading"),
    [
        ("", [0], [0]),
        ("EDGE_PRIOR_SE2_XY 1 5 5 1 0 1\n", [], [0]),
        ("EDGE_PRIOR_SE2_XY 1 5 5 1 0 1\nEDGE_PRIOR_SE2_XY 1 5 5 1 0 1\n", [], [0]),
        ("EDGE_PRIOR_SE2_XY 1 5 5 1 0 1\nEDGE_PRIOR_SE2_XY 2 6 5 1 0 1\n", [], []),
        ("EDGE_PRIOR_SE2 1 0 0 1 0 0 0 0 0 4\n", [0], []),
        ("EDGE_PRIOR_SE2 1 0 0 1 1 0 0 1 0 4\n", [], []),
        ("VERTEX_XY 7 1 1\nEDGE_SE2_XY 0 7 1 1 1 0 1\nFIX 7\n", [], [0]),
        ("VERTEX_XY 7 1 1\nEDGE_SE2_XY 0 7 1 1 1 0 1\nEDGE_PRIOR_XY 7 1 2 1 0 1\n", [], [0]),
        ("VERTEX_XY 7 1 1\n", [0], [0]),
    ],
)
def test_what_no_line_determines_is_held_and_nothing_else(
    tmp_path: Path, priors: str, position: list[int], heading: list[int]
) -> None:
    model = graph_of(tmp_path / "a.g2o", GPS + priors)
    assert np.flatnonzero(model.poses.t.fixed).tolist() == position
    assert np.flatnonzero(model.poses.th.fixed).tolist() == heading
    assert model.poses.held.tolist() == [bool(position or heading), False, False]
    result = model.solve()
    assert result.end_cost < 1e-10  # what is held takes nothing from the optimum
    model.write(tmp_path / "b.g2o")
    kept = [line for line in (tmp_path / "b.g2o").read_text().splitlines() if "FIX" in line]
    assert kept == (["FIX 7"] if "FIX 7" in priors else [])


def test_landmarks_join_components_and_alone_are_held(tmp_path: Path) -> None:
    text = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 2 1 1\nVERTEX_XY 3 4 4\n"
    text += "EDGE_SE2_XY 0 2 1 1 1 0 1\nEDGE_SE2_XY 1 2 0 1 1 0 1\n"
    model = graph_of(tmp_path / "a.g2o", text)
    assert model.poses.held.tolist() == [True, False]
    assert model.landmarks.held.tolist() == [False, True]


def test_without_vertices_landmarks_are_where_they_are_seen(tmp_path: Path) -> None:
    h = np.pi / 2
    text = (
        f"EDGE_SE2 0 1 1 0 {h} 9 0 0 9 0 9\nEDGE_SE2_XY 1 20 2 0 1 0 1\nEDGE_SE2_XY 0 20 1 3 1 0 1\n"
        f"EDGE_BEARING_SE2_XY 0 21 {np.arctan2(2, 3)} 4\nEDGE_BEARING_SE2_XY 1 21 {-np.arctan2(2, 2)} 4\n"
    )
    model = graph_of(tmp_path / "a.g2o", text)
    assert model.landmarks.id.tolist() == [20, 21]
    assert np.allclose(model.landmarks.t.value, [[1, 2.5], [3, 2]])


def test_starts_take_landmarks_along(tmp_path: Path) -> None:
    """From odometry in the file that drifts; the loop closes by an edge and by landmarks."""
    rng = np.random.default_rng(5)
    n, turn = 40, 2 * np.pi / 40
    truth = [np.eye(3)]
    for _ in range(n - 1):
        truth.append(truth[-1] @ planar(1, 0, turn))
    seen = rng.uniform(-8, 8, (12, 2)) + np.array([0, 6])
    lines, edges, at = [], [], np.eye(3)
    for i in range(n):
        lines.append("VERTEX_SE2 {} {} {} {}".format(i, *log2(at)))
        at = at @ planar(1, 0, turn + 0.05)
        j = (i + 1) % n
        m = log2(np.linalg.inv(truth[i]) @ truth[j]) + rng.normal(0, 0.01, 3)
        edges.append("EDGE_SE2 {} {} {} {} {} 1e4 0 0 1e4 0 1e4".format(i, j, *m))
        for k, p in enumerate(seen):
            d = (np.linalg.inv(truth[i]) @ [*p, 1])[:2] + rng.normal(0, 0.01, 2)
            if np.hypot(*d) < 8:
                edges.append("EDGE_SE2_XY {} {} {} {} 1e4 0 1e4".format(i, 100 + k, *d))
    lines += [f"VERTEX_XY {100 + k} 0 0" for k in range(len(seen))]
    model = graph_of(tmp_path / "a.g2o", "\n".join(lines + edges))
    start = arael.initialise(model)
    assert start.chosen == "chordal"
    assert np.allclose(model.landmarks.t.value, seen, atol=0.5)
    assert start.costs["chordal"] < 1e-3 * start.costs["file"]
    result = model.solve()
    assert result.converged and np.allclose(model.landmarks.t.value, seen, atol=0.05)


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("EDGE_SE2_XY 0 9 1 1 1 0 1", "E0720", "vertex 9 is not in the file"),
        ("EDGE_SE2_XY 0 1 1 1 1 0 1", "E0720", "vertex 1 is one of the poses, expected one of the landmarks"),
        ("EDGE_SE2 0 2 1 1 0 1 0 0 1 0 1", "E0720", "vertex 2 is one of the landmarks"),
        ("VERTEX_XY 1 0 0", "E0719", "vertex 1 is given twice"),
        ("EDGE_PRIOR_SE2 0 0 0 0 -1 0 0 1 0 1", "E0723", "its smallest eigenvalue is -1"),
        ("EDGE_PRIOR_SE2 0 0 0 0 0 0 0 0 0 0", "E0723", "smallest eigenvalue is 0"),
        ("EDGE_BEARING_SE2_XY 0 2 1 -4", "E0723", "smallest eigenvalue is -4"),
        ("PARAMS_SE2OFFSET 1 0 0 0\nEDGE_SE2_POINTXY_OFFSET 0 2 5 1 1 1 0 1", "E0720", "the offset 5 is not in the file"),
        ("EQUIV 1", "E0716", "EQUIV names two vertices"),
        ("EDGE_SE3_TRACKXYZ 0 2 0 1 1 1", "E0722", "is of an SE3 graph"),
        ("VERTEX_SWITCH 9 1", "E0717", "needs no switches"),
        ("EDGE_SE3_TRACKUVD 0 2 0 1 1 1 1 0 0 1 0 1", "E0717", "is of images"),
        ("PARAMS_CAMERACALIB 0 0 0 0 0 0 0 1 500 500 320 240", "E0717", "write each as `EDGE_SE3_TRACKXYZ`"),
        ("EDGE_SE2_SWITCHABLE 0 1 9 1 0 0 1 0 0 1 0 1", "E0717", "loss dcs(1)"),
        ("EDGE_SE2_MAXMIX 0 1 0.1 1 0 0 1 0 0 1 0 1", "E0717", "loss tukey(3)"),
        ("EDGE_SE2 0 1 1,5 0 0 1 0 0 1 0 1\nEDGE_SE2 0 1 1,5 0 0 1 0 0 1 0 1", "E0716", "decimal commas"),
    ],
)  # fmt: skip
def test_each_mistake_is_named_once(tmp_path: Path, text: str, code: str, words: str) -> None:
    with pytest.raises(AraelError) as error:
        graph_of(tmp_path / "a.g2o", BARE + text + "\n")
    assert [d.code for d in error.value.diagnostics] == [code]
    assert " ".join(words.split()) in " ".join(str(error.value).split())


def test_a_model_without_landmarks_names_the_one_that_has_them(tmp_path: Path) -> None:
    (tmp_path / "a.g2o").write_text(BARE)
    with pytest.raises(AraelError, match="no collection `landmarks`") as error:
        arael.io.read(Store(pose_graph(2)), tmp_path / "a.g2o")
    assert "`pose_graph_2d` has it" in str(error.value)


def test_weights_of_anchors_made_in_python_are_written(tmp_path: Path) -> None:
    model = graph_of(
        tmp_path / "a.g2o", "VERTEX_SE2 4 1 0 0.2\nEDGE_PRIOR_SE2 4 0 0 0 1 0 0 1 0 1\n"
    )
    model.anchors.t_isigma, model.anchors.th_isigma = 3.0, 5.0
    model.write(tmp_path / "b.g2o")
    assert chi2((tmp_path / "b.g2o").read_text()) == pytest.approx(model.cost())
