"""Projects for Ceres: built with CMake against its headers, solved, and compared with arael."""

from __future__ import annotations

import subprocess
from pathlib import Path

import msgspec
import numpy as np
import pytest

from arael.compiler.compilation import compile_text
from arael.diagnostics.records import AraelError, Source
from arael.exporting import Export, export
from arael.exporting.program import tangent_programs
from arael.exporting.sample import samples_of
from arael.manifolds.parameters import PARAMETERS, parameter_type
from arael.runtime.layout import ParamUse
from tests.exporting.built import on_numbers
from tests.exporting.test_c_functions import filled
from tests.exporting.test_solver import CALIBRATION, calibration
from tests.manifolds.test_parameters import stored_value
from tests.optional import header, program

CHECK = """
#include <cstdio>
#include <ceres/gradient_checker.h>
#include "everything_ceres.h"

// Ceres' own checker: derivatives by the stored scalars, through the manifolds, by differences.
int main() {
  using namespace everything;
  double body[] = {%s};
  double data[] = {%s};
  BodyManifold manifold;
  std::vector<const ceres::Manifold*> manifolds = {&manifold};
  BodyTurned cost(data);
  ceres::GradientChecker checker(&cost, &manifolds, ceres::NumericDiffOptions());
  const double* blocks[] = {body};
  ceres::GradientChecker::ProbeResults found;
  const bool same = checker.Probe(blocks, 1e-6, &found);
  std::printf("%%d %%s\\n", same, found.error_log.c_str());
  double delta[%d], moved[%d], back[%d];
  for (int k = 0; k < %d; k++) delta[k] = 0.1 * (k %% 3) - 0.05;
  manifold.Plus(body, delta, moved);
  manifold.Minus(moved, body, back);
  double worst = 0;
  for (int k = 0; k < %d; k++) worst = std::fmax(worst, std::fabs(back[k] - delta[k]));
  std::printf("%%g\\n", worst);
  return 0;
}
"""


def built(project: Export, folder: Path, main: str = "") -> Path:
    """The main program of a project, or the one given, built with CMake."""
    cmake = program("cmake")
    header("ceres/ceres.h")
    project.write(folder)
    if main:
        (folder / "main.cpp").write_text(main)
    for words in (["-S", ".", "-B", "build"], ["--build", "build"]):
        subprocess.run([cmake, *words], cwd=folder, check=True, capture_output=True)
    stem = project.functions.prefix.removesuffix("_")
    return folder / "build" / f"{stem}_main"


def test_a_problem_with_bounds_guards_and_losses(tmp_path: Path) -> None:
    """The optimum of arael is one of Ceres: it starts there, sees the same cost, and stays.

    Ceres knows no passes, so the model has none.
    """
    text = CALIBRATION[: CALIBRATION.index("    solve {")] + "}\n"
    path, model = calibration(tmp_path, text)
    model.sensors[2].offset.fixed = True  # with its gain, which is: Ceres fixes whole blocks
    wanted = model.solve(rel_precision=1e-12)
    main = built(export(path, "ceres", data=model), tmp_path / "ceres")
    head, *rows = subprocess.run(
        [main], capture_output=True, text=True, check=True
    ).stdout.splitlines()
    start, end = (float(cost) for cost in head.removeprefix("status 0, cost ").split(" -> "))
    np.testing.assert_allclose([start, end], wanted.cost, rtol=1e-9)
    sensors = [[float(v) for v in row.split()[2:]] for row in rows if row.startswith("sensor")]
    solved = np.column_stack([model.sensors.offset.value, model.sensors.gain.value])
    np.testing.assert_allclose(sensors, solved, atol=1e-4)


def test_derivatives_by_the_checker_of_ceres(tmp_path: Path) -> None:
    path, model = filled(tmp_path)
    project = export(path, "ceres", data=model)
    function = project.functions.constraints[0]
    samples = samples_of(project.functions, model, 1)[0]
    texts = [", ".join(repr(float(v)) for v in a[0]) for a in (*samples.states, *samples.data)]
    one = function.sets[0].entity
    sizes = (one.tangent, one.stored, one.tangent, one.tangent, one.tangent)
    main = built(project, tmp_path / "ceres", CHECK % (*texts, *sizes))
    printed = subprocess.run([main], capture_output=True, text=True, check=True).stdout
    same, worst = printed.splitlines()[0], float(printed.splitlines()[-1])
    assert same.startswith("1"), printed
    assert worst < 1e-12


@pytest.mark.parametrize("name", PARAMETERS)
def test_derivatives_of_plus_and_minus_are_inverse(name: str) -> None:
    kind = parameter_type(name)
    stored = stored_value(kind, 4)
    use = ParamUse("x", name, 0, kind.storage, 0, kind.tangent_width)
    entity = msgspec.structs.replace(
        compile_text(Source("x.arael", "root R { param x: real = 0; constraint c { x } }"))
        .layout.entities[0],
        params=(use,), stored=kind.storage, tangent=kind.tangent_width,
    )  # fmt: skip
    plus, minus = tangent_programs(entity)
    p = np.reshape(on_numbers(plus, [*map(float, stored)]), (kind.storage, kind.tangent_width))
    m = np.reshape(on_numbers(minus, [*map(float, stored)]), (kind.tangent_width, kind.storage))
    np.testing.assert_allclose(m @ p, np.eye(kind.tangent_width), atol=1e-14)


def test_what_ceres_does_not_have_is_refused(tmp_path: Path) -> None:
    path, model = calibration(tmp_path)
    with pytest.raises(AraelError, match=r"row 2 of parameters of Sensor.* is fixed in part"):
        export(path, "ceres", data=model)
    with pytest.raises(AraelError, match="ceres solves in double precision"):
        export("linear", "ceres")
