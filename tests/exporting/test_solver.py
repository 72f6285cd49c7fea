"""Exported solvers against the solve in Python; no heap, no output, no globals that change."""

from __future__ import annotations

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest

import arael
from arael.cli.main import run
from arael.diagnostics.records import AraelError
from arael.exporting import Export, export
from arael.model import Model
from tests.exporting.built import EXACT, STRICT, compiler
from tests.public_data import public

CALIBRATION = """
# A gain and offsets with a bound, a fixed row, a guard, a robust loss, and passes that freeze.
struct Sensor {
    param offset: real
    param gain: real in 0.5 .. 1.5
}
struct Reading {
    sensor: ref Sensor in root.sensors
    x: real
    y: real
    on: bool = true
    constraint value when on loss cauchy(3) {
        let s = sensor
        ((s.gain * x + s.offset + root.bias - y) * root.weight) / 0.1
    }
}
root Calibration {
    param bias: real = 0
    weight: real = 1
    sensors: list of Sensor
    readings: list of Reading
    constraint small { bias / 0.5 }
    solve {
        pass coarse { weight = 0.1  freeze sensors.gain }
        pass fine { weight = 1  free sensors.gain  rel_precision = 1e-10 }
    }
}
"""


def calibration(folder: Path, text: str = CALIBRATION) -> tuple[Path, Model]:
    path = folder / "calibration.arael"
    path.write_text(text)
    model = arael.load(path, interpret=True)()
    rng = np.random.default_rng(4)
    sensors = [model.sensors.append(offset=0.0, gain=1.0) for _ in range(3)]
    sensors[2].gain.fixed = True
    for k, (gain, offset) in enumerate([(1.2, 0.3), (1.9, -0.2), (0.8, 0.4)]):
        for i in range(12):
            x = rng.uniform(-2, 2)
            y = gain * x + offset + 0.05 * rng.normal() + (5 if i == 7 else 0)
            model.readings.append(sensor=sensors[k], x=x, y=y, on=i != 3)
    return path, model


class Program:
    """An exported project, built and run."""

    def __init__(self, project: Export, folder: Path, *flags: str) -> None:
        project.write(folder)
        self.folder, self.stem = folder, project.functions.prefix.removesuffix("_")
        self.sources = [f"{self.stem}.c", f"{self.stem}_solver.c"]
        self._build(*self.sources, "main.c", "-o", "main", *flags)

    def _build(self, *words: str) -> None:
        subprocess.run([compiler(), *STRICT, *EXACT, *words, "-lm"], cwd=self.folder, check=True)

    def library(self) -> ctypes.CDLL:
        self._build("-shared", "-fPIC", *self.sources, "-o", "solver.so")
        return ctypes.CDLL(str(self.folder / "solver.so"))

    def run(self) -> tuple[int, float, dict[str, list[list[float]]]]:
        """Status, cost, parameters of the solution."""
        done = subprocess.run([self.folder / "main"], capture_output=True, text=True, check=False)
        head, *rows = done.stdout.splitlines()
        words = head.replace(",", "").split()
        found: dict[str, list[list[float]]] = {}
        for row in rows:
            name, _, *values = row.split()
            found.setdefault(name, []).append([float(v) for v in values])
        return int(words[1]), float(words[5]), found


def test_a_window_with_everything(tmp_path: Path) -> None:
    path, model = calibration(tmp_path)
    program = Program(export(path, data=model, size="data"), tmp_path / "c")
    status, cost, found = program.run()
    result = model.solve()
    assert status == 0
    np.testing.assert_allclose(cost, result.cost, rtol=1e-8)
    sensors = np.array(found["sensor"])
    wanted = np.column_stack([model.sensors.offset.value, model.sensors.gain.value])
    np.testing.assert_allclose(sensors, wanted, atol=2e-5)
    assert sensors[1, 1] == 1.5  # on its bound
    assert sensors[2, 1] == 1.0  # fixed


@pytest.mark.parametrize(
    ("model", "file", "cost"),
    [
        ("pose_graph_3d", "pose_graph_3d/tinyGrid3D.g2o", 18.5194),
        ("pose_graph_3d", "pose_graph_3d/smallGrid3D.g2o", 1025.3981),
        ("bundle_adjustment", "bundle_adjustment/dubrovnik-3-7-pre.txt", None),
    ],
)
def test_public_problems_end_at_the_optimum(
    model: str, file: str, cost: float | None, tmp_path: Path
) -> None:
    instance = arael.load(model, interpret=True)()
    arael.read(instance, public(file))
    program = Program(export(model, data=instance, size="data"), tmp_path)
    status, found, _ = program.run()
    assert status == 0
    np.testing.assert_allclose(found, instance.solve().cost, rtol=1e-6, atol=1e-12)
    if cost is not None:
        np.testing.assert_allclose(found, cost, rtol=1e-5)


