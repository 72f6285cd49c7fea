"""Exported C functions against the model in Python, and against the programs of its kernels."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import arael
from arael.compiler.compilation import compile_text
from arael.compiler.groups import Kernel
from arael.diagnostics.records import AraelError
from arael.exporting import Export, export
from arael.exporting.c_functions import ConstraintFunction
from arael.exporting.sample import Samples, samples_of
from arael.model import Model
from arael.solving import problem_of
from arael.syntax.files import read_source
from tests.exporting.built import Library, compiler, on_numbers
from tests.public_data import public

MODELS = Path(__file__).parents[2]

# Every kind of parameter and of data, guards of both kinds, a loss, rows reached through refs.
EVERYTHING = """
const HALF = 0.5

struct Fix { at: vec3 [m]; isigma: mat3 }

struct Body {
    param pos:  vec3 [m]
    param ea:   euler
    param rot:  rotation
    param q:    quaternion
    param th:   angle
    param dir:  direction
    param T:    transform
    param S:    similarity
    param k:    vec<5> = [0.1, 0.2, 0.3, 0.4, 0.5]
    param g:    real = 1
    fix: Fix?
    on:  bool = true
    n:   int = 2
    double: real = 2

    constraint turned {
        let v = ea.rotation_matrix() * (rot.rotation_matrix() * (q.rotation_matrix() * dir))
        [T * v - S * pos, sin(th) + k[3] * n, atan2(g, double) * HALF]
    }
    constraint fixed when fix { fix.isigma * (pos - fix.at) }
    constraint drift when on and n > 1 { (pos - pos.value) * 0.1 }
    constraint near when g > 0.5 loss cauchy(2) { [g - 1, min(g, abs(k[0]))] }
}

struct Link {
    a: ref Body in root.bodies
    b: ref Body in root.bodies
    d: vec3
    constraint between { (a.T.inverse() * b.pos - d) * root.scale }
}

root Everything {
    bodies: list of Body
    links:  list of Link
    param scale: real = 2
}
"""


def filled(folder: Path) -> tuple[Path, Model]:
    path = folder / "everything.arael"
    path.write_text(EVERYTHING)
    model = arael.load(path, interpret=True)()
    rng = np.random.default_rng(3)

    def unit(n: int) -> np.ndarray:
        v = rng.normal(size=n)
        return v / np.linalg.norm(v)

    rows = []
    for k in range(4):
        fix = None if k == 1 else {"at": rng.normal(size=3), "isigma": rng.normal(size=(3, 3))}
        rows.append(
            model.bodies.append(
                pos=rng.normal(size=3), ea=rng.normal(size=3), rot=unit(4), q=unit(4),
                th=rng.normal(), dir=unit(3), T=[*rng.normal(size=3), *unit(4)],
                S=[*rng.normal(size=3), *unit(4), 1.5], k=rng.normal(size=5), g=0.3 + 0.4 * k,
                fix=fix, on=k != 2, n=1 + k, double=3.0,
            )
        )  # fmt: skip
    model.links.append(a=rows[0], b=rows[3], d=[1, 2, 3])
    model.links.append(a=rows[2], b=rows[1], d=[0, 1, 0])
    return path, model


def arguments(samples: Samples, k: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    return [a[k] for a in samples.states], [a[k] for a in samples.data]


def check_against_model(library: Library, model: Model, rtol: float, atol: float) -> int:
    """Compare each row of the model's Jacobian with the exported functions; count the rows."""
    functions = library.project.functions
    problem = problem_of(model)
    rows = iter(model.jacobian())
    checked = 0
    for function, samples in zip(functions.constraints, samples_of(functions, model), strict=True):
        group = function.group
        number = [(g.label, g.table) for g in functions.layout.groups].index(
            (group.label, group.table)
        )
        slots = problem.structure.slot_rows[number]
        for k in range(len(samples.rows)):
            active, residual, blocks = library.evaluate(function, *arguments(samples, k))
            if not active:  # a guard over parameters: the Jacobian has no rows for it
                continue
            dense: dict[int, np.ndarray] = {}
            for use, block in zip(group.uses, blocks, strict=True):
                places = problem.structure.system.blocks[use.entity]
                row = int(slots[use.slot][k])
                for tangent in range(block.shape[1]):
                    if places.free[row, tangent]:
                        at = int(places.first[row]) + tangent
                        dense[at] = dense.get(at, 0) + block[:, tangent]
            for i in range(group.residuals):
                wanted = next(rows)
                assert wanted.label == group.label
                np.testing.assert_allclose(residual[i], wanted.residual, rtol=rtol, atol=atol)
                known = dict(wanted.entries)
                for at, column in dense.items():
                    np.testing.assert_allclose(column[i], known.pop(at, 0.0), rtol=rtol, atol=atol)
                assert not any(known.values())
                checked += 1
    assert next(rows, None) is None
    return checked


