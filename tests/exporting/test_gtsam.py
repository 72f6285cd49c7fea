"""Factors of GTSAM: compiled against a stub of its interface, and compared with GTSAM's wheel."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.exporting import Export, export
from arael.exporting.sample import samples_of
from tests.exporting.built import Library, compiler
from tests.optional import header, needs, program
from tests.public_data import public

STUB = Path(__file__).parent / "gtsam_stub"

KINDS = """
struct Thing {
    param T: transform
}
struct Turn {
    param q: quaternion
}
struct Point {
    param p: vec3
}
struct Other {
    param a: real
    param e: euler
}
struct Mark {
    param at: vec2
}
struct Row {
    thing: ref Thing in root.things
    turn: ref Turn in root.turns
    point: ref Point in root.points
    other: ref Other in root.others
    mark: ref Mark in root.marks
    d: vec3
    constraint all {
        let R = other.e.rotation_matrix()
        [thing.T * (turn.q.rotation_matrix() * (R * point.p)) * other.a - d,
         mark.at * other.a - [1, 2]]
    }
}
root Kinds {
    things: list of Thing
    turns: list of Turn
    points: list of Point
    others: list of Other
    marks: list of Mark
    rows: list of Row
}
"""

MAIN = """
#include <cstdio>
#include "{stem}_gtsam.h"

using namespace {stem};

template <class X, class Error>
void check(const char* name, const X& x, const gtsam::Matrix& h, Error error) {{
  double worst = 0;
  for (int k = 0; k < h.cols(); k++) {{
    gtsam::Vector step = gtsam::Vector::Zero(h.cols());
    step[k] = 1e-6;
    const gtsam::Vector difference = (error(x, step) - error(x, -step)) / 2e-6;
    worst = std::max(worst, (difference - h.col(k)).cwiseAbs().maxCoeff());
  }}
  std::printf("%s %g\\n", name, worst);
}}

inline gtsam::Vector moved(const gtsam::Vector& x, const gtsam::Vector& v) {{ return x + v; }}
inline gtsam::Point3 moved(const gtsam::Point3& x, const gtsam::Vector& v) {{ return x + v; }}
inline gtsam::Point2 moved(const gtsam::Point2& x, const gtsam::Vector& v) {{ return x + v; }}
template <class X> X moved(const X& x, const gtsam::Vector& v) {{ return x.retract(v); }}

void print(const char* name, const gtsam::Matrix& m) {{
  std::printf("%s", name);
  for (int i = 0; i < m.rows(); i++)
    for (int k = 0; k < m.cols(); k++) std::printf(" %.17g", m(i, k));
  std::printf("\\n");
}}