# A graph of planar poses; the layout of its data is that of `Window` below.
PLANAR = """
struct Pose {
    param t:  vec2 [m]
    param th: angle
}
struct Edge {
    a:  ref Pose in root.poses
    b:  ref Pose in root.poses
    t:  vec2 [m]
    th: real [rad]
    u:  mat3
    constraint between {
        let d = a.th.rotation_matrix()' * (b.t - a.t) - t
        let c = cos(th)
        let s = sin(th)
        u * [c * d.x + s * d.y, c * d.y - s * d.x, rad_diff(rad_diff(b.th, a.th), th)]
    }
}
struct Anchor {
    pose: ref Pose in root.poses
    t:    vec2 [m]
    th:   real [rad]
    t_isigma:  real [1/m]   = 1
    th_isigma: real [1/rad] = 1
    constraint prior { [(pose.t - t) * t_isigma, rad_diff(pose.th, th) * th_isigma] }
}
root PoseGraph {
    poses:   list of Pose
    edges:   list of Edge
    anchors: list of Anchor
    solve { pass refine { rel_precision = 1e-6 } }
}
"""


def graph(poses: int, folder: Path) -> tuple[Path, Model]:
    """A chain of poses with a loop, and an anchor."""
    path = folder / "pose_graph_2d.arael"
    path.write_text(PLANAR)
    model = arael.load(path, interpret=True)()
    rng = np.random.default_rng(1)
    rows = [
        model.poses.append(t=[k + 0.1 * rng.normal(), 0.1 * rng.normal()], th=0.1 * rng.normal())
        for k in range(poses)
    ]
    pairs = [(k, k + 1) for k in range(poses - 1)] + [(0, poses - 1)]
    for a, b in pairs:
        model.edges.append(
            a=rows[a], b=rows[b], t=[b - a + 0.01, 0.02], th=0.01, u=np.diag([10.0, 10, 30])
        )
    model.anchors.append(pose=rows[0], t=[0, 0], th=0)
    return path, model


def test_single_precision_and_fewer_rows_than_there_is_room_for(tmp_path: Path) -> None:
    path, model = graph(5, tmp_path)
    size = {"poses": 8, "edges": 12, "anchors": 2}
    project = export(path, data=model, size=size, precision="f32")
    status, cost, found = Program(project, tmp_path).run()
    assert status == 0
    np.testing.assert_allclose(cost, model.solve().cost, rtol=1e-4)
    np.testing.assert_allclose(np.array(found["pose"])[:, :2], model.poses.t.value, atol=1e-4)