def test_every_kind_of_parameter_and_guard(tmp_path: Path) -> None:
    path, model = filled(tmp_path)
    library = Library(export(path, data=model), tmp_path / "c")
    assert check_against_model(library, model, 1e-12, 1e-13) > 40


def test_residuals_of_inactive_rows_are_zero(tmp_path: Path) -> None:
    path, model = filled(tmp_path)
    library = Library(export(path), tmp_path / "c")
    near = next(f for f in library.project.functions.constraints if f.name.endswith("body_near"))
    samples = samples_of(library.project.functions, model)[
        library.project.functions.constraints.index(near)
    ]
    seen = {}
    for k in range(len(samples.rows)):
        active, residual, blocks = library.evaluate(near, *arguments(samples, k))
        seen[active] = not residual.any() and not any(block.any() for block in blocks)
    assert seen == {0: True, 1: False}


def programs_at(
    kernel: Kernel, function: ConstraintFunction, states: list[np.ndarray], raw: list[float]
) -> list[float]:
    """Residuals and entries by the programs of the kernel, as the runtime runs them."""
    group = function.group
    whole = [
        on_numbers(one.entity.refresh, [*map(float, state), *[0.0] * one.entity.tangent])
        for one, state in zip(function.sets, states, strict=True)
    ]
    prepared = on_numbers(group.prepare, raw)
    inputs = [*(whole[use][offset] for use, offset in group.states), *prepared]
    return on_numbers(group.tape, inputs)


@pytest.mark.parametrize("name", ["pose_graph_3d", "bundle_adjustment", "localization"])
def test_same_bits_as_the_programs_of_the_kernels(name: str, tmp_path: Path) -> None:
    """Each operation is the same, in the same order: the same bits on this machine."""
    compare_bits(MODELS / "models" / f"{name}.arael", tmp_path)


ALL = [*(MODELS / "models").glob("*.arael"), *(MODELS / "examples").glob("*/*.arael")]
COMPLETE = sorted(
    path
    for path in ALL
    if re.search("^root ", path.read_text(), re.MULTILINE)
    and "extern fn" not in path.read_text()  # the caller defines what it computes
    # Look-ups and what holds exactly are refused.
    and not re.search(r"\.(at|rate|acceleration)\(|^\s*require ", path.read_text(), re.MULTILINE)
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "path", COMPLETE, ids=[f"{path.parent.name}-{path.stem}" for path in COMPLETE]
)
def test_every_standard_model_and_example(path: Path, tmp_path: Path) -> None:
    compare_bits(path, tmp_path)


def compare_bits(path: Path, folder: Path) -> None:
    """Residuals and Jacobians at random arguments, against the programs on Python's numbers."""
    library = Library(export(path, precision="f64"), folder)
    program = compile_text(read_source(path), precision="f64").program
    functions = library.project.functions
    rng = np.random.default_rng(5)
    for function, kernel in zip(functions.constraints, program.kernels, strict=True):
        group = function.group
        for _ in range(3):
            states = [rng.uniform(0.1, 0.9, one.entity.stored) for one in function.sets]
            data = [rng.uniform(0.1, 0.9, one.array.size) for one in function.data]
            slots = {one.slot: values for one, values in zip(function.data, data, strict=True)}
            raw = []
            for r in group.raw:
                table = group.slots[r.slot].table
                at = functions.arrays.offset(table, r.column, r.component)
                raw.append(float(slots[r.slot][at]) if r.slot in slots else 0.0)
            wanted = programs_at(kernel, function, states, raw)
            active, residual, blocks = library.evaluate(function, states, data)
            if not active:
                assert group.guard is not None or group.moving_guard is not None
                continue
            np.testing.assert_array_equal(residual, wanted[: group.residuals])
            for (row, use, k), value in zip(group.jacobian, wanted[group.residuals :], strict=True):
                np.testing.assert_array_equal(blocks[use][row, k], value)