int main() {{
{body}
  return 0;
}}
"""


def run(project: Export, folder: Path, body: str) -> list[str]:
    """Compile a main program with the factors of `project`, strictly, and run it."""
    header("Eigen/Dense")
    project.write(folder)
    stem = project.functions.prefix.removesuffix("_")
    (folder / "main.cpp").write_text(MAIN.format(stem=stem, body=body))
    subprocess.run([compiler(), "-O1", "-c", f"{stem}.c"], cwd=folder, check=True)
    flags = [
        "-std=c++17",
        "-Wall",
        "-Wextra",
        "-Werror",
        f"-I{STUB}",
        "-isystem/usr/include/eigen3",
    ]
    command = [program("g++"), *flags, "main.cpp", f"{stem}.o", "-o", "main"]
    subprocess.run(command, cwd=folder, check=True)
    done = subprocess.run([folder / "main"], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def pose3(name: str, values: np.ndarray) -> str:
    x = [repr(float(v)) for v in values]
    rotation, point = ", ".join(x[3:]), ", ".join(x[:3])
    return f"  const gtsam::Pose3 {name}(gtsam::Rot3({rotation}), gtsam::Point3({point}));"


def unit(n: int, seed: int) -> np.ndarray:
    found = np.random.default_rng(seed).normal(size=n)
    return found / np.linalg.norm(found)


def test_derivatives_of_every_value_by_differences(tmp_path: Path) -> None:
    path = tmp_path / "kinds.arael"
    path.write_text(KINDS)
    rotation = ", ".join(repr(float(v)) for v in unit(4, 2))
    project = export(path, "gtsam")
    names = [one.name for one in project.functions.constraints[0].states]
    assert sorted(names) == ["mark", "other", "point", "thing", "turn"]
    lines = [
        pose3("thing", np.array([1.0, 2, 3, *unit(4, 1)])),
        f"  const gtsam::Rot3 turn({rotation});",
        "  const gtsam::Point3 point(0.3, -0.2, 0.5);",
        "  gtsam::Vector other(4);",
        "  other << 1.5, 0.1, 0.2, 0.3;",
        "  const gtsam::Point2 mark(0.4, 0.6);",
        "  const double data[] = {0.1, 0.2, 0.3};",
        "  const RowAll factor(1, 2, 3, 4, 5, data);",
        "  gtsam::Matrix H[5];",
        f"  factor.evaluateError({', '.join(names)}, &H[0], &H[1], &H[2], &H[3], &H[4]);",
    ]
    for k, name in enumerate(names):
        arguments = [f"moved({n}, v)" if n == name else n for n in names]
        arguments = [a.replace(f"moved({name}", "moved(x") for a in arguments]
        lines += [
            f'  check("{name}", {name}, H[{k}], [&](const auto& x, '
            "const gtsam::Vector& v) { return "
            f"factor.evaluateError({', '.join(arguments)}, nullptr, nullptr, nullptr, nullptr, "
            "nullptr); });",
        ]
    worst = {
        line.split()[0]: float(line.split()[1])
        for line in run(project, tmp_path / "c", "\n".join(lines))
    }
    assert list(worst) == names
    assert max(worst.values()) < 1e-8


@needs("gtsam")
def test_planar_edges_are_those_of_gtsam(tmp_path: Path) -> None:
    """Derivatives where the error is zero: elsewhere GTSAM takes a logarithm."""
    import gtsam

    a, d = gtsam.Pose2(1, 2, 0.7), gtsam.Pose2(0.5, -0.3, 0.4)
    u = np.triu(np.random.default_rng(1).normal(size=(3, 3)) + 3 * np.eye(3))
    b = a.compose(d)
    factor = gtsam.BetweenFactorPose2(1, 2, d, gtsam.noiseModel.Gaussian.SqrtInformation(u))
    values = gtsam.Values()
    values.insert(1, a)
    values.insert(2, b)
    data = ", ".join(repr(float(v)) for v in [d.x(), d.y(), d.theta(), *u.ravel()])
    body = [
        f"  const gtsam::Pose2 a({a.x()!r}, {a.y()!r}, {a.theta()!r});",
        f"  const gtsam::Pose2 b({b.x()!r}, {b.y()!r}, {b.theta()!r});",
        f"  const double data[] = {{{data}}};",
        "  const EdgeBetween factor(1, 2, data);",
        "  gtsam::Matrix ha, hb;",
        '  print("error", factor.evaluateError(a, b, &ha, &hb));',
        '  print("a", ha);',
        '  print("b", hb);',
    ]
    lines = run(export("pose_graph_2d", "gtsam"), tmp_path, "\n".join(body))
    error, ha, hb = (np.array([float(v) for v in line.split()[1:]]) for line in lines)
    np.testing.assert_allclose(error, 0, atol=1e-14)
    wanted = factor.linearize(values).jacobian()[0]
    np.testing.assert_allclose(np.hstack([ha.reshape(3, 3), hb.reshape(3, 3)]), wanted, atol=1e-12)


@needs("gtsam")
def test_gtsam_solves_a_grid_with_the_exported_functions(tmp_path: Path) -> None:
    """The same C functions in `gtsam.CustomFactor`: the known optimum."""
    import gtsam

    graph = arael.load("pose_graph_3d", interpret=True)()
    arael.read(graph, public("pose_graph_3d/smallGrid3D.g2o"))
    library = Library(export("pose_graph_3d"), tmp_path)
    functions = library.project.functions
    function = functions.constraints[0]
    data = samples_of(functions, graph)[0].data[0]

    def stored(x: gtsam.Pose3) -> np.ndarray:
        q = x.rotation().toQuaternion()
        return np.array([*x.translation(), q.w(), q.x(), q.y(), q.z()])

    def step(x: gtsam.Pose3) -> np.ndarray:
        found = np.zeros((6, 6))
        found[3:, :3], found[:3, 3:] = np.eye(3), x.rotation().matrix()
        return found

    def factor(a: int, b: int, row: np.ndarray) -> gtsam.CustomFactor:
        def error(
            this: gtsam.CustomFactor, values: gtsam.Values, jacobians: list[np.ndarray] | None
        ) -> np.ndarray:
            x, y = values.atPose3(a), values.atPose3(b)
            _, residual, blocks = library.evaluate(function, [stored(x), stored(y)], [row])
            if jacobians is not None:
                jacobians[0], jacobians[1] = blocks[0] @ step(x), blocks[1] @ step(y)
            return residual

        return gtsam.CustomFactor(gtsam.noiseModel.Unit.Create(6), [a, b], error)

    problem, start = gtsam.NonlinearFactorGraph(), gtsam.Values()
    for k, (t, q) in enumerate(zip(graph.poses.t.value, graph.poses.q.value, strict=True)):
        start.insert(k, gtsam.Pose3(gtsam.Rot3.Quaternion(*q), t))
    targets = graph._store.tables["edges"]
    for a, b, row in zip(targets.target_rows("a"), targets.target_rows("b"), data, strict=True):
        problem.add(factor(int(a), int(b), row))
    problem.add(gtsam.NonlinearEqualityPose3(0, start.atPose3(0)))
    end = gtsam.LevenbergMarquardtOptimizer(problem, start).optimize()
    np.testing.assert_allclose(2 * problem.error(end), 1025.3981, rtol=1e-5)


def test_what_gtsam_has_no_value_of_is_named() -> None:
    with pytest.raises(AraelError, match="Plane, planes cannot be values of GTSAM"):
        export("plane_slam", "gtsam")
    with pytest.raises(AraelError, match="gtsam solves in double precision"):
        export("linear", "gtsam")
