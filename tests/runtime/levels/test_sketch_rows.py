"""Rows of `models/sketch.arael`: meaning, derivatives, scale, rank, degenerate drawings."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows
from tests.runtime.levels.sketch_formulas import ANGLES, FORMULAS, POWERS, PURE, Values

STRUCTS = sorted(FORMULAS)
Array = NDArray[Any]
BEZIER = np.array([[1, -3, 3, -1], [0, 3, -6, 3], [0, 0, 3, -3], [0, 0, 0, 1]], dtype=float)


@functools.cache
def model() -> Any:
    return load_compiled("sketch", interpret=True)


class Sample:
    """One instance of a struct, with values of its own for all refs and fields."""

    def __init__(self, struct: str, seed: int = 0, wobble: float = 1.0) -> None:
        rng = np.random.default_rng([seed, *struct.encode()])
        found = KernelRows(model().layout).tables[struct]
        self.struct, self.refs, self.widths = struct, found.refs, found.widths
        self.fields, self.residuals = found.fields, found.residuals
        self.x = np.concatenate(
            [
                rng.normal(scale=2, size=2)
                if width == 2
                else rng.uniform(0.3, 0.9, 1)
                if name.startswith(("rot", "t"))
                else rng.uniform(1, 2, 1)
                for name, width in zip(self.refs, self.widths, strict=True)
            ]
        )
        self.at = np.concatenate([[0], np.cumsum(self.widths)[:-1]])
        self.data = {
            name: {
                "side": float(rng.choice([-1, 1])),
                "factor": 2 / 3,
                "factor_p": 1 / 3,
                "factor_q": 2 / 3,
                "weight": 1.0,
            }.get(name, float(rng.uniform(0.4, 1.4)))
            for name in self.fields
        }
        for k, value in enumerate(BEZIER.ravel()):
            if f"basis[{k}]" in self.data:
                self.data[f"basis[{k}]"] = value
        self.rows = KernelRows(model().layout, n=len(self.x))
        self.row = self.rows.add(struct, self.at, self.data)

    def values(self, x: Array) -> Values:
        found: Values = {
            name: complex(x[at], x[at + 1]) if width == 2 else float(x[at])
            for name, at, width in zip(self.refs, self.at, self.widths, strict=True)
        }
        for name, value in self.data.items():
            head, indexed, _ = name.partition("[")
            if indexed:
                found.setdefault(head, []).append(value)
            else:
                found[name] = value
        return found

    def formula(self, x: Array) -> Array:
        found = np.atleast_1d(np.asarray(FORMULAS[self.struct](self.values(x)), dtype=float))
        return found * self.data["weight"]

    def set(self, **data: float) -> None:
        for name, value in data.items():
            self.data[name] = value
            self.rows.set_data(self.row, name, value)

    def jacobian(self, x: Array) -> Array:
        return dense(self.rows, x)

    def differences(self, x: Array) -> Array:
        """Derivatives of the formula, to fourth order."""
        columns = []
        for k in range(len(x)):
            step = np.zeros(len(x))
            step[k] = 1e-3 * max(abs(x[k]), 0.1)
            one, two = (self.formula(x + m * step) - self.formula(x - m * step) for m in (1.0, 2.0))
            columns.append((8 * one - two) / (12 * step[k]))
        return np.array(columns).T

    def solved(self) -> Array:
        """The nearest drawing on which the equations hold, by steps of least norm."""
        x = self.x.copy()
        for _ in range(100):
            r = self.rows.evaluate(x)
            if np.abs(r).max() < 1e-13:
                return x
            step = -np.linalg.pinv(self.jacobian(x)) @ r
            x += step * min(1, 0.5 / np.abs(step).max())
        raise AssertionError(f"{self.struct} cannot be solved: {r}")


def dense(rows: KernelRows, x: Array) -> Array:
    _, entries = rows.jacobian(x)
    found = np.zeros((rows.m, rows.n))
    found[np.repeat(np.arange(rows.m), np.diff(rows.indptr)), rows.indices] = entries
    return found


def test_every_struct_has_a_formula() -> None:
    assert set(KernelRows(model().layout).tables) == set(FORMULAS)


@pytest.mark.sweep(3)
@pytest.mark.parametrize("struct", STRUCTS)
def test_residuals_are_those_of_the_formula(struct: str) -> None:
    for seed in range(6):
        sample = Sample(struct, seed)
        for x in drawings(sample):
            if near_a_jump(sample, x):
                continue
            sample.set(weight=1.0 + seed)
            expected = sample.formula(x)
            assert sample.rows.evaluate(x) == pytest.approx(expected, rel=1e-9, abs=1e-9)


def drawings(sample: Sample) -> list[Array]:
    """Random, mirrored, turned by a quarter, and rounded to a grid that no point shares."""
    points = [at for at, width in zip(sample.at, sample.widths, strict=True) if width == 2]
    mirrored, turned, grid = sample.x.copy(), sample.x.copy(), sample.x.copy()
    for k, at in enumerate(points):
        mirrored[at] *= -1
        turned[at], turned[at + 1] = -sample.x[at + 1], sample.x[at]
        near = np.clip(np.round(sample.x[at : at + 2]), -1, 1)
        grid[at : at + 2] = near + np.array([4 * (k % 3), 4 * (k // 3)])
    return [sample.x, mirrored, turned, grid]


@pytest.mark.sweep(3)
@pytest.mark.parametrize("struct", STRUCTS)
def test_entries_are_derivatives_of_the_formula(struct: str) -> None:
    for seed in range(2):
        sample = Sample(struct, seed)
        for x in drawings(sample):
            if near_a_jump(sample, x):
                continue
            expected = sample.differences(x)
            assert sample.jacobian(x) == pytest.approx(expected, rel=1e-5, abs=1e-5)


def near_a_jump(sample: Sample, x: Array) -> bool:
    """Whether an angle is so near to where it starts anew that differences are not derivatives."""
    turned = np.abs(sample.differences(x)).max(initial=0)
    return bool(turned > 50)


@pytest.mark.sweep(3)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
@pytest.mark.parametrize("struct", STRUCTS)
def test_residuals_scale_with_the_drawing(struct: str, scale: float) -> None:
    sample = Sample(struct)
    power = POWERS.get(struct, 1)
    before, slopes = sample.rows.evaluate(sample.x), sample.jacobian(sample.x)
    lengths = np.array([name.split("_")[0] not in PURE for name in sample.refs])
    stretch = np.repeat(np.where(lengths, scale, 1.0), sample.widths)
    for name, value in list(sample.data.items()):
        head = name.partition("[")[0]
        if head in PURE or (head == "value" and struct in ANGLES):
            continue
        sample.set(**{name: value * scale ** (power if head == "value" else 1)})
    x = sample.x * stretch
    assert sample.rows.evaluate(x) == pytest.approx(before * scale**power, rel=1e-9)
    expected = slopes * scale**power / stretch
    assert sample.jacobian(x) == pytest.approx(
        expected, rel=1e-7, abs=1e-9 * np.abs(expected).max()
    )


@pytest.mark.parametrize("struct", sorted(set(STRUCTS) - {"Lock", "LineArea"}))
def test_residuals_do_not_depend_on_the_place(struct: str) -> None:
    sample = Sample(struct)
    shift = np.concatenate([[4096.0, -512.0] if w == 2 else [0.0] for w in sample.widths])
    before, after = sample.rows.evaluate(sample.x), sample.rows.evaluate(sample.x + shift)
    assert after == pytest.approx(before, abs=1e-10)


EQUATIONS = sorted(s for s in STRUCTS if not s.endswith("Guard"))


@pytest.mark.sweep(3)
@pytest.mark.parametrize("struct", EQUATIONS)
def test_rows_are_independent_and_of_unit_size_where_they_hold(struct: str) -> None:
    for seed in range(3):
        sample = Sample(struct, seed)
        if "value" in sample.fields and struct in POWERS:
            quantity = sample.rows.evaluate(sample.x)[0] + sample.data["value"]
            sample.set(value=0.9 * float(quantity))
        x = sample.solved()
        singular = np.linalg.svd(sample.jacobian(x), compute_uv=False)
        assert len(singular) == sample.residuals
        # What is no length has other units, and areas and curvatures are as small as they are.
        assert singular.min() > (1e-3 if struct in POWERS else 0.02)
        assert singular.max() < 50


# Degrees of freedom that constraints of a sketch take: instances, and helper unknowns by name.
TAKES = {
    "tangent of a line and an ellipse": (1, ["TangentLineEllipse"], []),
    "tangent of two ellipses": (
        1,
        ["PointOnEllipse:p c1 x1 y1 o1", "PointOnEllipse:p c2 x2 y2 o2",
         "TangentEllipses:p c1 x1 y1 o1 c2 x2 y2 o2"],
        ["p"],
    ),
    "tangent of an ellipse and a circle": (
        1,
        ["PointOnEllipse:p c1 x1 y1 o1", "PointOnCircle:p c2 r2",
         "EllipseNormalAlong:p c1 x1 y1 o1 c2 p"],
        ["p"],
    ),
    "point on a spline": (1, ["PointOnCubic:p p0 p1 p2 p3 t"], ["t"]),
    "tangent of a line and a spline": (
        1,
        ["PointOnCubic:q p0 p1 p2 p3 t", "PointLineDistance:q a b",
         "CubicTangentAlong:p0 p1 p2 p3 t a b"],
        ["q", "t"],
    ),
    "symmetry of two arcs": (3, ["SymmetricPoints:c1 c2 a b", "Difference:x1 x2"], []),
    "arc": (2, ["PointOnCircle:s c r", "PointOnCircle:e c r"], []),
    "tangent line and arc at their common end": (1, ["Perpendicular:a b c b"], []),
}  # fmt: skip


@pytest.mark.parametrize("name", TAKES)
def test_constraints_take_as_many_freedoms_as_the_table_says(name: str) -> None:
    takes, instances, helpers = TAKES[name]
    rows = KernelRows(model().layout, n=200)
    at: dict[str, int] = {}
    widths: dict[str, int] = {}
    end = 0
    for text in instances:
        struct, _, named = text.partition(":")
        table = rows.tables[struct]
        uses = []
        for one, width in zip(named.split() or table.refs, table.widths, strict=True):
            if one not in at:
                at[one], widths[one], end = end, width, end + width
            assert widths[one] == width
            uses.append(at[one])
        data = {"side": 1.0} if "side" in table.fields else {}
        basis = {f"basis[{k}]": v for k, v in enumerate(BEZIER.ravel())}
        rows.add(struct, uses, data | (basis if "basis[0]" in table.fields else {}))
    x = np.abs(np.random.default_rng(3).normal(size=200)) + 0.5
    jacobian = dense(rows, x)
    rank = np.linalg.matrix_rank
    hidden = [k for one in helpers for k in range(at[one], at[one] + widths[one])]
    assert rank(jacobian) == len(jacobian)
    assert rank(jacobian) - (rank(jacobian[:, hidden]) if hidden else 0) == takes


@pytest.mark.parametrize("struct", STRUCTS)
def test_collapsed_geometry_gives_finite_rows(struct: str) -> None:
    sample = Sample(struct)
    for spread in (0.0, 1e-12, 1e-200):
        r, entries = sample.rows.jacobian(sample.x * spread)
        assert np.isfinite(r).all()
        assert np.isfinite(entries).all()


def test_a_distance_of_coinciding_points_has_a_direction() -> None:
    sample = Sample("Distance")
    assert np.abs(sample.jacobian(np.zeros(4))).max() == 1


@pytest.mark.parametrize(
    ("struct", "value"), [("Distance", 5.0), ("ScalarValue", 5.0), ("ArcLength", 5.0)]
)
def test_with_value_0_a_row_is_the_quantity(struct: str, value: float) -> None:
    sample = Sample(struct)
    sample.set(value=0.0)
    quantity = sample.rows.evaluate(sample.x)
    sample.set(value=value)
    assert sample.rows.evaluate(sample.x) == pytest.approx(quantity - value)


def test_a_sweep_guard_changes_its_sign_where_the_arc_turns_inside_out() -> None:
    rows = KernelRows(model().layout, n=6)
    small = rows.add("SweepGuard", [0, 2, 4], {"side": 1})
    large = rows.add("SweepGuard", [0, 2, 4], {"side": -1})

    def at(degrees: float) -> Array:
        a = np.deg2rad(degrees)
        return np.asarray(rows.evaluate([0, 0, 1, 0, np.cos(a), np.sin(a)]))

    assert all(at(d)[small] > 0 for d in (1, 90, 179, 181, 250))
    assert all(at(d)[large] > 0 for d in (359, 270, 181, 179, 110))
    assert at(-1)[small] < 0
    assert at(361)[large] < 0


def test_area_of_a_closed_chain_is_the_sum_of_its_rows() -> None:
    # A half disc of radius 2 over a rectangle 4 x 3, counter-clockwise.
    x = np.array([-2, 0, -2, -3, 2, -3, 2, 0, 0, 0, 2.0])
    rows = KernelRows(model().layout, n=len(x))
    for a, b in ((0, 2), (2, 4), (4, 6), (6, 0)):
        rows.add("LineArea", [a, b])
    rows.add("ArcArea", [8, 6, 0, 10], {"side": 1})
    assert rows.evaluate(x).sum() == pytest.approx(12 + 2 * np.pi)


def test_curvature_of_a_bezier_is_that_of_its_second_derivative() -> None:
    poles = np.array([[0, 0], [1, 0.5], [2, 2], [2, 4.0]])
    first = 3 * (poles[1] - poles[0])
    second = 6 * (poles[2] - 2 * poles[1] + poles[0])
    expected = (first[0] * second[1] - first[1] * second[0]) / np.hypot(*first) ** 3
    rows = KernelRows(model().layout, n=6)
    rows.add("SplineCurvature", [0, 2, 4], {"factor": 2 / 3})
    assert rows.evaluate(poles[:3].ravel()) == pytest.approx([expected])


def test_curvature_of_a_clamped_b_spline_has_half_the_factor() -> None:
    from scipy.interpolate import BSpline

    poles = np.array([[0, 0], [1, 0.5], [2, 2], [2, 4], [3, 5], [4, 4.0]])
    curve = BSpline([0, 0, 0, 0, 1, 2, 3, 3, 3, 3], poles, 3)
    first, second = curve(0, 1), curve(0, 2)
    expected = (first[0] * second[1] - first[1] * second[0]) / np.hypot(*first) ** 3
    rows = KernelRows(model().layout, n=6)
    rows.add("SplineCurvature", [0, 2, 4], {"factor": 1 / 3})
    assert rows.evaluate(poles[:3].ravel()) == pytest.approx([expected])


def test_the_table_of_the_documentation_lists_the_structs_as_they_are() -> None:
    page = Path(__file__).parents[3] / "docs" / "internals" / "sketch_rows.md"
    listed = {}
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("| `"):
            struct, refs, fields, residuals = (cell.strip() for cell in line.split("|")[1:5])
            listed[struct.strip("`")] = refs, fields, residuals
    found = {}
    for struct, table in KernelRows(model().layout).tables.items():
        refs = " ".join(
            name if width == 2 else f"*{name}*"
            for name, width in zip(table.refs, table.widths, strict=True)
        )
        heads = dict.fromkeys(f.partition("[")[0] for f in table.fields if f != "weight")
        found[struct] = refs, " ".join(heads) or "-", str(table.residuals)
    assert listed == found


def test_kernels_and_expression_machine_give_the_same_rows() -> None:
    shipped = load_compiled("sketch")
    for struct in STRUCTS:
        sample = Sample(struct)
        rows = KernelRows(shipped.layout, shipped.kernels, len(sample.x))
        for _ in range(11):  # more than one block of lanes, the last one not full
            rows.add(struct, sample.at, sample.data)
        r, jacobian = rows.evaluate(sample.x), dense(rows, sample.x)
        expected = sample.rows.evaluate(sample.x), sample.jacobian(sample.x)
        assert r == pytest.approx(np.tile(expected[0], 11), rel=1e-12, abs=1e-12)
        assert jacobian == pytest.approx(np.tile(expected[1], (11, 1)), rel=1e-11, abs=1e-11)