def test_retraction_and_local_coordinates_are_inverse(tmp_path: Path) -> None:
    path, model = filled(tmp_path)
    library = Library(export(path), tmp_path / "c")
    functions = library.project.functions
    one, rng = functions.constraints[0].sets[0], np.random.default_rng(2)
    name = f"{functions.prefix}{one.stored.name}"
    for stored in samples_of(functions, model)[0].states[0]:
        step = 0.3 * rng.normal(size=one.entity.tangent)
        moved, back = np.zeros(one.entity.stored), np.zeros(one.entity.tangent)
        library.call(f"{name}_retract", stored.copy(), step, moved)
        library.call(f"{name}_local", stored.copy(), moved, back)
        np.testing.assert_allclose(back, step, rtol=1e-10, atol=1e-13)
        place = stored.copy()
        library.call(f"{name}_retract", place, step, place)
        np.testing.assert_array_equal(place, moved)


def test_single_precision(tmp_path: Path) -> None:
    line = arael.load("linear", interpret=True)(sigma=0.5, a=0.3, b=-0.2)
    line.data.extend(x=[0.0, 1.0, 2.0], y=[1.0, 3.0, 5.5])
    library = Library(export("linear", data=line), tmp_path)
    assert library.project.functions.real == "float"
    assert check_against_model(library, line, 3e-6, 1e-6) == 3


def test_main_prints_the_first_rows_of_the_data(tmp_path: Path) -> None:
    path, model = filled(tmp_path)
    project = export(path, data=model, constraint="Link.between")
    project.write(tmp_path / "c")
    subprocess.run(
        [compiler(), "-std=c99", "main.c", "everything.c", "-o", "main", "-lm"],
        cwd=tmp_path / "c",
        check=True,
    )
    printed = subprocess.run(
        [tmp_path / "c" / "main"], check=True, capture_output=True, text=True
    ).stdout
    rows = [row for row in model.jacobian() if row.label == "Link.between"]
    residual = [float(v) for v in printed.split("residual\n")[1].splitlines()[0].split()]
    np.testing.assert_allclose(residual, [row.residual for row in rows[:3]], rtol=1e-12)
    assert printed.count("Link.between[") == 2


def test_native_functions_are_declared(tmp_path: Path) -> None:
    path = tmp_path / "native.arael"
    path.write_text(
        "extern fn drag(v) derivs [2 * v]\n"
        "root M { param v: real = 1; constraint c { drag(v) - 2 } }\n"
    )
    text = export(path).files["native.h"]
    assert "double native_drag(double v);" in text


def test_public_graph(tmp_path: Path) -> None:
    graph = arael.load("pose_graph_2d", interpret=True)()
    arael.read(graph, public("pose_graph_2d/intel.g2o"))
    library = Library(export("pose_graph_2d", data=graph), tmp_path)
    assert check_against_model(library, graph, 1e-12, 1e-12) > 7000


def test_repr_and_files() -> None:
    project = arael.export("pose_graph_2d")
    assert isinstance(project, Export)
    assert list(project.files) == [
        "pose_graph_2d.h",
        "pose_graph_2d.c",
        "main.c",
        "CMakeLists.txt",
    ]
    assert repr(project).startswith("Export(to='c'")


def test_residuals_from_python_are_refused_by_name(tmp_path: Path) -> None:
    path, model = filled(tmp_path)
    model.add_residuals(lambda scale: scale - 1, [model.scale], size=1, name="by_hand")
    with pytest.raises(AraelError, match="added from Python: by_hand"):
        export(path, data=model)
    with pytest.raises(AraelError, match=r"no constraint `Link.betwen`"):
        export(path, constraint="Link.betwen")


def test_sums_over_lists_of_any_length_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "sums.arael"
    path.write_text(
        "struct Part { param a: real = 1; b: real = 2 }\n"
        "root Sums { parts: list of Part; constraint all { sum(p in parts) { sin(p.a * p.b) } } }\n"
    )
    with pytest.raises(AraelError, match=r"E1501.*`Sums.all` sums over a list term by term"):
        export(path)


def test_look_ups_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "table.arael"
    path.write_text(
        "struct Fix { key t; t: real; x: real }\n"
        "root Table { fixes: list of Fix; param p: real = 1\n"
        "    constraint c { fixes.at(p, x) } }\n"
    )
    with pytest.raises(AraelError, match=r"E1501.*`Table.c` looks rows up"):
        export(path)
