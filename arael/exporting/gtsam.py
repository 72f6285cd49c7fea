"""Factors of GTSAM 4.3 that call the exported C functions, on its own types of poses and points."""

from __future__ import annotations

from dataclasses import dataclass

from arael.diagnostics.records import AraelError, Diagnostic
from arael.exporting.arrays import ParameterSet
from arael.exporting.c_functions import ConstraintFunction, Functions
from arael.exporting.cpp import class_name
from arael.exporting.statements import c_comment
from arael.runtime.layout import ParamUse


@dataclass(frozen=True)
class Value:
    """A parameter set as a value of GTSAM.

    Attributes
    ----------
    type : of GTSAM
    size : of its tangent
    stored : C++ expression of each stored scalar of the value `x`
    setup : statements before them
    step : non-zero entries (row, column, expression) of the derivative of arael's step by GTSAM's
    """

    type: str
    size: int
    stored: tuple[str, ...]
    setup: tuple[str, ...]
    step: tuple[tuple[int, int, str], ...]


def value_of(one: ParameterSet) -> Value:
    """How GTSAM holds a parameter set.

    Raises
    ------
    AraelError
        E1504: there is no value of GTSAM with these parameters.
    """
    uses = one.entity.params
    kinds = {use.kind: use for use in uses}
    shapes = sorted(f"{use.kind}{use.stored}" for use in uses)
    turn = kinds.get("quaternion") or kinds.get("rotation")
    if one.entity.updated:
        raise _refused(one, "its components update themselves after a step")
    if shapes == ["angle1", "vec2"]:
        return _pose2(kinds["vec"], kinds["angle"])
    if shapes == ["transform7"]:
        return _transform()
    if turn and sorted(shapes) == sorted(["vec3", f"{turn.kind}4"]):
        return _pose3(kinds["vec"], turn)
    if turn and len(uses) == 1:
        setup = ("const gtsam::Quaternion q = x.toQuaternion();",)
        return Value("gtsam::Rot3", 3, _QUATERNION, setup, _unit(0, 0, 3))
    if shapes in (["vec2"], ["vec3"]):
        n = uses[0].stored
        stored = tuple(f"x[{k}]" for k in range(n))
        return Value(f"gtsam::Point{n}", n, stored, (), _unit(0, 0, n))
    if all(use.kind in ("real", "vec", "euler", "angle") for use in uses):
        n = one.entity.stored
        stored = tuple(f"x[{k}]" for k in range(n))
        return Value("gtsam::Vector", n, stored, (), _unit(0, 0, n))
    types = ", ".join(use.kind for use in uses)
    raise _refused(one, f"GTSAM has no value of {types}")


_QUATERNION = ("q.w()", "q.x()", "q.y()", "q.z()")


def _unit(row: int, column: int, size: int) -> tuple[tuple[int, int, str], ...]:
    return tuple((row + k, column + k, "1.0") for k in range(size))


def _rotated(row: int, column: int, size: int) -> tuple[tuple[int, int, str], ...]:
    """A step in the frame of the body, GTSAM's, as one in the world: by the rotation matrix."""
    return tuple((row + i, column + k, f"r({i}, {k})") for i in range(size) for k in range(size))


def _pose2(t: ParamUse, angle: ParamUse) -> Value:
    stored = [""] * 3
    stored[t.stored_start : t.stored_start + 2] = ["x.x()", "x.y()"]
    stored[angle.stored_start] = "x.theta()"
    step = (*_rotated(t.tangent_start, 0, 2), (angle.tangent_start, 2, "1.0"))
    setup = ("const gtsam::Matrix2 r = x.rotation().matrix();",)
    return Value("gtsam::Pose2", 3, tuple(stored), setup, step)


def _pose3(t: ParamUse, turn: ParamUse) -> Value:
    """Rotation first in GTSAM's tangent, and both in the body."""
    stored = [""] * 7
    point = ["x.translation().x()", "x.translation().y()", "x.translation().z()"]
    stored[t.stored_start : t.stored_start + 3] = point
    stored[turn.stored_start : turn.stored_start + 4] = _QUATERNION
    step = (*_unit(turn.tangent_start, 0, 3), *_rotated(t.tangent_start, 3, 3))
    setup = (
        "const gtsam::Quaternion q = x.rotation().toQuaternion();",
        "const gtsam::Matrix3 r = x.rotation().matrix();",
    )
    return Value("gtsam::Pose3", 6, tuple(stored), setup, step)


def _transform() -> Value:
    """The same twist, with translation and rotation exchanged."""
    point = ("x.translation().x()", "x.translation().y()", "x.translation().z()")
    setup = ("const gtsam::Quaternion q = x.rotation().toQuaternion();",)
    step = (*_unit(0, 3, 3), *_unit(3, 0, 3))
    return Value("gtsam::Pose3", 6, (*point, *_QUATERNION), setup, step)