def test_what_a_solver_contains(tmp_path: Path) -> None:
    """No heap, no input or output, no globals that change, and the sizes that are promised."""
    path, model = graph(10, tmp_path)
    project = export(path, data=model, size={"edges": 20}, precision="f32")
    program = Program(project, tmp_path)
    subprocess.run([compiler(), *STRICT, "-Os", "-c", *program.sources], cwd=tmp_path, check=True)
    objects = [source.replace(".c", ".o") for source in program.sources]
    symbols = subprocess.run(
        ["nm", *objects], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout.split("\n")
    undefined = {line.split()[-1] for line in symbols if " U " in line}
    own = {line.split()[-1] for line in symbols if " T " in line}
    assert undefined - own <= {
        "sinf",
        "cosf",
        "sincosf",
        "sqrt",
        "sqrtf",
        "ceilf",
        "memcpy",
        "memset",
    }
    assert not [line for line in symbols if line.split()[1:2] and line.split()[1] in "bBdDC"]
    header = project.files["pose_graph_2d_solver.h"]
    promised = int(header.split("RAM of the workspace: ")[1].split()[0])
    library = tmp_path / "size.c"
    library.write_text(
        '#include "pose_graph_2d_solver.h"\n#include <stdio.h>\n'
        'int main(void) { printf("%d", (int)sizeof(pose_graph_2d_state)); return 0; }\n'
    )
    subprocess.run([compiler(), "size.c", "-o", "size"], cwd=tmp_path, check=True)
    size = int(subprocess.run([tmp_path / "size"], capture_output=True, check=True).stdout)
    assert promised <= size <= promised + 8


class Options(ctypes.Structure):
    _fields_ = (
        ("max_iterations", ctypes.c_int),
        ("relative_precision", ctypes.c_double),
        ("strategy", ctypes.c_int),
        ("initial_damping", ctypes.c_double),
    )


class Outcome(ctypes.Structure):
    _fields_ = (
        ("status", ctypes.c_int),
        ("start_cost", ctypes.c_double),
        ("cost", ctypes.c_double),
        ("iterations", ctypes.c_int),
        ("accepted", ctypes.c_int),
    )


class Window(ctypes.Structure):
    """`pose_graph_2d_data` of five poses, five edges and one anchor."""

    _fields_ = (
        ("pose", ctypes.c_double * 15),
        ("pose_fixed", ctypes.c_ubyte * 15),
        ("poses_count", ctypes.c_int),
        ("edges_count", ctypes.c_int),
        ("edges_a", ctypes.c_int * 5),
        ("edges_b", ctypes.c_int * 5),
        ("edge_data", ctypes.c_double * 60),
        ("anchors_count", ctypes.c_int),
        ("anchors_pose", ctypes.c_int * 1),
        ("anchor_data", ctypes.c_double * 5),
    )


class Caller:
    """The solver of a graph of five poses, through its C interface."""

    def __init__(self, folder: Path) -> None:
        path, self.model = graph(5, folder)
        project = export(path, data=self.model, size="data")
        self.library = Program(project, folder).library()
        self.library.pose_graph_2d_default_options.restype = Options
        self.library.pose_graph_2d_solve.restype = Outcome
        self.state = (ctypes.c_double * 4096)()
        anchor = self.model.anchors
        edges = self.model.edges
        self.window = Window(poses_count=5, edges_count=5, anchors_count=1)
        values = np.column_stack([self.model.poses.t.value, self.model.poses.th.value])
        self.window.pose[:] = values.ravel().tolist()
        self.window.edges_a[:] = [0, 1, 2, 3, 0]
        self.window.edges_b[:] = [1, 2, 3, 4, 4]
        rows = np.column_stack([edges.t, edges.th, np.reshape(edges.u, (5, 9))])
        self.window.edge_data[:] = rows.ravel().tolist()
        row = [*np.ravel(anchor.t), *np.ravel(anchor.th)]
        self.window.anchor_data[:] = [*row, *np.ravel(anchor.t_isigma), *np.ravel(anchor.th_isigma)]

    def solve(self, **settings: float) -> Outcome:
        options = self.library.pose_graph_2d_default_options()
        for name, value in settings.items():
            setattr(options, name, value)
        found = self.library.pose_graph_2d_solve(
            ctypes.byref(self.state), ctypes.byref(self.window), ctypes.byref(options)
        )
        assert isinstance(found, Outcome)
        return found


def test_both_strategies_end_at_the_same_cost(tmp_path: Path) -> None:
    caller = Caller(tmp_path)
    start = list(caller.window.pose)
    first = caller.solve()
    caller.window.pose[:] = start
    second = caller.solve(strategy=1)
    assert first.status == second.status == 0
    np.testing.assert_allclose(first.cost, second.cost, rtol=1e-6)
    np.testing.assert_allclose(first.cost, caller.model.solve().cost, rtol=1e-6)
    assert first.start_cost > 1.5 * first.cost


def test_covariance_is_that_of_the_model(tmp_path: Path) -> None:
    caller = Caller(tmp_path)
    assert caller.solve(relative_precision=1e-14).status == 0
    covariance = (ctypes.c_double * 9)()
    caller.model.solve(rel_precision=1e-14)
    wanted = caller.model.covariance()
    for row in range(5):
        assert caller.library.pose_graph_2d_covariance_pose(
            ctypes.byref(caller.state), ctypes.byref(caller.window), row, covariance
        )
        np.testing.assert_allclose(
            np.reshape(covariance, (3, 3)),
            wanted.marginal(caller.model.poses[row]),
            rtol=1e-7,
            atol=1e-9,
        )
    assert not caller.library.pose_graph_2d_covariance_pose(
        ctypes.byref(caller.state), ctypes.byref(caller.window), 5, covariance
    )


def test_what_goes_wrong_has_a_status(tmp_path: Path) -> None:
    caller = Caller(tmp_path)
    assert caller.solve(max_iterations=1, relative_precision=1e-300).status == 1
    caller.window.edges_b[2] = 7
    assert caller.solve().status == 5  # no such row
    caller.window.edges_b[2] = 0
    assert caller.solve().status == 6  # poses 2 and 0 were not coupled
    caller.window.edges_b[2] = 3
    caller.window.edges_count = 6
    assert caller.solve().status == 4
    caller.window.edges_count = 5
    caller.window.edge_data[0] = float("nan")
    assert caller.solve().status == 2
    caller.window.edge_data[0] = 1.0
    caller.window.anchors_count = 0
    caller.window.edges_count = 0
    assert caller.solve().cost == 0


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ({"pose": 3}, "did you mean `poses`?"),
        ({"poses": 0}, "`poses` has 0 rows, expected at least 1 and at most 1000000"),
        ({"poses": 3}, "the size of `edges` is missing"),
        ({"poses": 7000, "edges": 3, "anchors": 1}, "21000 scalars, more than 20000"),
        ("data", "there is no data"),
    ],
)
def test_sizes_that_are_refused(size: dict[str, int], words: str) -> None:
    with pytest.raises(AraelError) as caught:
        export("pose_graph_2d", size=size)
    assert words in str(caught.value)
    assert "E1503" in str(caught.value)


ODD = """
struct Node {
    param y: real in 0 .. 2 = 1
    count: ref Solve in root.marks
    data:  ref Solve in root.marks
    constraint near { y * count.x - data.z }
}
struct Solve { param x: real = 1; z: real = 3; constraint stay { (x - z) * 0.5 } }
root Math { node: list of Node; marks: list of Solve }
"""


def odd(folder: Path) -> tuple[Path, Model]:
    """Names that programs have for themselves, and a fixed row outside of its bounds."""
    path = folder / "math.arael"
    path.write_text(ODD)
    model = arael.load(path, interpret=True)()
    a, b = model.marks.append(z=1.0), model.marks.append(z=2.0)
    model.node.append(count=a, data=b)
    fixed = model.node.append(count=b, data=a, y=3.5)
    fixed.y.fixed = True
    return path, model


def test_what_is_fixed_outside_of_its_bounds_stays(tmp_path: Path) -> None:
    path, model = odd(tmp_path)
    program = Program(export(path, data=model, size="data"), tmp_path / "c")
    status, cost, found = program.run()
    assert status == 0
    np.testing.assert_allclose(cost, model.solve(rel_precision=1e-12).cost, rtol=1e-8)
    assert found["node"][1] == [3.5]
    model.node[1].y.fixed = False
    with pytest.raises(arael.SolveError, match="E1007"):
        export(path, data=model, size="data")


def test_a_start_outside_of_its_bounds_has_a_status(tmp_path: Path) -> None:
    path, model = odd(tmp_path)
    program = Program(export(path, data=model, size="data"), tmp_path / "c")
    text = (program.folder / "main.c").read_text()
    at = text.index(".node_fixed")
    text = text[:at] + text[at:].replace("{1}", "{0}", 1)
    (program.folder / "main.c").write_text(text)
    program._build(*program.sources, "main.c", "-o", "main")
    assert program.run()[0] == 7


def test_collections_without_a_size_are_left_out() -> None:
    project = export("pose_graph_2d", size={"poses": 10, "edges": 20})
    assert [one.group.label for one in project.functions.constraints] == ["Edge.between"]
    assert "Anchor.prior" in project.left_out


def test_the_command_writes_a_program_that_solves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, model = calibration(tmp_path)
    data = tmp_path / "data.json"
    arael.write(model, data)
    folder = str(tmp_path / "out")
    assert run([*("export", str(path), str(data), "--size", "data", "-o"), folder]) == 0
    assert "wrote" in capsys.readouterr().out
    assert (tmp_path / "out" / "calibration_solver.c").exists()
    for size, words in (("sensors=3,sensors=4", "two sizes"), ("sensors=x", "expected NAME=N")):
        assert run(["export", str(path), "--size", size]) == 2
        assert words in capsys.readouterr().err


def test_collections_may_be_named_as_what_a_solver_defines(tmp_path: Path) -> None:
    """`SCALARS`, `BLOCKS`, `CONVERGED` are macros and statuses of every solver."""
    path = tmp_path / "named.arael"
    names = ("scalars", "blocks", "values", "converged", "max_iterations")
    lists = "\n".join(f"    {name}: list of Row{k}" for k, name in enumerate(names))
    rows = "\n".join(
        f"struct Row{k} {{ param x: real = 2; constraint c {{ x - {k} }} }}"
        for k in range(len(names))
    )
    path.write_text(f"{rows}\nroot Named {{\n{lists}\n}}\n")
    model = arael.load(path, interpret=True)()
    for name in names:
        getattr(model, name).append()
    status, cost, _ = Program(export(path, data=model, size="data"), tmp_path / "c").run()
    assert (status, cost) == (0, 0)


@pytest.mark.parametrize(
    "wrong",
    [{"size": "poses=10"}, {"size": {"poses": "10"}}, {"size": {"poses": True}}, {"data": 3},
     {"constraint": 3}, {"to": "c++"}],
)  # fmt: skip
def test_wrong_arguments_are_named(wrong: dict[str, object]) -> None:
    with pytest.raises(AraelError, match=f"`{next(iter(wrong))}` must be"):
        export("pose_graph_2d", **wrong)  # type: ignore[arg-type]