def _refused(one: ParameterSet, reason: str) -> AraelError:
    return AraelError(
        Diagnostic(
            "E1504",
            f"{one.stored.title} cannot be values of GTSAM: {reason}",
            help=("export to c or ceres, or leave out with --constraint what reads them",),
        )
    )


def gtsam_header(functions: Functions) -> str:
    """Text of the header with the factors."""
    p = functions.prefix.removesuffix("_")
    guard = f"{p.upper()}_GTSAM_H"
    values = {one.number: value_of(one) for one in functions.used}
    lines = [
        f"// Factors for GTSAM 4.3 of the model in {p}.h.",
        f"#ifndef {guard}",
        f"#define {guard}",
        "",
        "#include <algorithm>",
        "#include <array>",
        "#include <memory>",
        "",
        "#include <gtsam/geometry/Pose2.h>",
        "#include <gtsam/geometry/Pose3.h>",
        "#include <gtsam/nonlinear/NonlinearFactor.h>",
        "",
        f'#include "{p}.h"',
        "",
        f"namespace {p} {{",
        "",
    ]
    for one in functions.used:
        lines += _value(one, values[one.number])
    for function in functions.constraints:
        lines += _factor(function, values, p)
    return "\n".join([*lines, f"}}  // namespace {p}", "", "#endif"]) + "\n"


def _value(one: ParameterSet, value: Value) -> list[str]:
    """Functions that convert a value and its tangent."""
    name, n = one.stored.name, one.entity.tangent
    read = " ".join((*value.stored, *(text for _, _, text in value.step)))
    used = [line for line in value.setup if f"{line.split(' = ')[0][-1]}." in read]
    used_by_step = [line for line in value.setup if "r(" in read and " r = " in line]
    entries = [f"  j({row}, {column}) = {text};" for row, column, text in value.step]
    return [
        f"// {c_comment(one.stored.title)}: stored scalars of a value of GTSAM.",
        f"inline std::array<double, {one.entity.stored}> {name}_stored(const {value.type}& x) {{",
        *(f"  {line}" for line in used),
        f"  return {{{', '.join(value.stored)}}};",
        "}",
        "",
        "// Derivative of arael's step by GTSAM's.",
        f"inline Eigen::Matrix<double, {n}, {value.size}> {name}_step(const {value.type}& x) {{",
        "  (void)x;",
        *(f"  {line}" for line in used_by_step),
        f"  Eigen::Matrix<double, {n}, {value.size}> j;",
        "  j.setZero();",
        *entries,
        "  return j;",
        "}",
        "",
    ]


def _factor(function: ConstraintFunction, values: dict[int, Value], p: str) -> list[str]:
    group, sets = function.group, function.sets
    r, name = group.residuals, class_name(function.name.removeprefix(f"{p}_"))
    types = [values[one.number].type for one in sets]
    base = f"gtsam::NoiseModelFactorN<{', '.join(types)}>"
    names = [one.name for one in function.states]
    keys = ", ".join(f"gtsam::Key {one}" for one in names)
    data = "".join(f", const double* {one.name}" for one in function.data)
    parameters = [f"const {kind}& {one}" for kind, one in zip(types, names, strict=True)]
    parameters += [f"gtsam::OptionalMatrixType H{k + 1}" for k in range(len(sets))]
    arguments = [
        f"{one.stored.name}_stored({x}).data()" for one, x in zip(sets, names, strict=True)
    ]
    arguments += [f"{one.name}_.data()" for one in function.data]
    arguments.append("residual.data()")
    arguments += [f"H{k + 1} ? tangent_{k}.data() : nullptr" for k in range(len(sets))]
    lines = [
        f"// {c_comment(group.label)}: whitened, so its noise model is the unit matrix.",
        f"class {name} : public {base} {{",
        f"  using Base = {base};",
        *(f"  std::array<double, {one.array.size}> {one.name}_;" for one in function.data),
        "",
        " public:",
        "  using Base::evaluateError;",
        f"  {name}({keys}{data})",
        f"      : Base(gtsam::noiseModel::Unit::Create({r}), {', '.join(names)}) {{",
        *(
            f"    std::copy({one.name}, {one.name} + {one.array.size}, {one.name}_.begin());"
            for one in function.data
        ),
        "  }",
        "",
        "  gtsam::NonlinearFactor::shared_ptr clone() const override {",
        f"    return std::make_shared<{name}>(*this);",
        "  }",
        "",
        f"  gtsam::Vector evaluateError({', '.join(parameters)}) const override {{",
        f"    gtsam::Vector residual({r});",
    ]
    for k, one in enumerate(sets):
        order = ", Eigen::RowMajor" * (one.entity.tangent > 1)
        lines.append(f"    Eigen::Matrix<double, {r}, {one.entity.tangent}{order}> tangent_{k};")
    lines.append(f"    {function.name}({', '.join(arguments)});")
    for k, (one, x) in enumerate(zip(sets, names, strict=True)):
        lines.append(f"    if (H{k + 1}) *H{k + 1} = tangent_{k} * {one.stored.name}_step({x});")
    return [*lines, "    return residual;", "  }", "};", ""]
