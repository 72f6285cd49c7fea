"""Cost functions and manifolds of Ceres that call the exported C functions; a problem of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError, Diagnostic
from arael.exporting.arrays import ParameterSet
from arael.exporting.c_functions import ConstraintFunction, Functions
from arael.exporting.cpp import class_name
from arael.exporting.program import tangent_programs
from arael.exporting.rows import Rows
from arael.exporting.statements import Statements, c_comment
from arael.symbolic.c import c_literal


class CeresProject:
    """The header and the main program of a project for Ceres.

    Ceres wants derivatives by the stored scalars, and multiplies them by the derivative P of the
    manifold's Plus. The exported functions have derivatives J by the tangent; J M with the
    derivative M of Minus gives the same product, since M P = I.

    Parameters
    ----------
    functions : of the model, in f64
    rows : names of counts and refs
    """

    def __init__(self, functions: Functions, rows: Rows) -> None:
        self.functions, self.rows = functions, rows
        self.prefix = functions.prefix.removesuffix("_")

    def header(self, head: str) -> str:
        """Text of the header: manifolds, cost functions, the problem."""
        p = self.prefix
        guard = f"{p.upper()}_CERES_H"
        lines = [
            head,
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            "#include <algorithm>",
            "#include <array>",
            "#include <cmath>",
            "#include <vector>",
            "",
            "#include <ceres/ceres.h>",
            "",
            f'#include "{p}.h"',
            "",
            f"namespace {p} {{",
            "",
            *_PRODUCT,
            "",
        ]
        for one in self.functions.used:
            lines += self._manifold(one)
        for function in self.functions.constraints:
            lines += self._cost_function(function)
        lines += [*self._model(), *self._build()]
        return "\n".join([*lines, f"}}  // namespace {p}", "", "#endif"]) + "\n"

    def _manifold(self, one: ParameterSet) -> list[str]:
        """The manifold of an entity, and its derivative of Minus for the cost functions."""
        name, p = one.stored.name, self.prefix
        n, k = one.entity.stored, one.entity.tangent
        plus, minus = tangent_programs(one.entity)
        lines = []
        for title, tape, size in (("plus", plus, n * k), ("minus", minus, k * n)):
            written = Statements(tape, [f"x[{i}]" for i in range(n)])
            written.write(range(len(tape.ops)))
            stores = [f"j[{i}] = {written.value(node)};" for i, node in enumerate(tape.outputs)]
            what = f"{n} x {k}" if title == "plus" else f"{k} x {n}"
            lines += [
                f"// Derivative of {title.capitalize()} at x, {what}, row by row.",
                f"inline void {name}_{title}_jacobian(const double* x, double (&j)[{size}]) {{",
                "  (void)x;",
                *(f"  {line}" for line in [*written.lines, *stores]),
                "}",
                "",
            ]
        if one.entity.plain:
            return lines
        kind = class_name(name)
        return [
            *lines,
            f"// {c_comment(one.stored.title)}: {n} scalars, a step of {k}.",
            f"class {kind}Manifold : public ceres::Manifold {{",
            " public:",
            f"  int AmbientSize() const override {{ return {n}; }}",
            f"  int TangentSize() const override {{ return {k}; }}",
            "  bool Plus(const double* x, const double* delta, double* moved) const override {",
            f"    {p}_{name}_retract(x, delta, moved);",
            "    return true;",
            "  }",
            "  bool PlusJacobian(const double* x, double* jacobian) const override {",
            f"    double j[{n * k}];",
            f"    {name}_plus_jacobian(x, j);",
            "    std::copy(std::begin(j), std::end(j), jacobian);",
            "    return true;",
            "  }",
            "  bool Minus(const double* y, const double* x, double* step) const override {",
            f"    {p}_{name}_local(x, y, step);",
            "    return true;",
            "  }",
            "  bool MinusJacobian(const double* x, double* jacobian) const override {",
            f"    double j[{n * k}];",
            f"    {name}_minus_jacobian(x, j);",
            "    std::copy(std::begin(j), std::end(j), jacobian);",
            "    return true;",
            "  }",
            "};",
            "",
        ]

    def _cost_function(self, function: ConstraintFunction) -> list[str]:
        group = function.group
        kind = class_name(function.name.removeprefix(f"{self.prefix}_"))
        r = group.residuals
        sizes = ", ".join(str(one.entity.stored) for one in function.sets)
        members = [f"  std::array<double, {one.array.size}> {one.name}_;" for one in function.data]
        parameters = ", ".join(f"const double* {one.name}" for one in function.data)
        copies = [
            f"    std::copy({one.name}, {one.name} + {one.array.size}, {one.name}_.begin());"
            for one in function.data
        ]
        blocks = [
            f"    double tangent_{k}[{r * one.entity.tangent}];"
            for k, one in enumerate(function.sets)
        ]
        wanted = [
            f"jacobians && jacobians[{k}] ? tangent_{k} : nullptr"
            for k in range(len(function.sets))
        ]
        arguments = [f"parameters[{k}]" for k in range(len(function.sets))]
        arguments += [f"{one.name}_.data()" for one in function.data]
        lines = [
            f"// {c_comment(group.label)}: data is copied.",
            f"class {kind} : public ceres::SizedCostFunction<{r}, {sizes}> {{",
            " public:",
            f"  {'explicit ' * (len(function.data) == 1)}{kind}({parameters}) {{",
            *copies,
            "  }",
            "  bool Evaluate(double const* const* parameters, double* residuals,",
            "                double** jacobians) const override {",
            *blocks,
            f"    {function.name}({', '.join([*arguments, 'residuals', *wanted])});",
        ]
        for k, one in enumerate(function.sets):
            n, t = one.entity.stored, one.entity.tangent
            lines += [
                f"    if (jacobians && jacobians[{k}]) {{",
                f"      double minus[{n * t}];",
                f"      {one.stored.name}_minus_jacobian(parameters[{k}], minus);",
                f"      multiply<{r}, {t}, {n}>(tangent_{k}, minus, jacobians[{k}]);",
                "    }",
            ]
        finite = f"    for (int i = 0; i < {r}; i++)"
        lines += [
            finite,
            "      if (!std::isfinite(residuals[i])) return false;",
            "    return true;",
        ]
        lines += ["  }", ""]
        if members:
            lines += [" private:", *members]
        return [*lines, "};", ""]

    def _model(self) -> list[str]:
        """A struct with all rows."""
        lines = ["// The rows of a model. A ref is the number of a row.", "struct Model {"]
        for one in self.functions.used:
            name = one.stored.name
            lines.append(f"  std::vector<std::array<double, {one.entity.stored}>> {name};")
            lines.append(f"  std::vector<bool> {name}_fixed;  // one a row, or empty")
        for path in self.rows.tables:
            for (table, _), name in self.rows.refs.items():
                if table == path:
                    lines.append(f"  std::vector<int> {name};")
            array = self.functions.arrays.data.get(path)
            if array is not None:
                lines.append(f"  std::vector<std::array<double, {array.size}>> {array.name};")
            if path:
                lines.append(f"  int {self.rows.names[path]}_count = 0;")
        return [*lines, "};", ""]

    def _build(self) -> list[str]:
        lines = [
            "// Adds all rows of `model` to `problem`, which changes its parameters. The cost of",
            "// Ceres is half of the sum of squares; robust losses are in the residuals.",
            "inline void build_problem(Model& model, ceres::Problem& problem) {",
        ]
        for one in self.functions.used:
            name, n = one.stored.name, one.entity.stored
            manifold = "" if one.entity.plain else f", new {class_name(name)}Manifold"
            lines += [
                f"  for (std::size_t row = 0; row < model.{name}.size(); row++) {{",
                f"    double* x = model.{name}[row].data();",
                f"    problem.AddParameterBlock(x, {n}{manifold});",
                f"    if (!model.{name}_fixed.empty() && model.{name}_fixed[row]) {{",
                "      problem.SetParameterBlockConstant(x);",
                "      continue;",
                "    }",
                *self._bounds(one),
                "  }",
            ]
        for function in self.functions.constraints:
            group = function.group
            kind = class_name(function.name.removeprefix(f"{self.prefix}_"))
            count = f"model.{self.rows.names[group.table]}_count" if group.table else "1"
            at, rows = self.rows.walk(group, "model.", "static_cast<std::size_t>")
            parameters = [
                f"model.{one.array.name}[{rows[one.slot]}].data()" for one in function.states
            ]
            data = [f"model.{one.array.name}[{rows[one.slot]}].data()" for one in function.data]
            lines += [
                f"  for (int i = 0; i < {count}; i++) {{  // {c_comment(group.label)}",
                *(f"    {line}" for line in at),
                *self._guarded(function, kind, parameters, data),
                "  }",
            ]
        return [*lines, "}", ""]

    def _guarded(
        self,
        function: ConstraintFunction,
        kind: str,
        parameters: Sequence[str],
        data: Sequence[str],
    ) -> list[str]:
        """Add a residual, unless a guard over data is false."""
        add = f"problem.AddResidualBlock(new {kind}({', '.join(data)}), nullptr"
        lines = [f"    {add}, {', '.join(parameters)});"]
        if function.group.guard is None:
            return lines
        r = function.group.residuals
        nulls = ", ".join("nullptr" for _ in function.sets)
        arguments = ", ".join([*parameters, *data, "residual", nulls])
        return [
            f"    double residual[{r}];",
            f"    if (!{function.name}({arguments})) continue;",
            *lines,
        ]

    def _bounds(self, one: ParameterSet) -> list[str]:
        lines = []
        table = self.functions.layout.table(one.entity.table)
        for use in one.entity.params:
            param = table.column(use.column).param
            for way, ends in (("Lower", param.low), ("Upper", param.high)) if param else ():
                for k, end in enumerate(ends):
                    if end is not None:
                        at = use.stored_start + k
                        value = c_literal(end)
                        lines.append(f"    problem.SetParameter{way}Bound(x, {at}, {value});")
        return lines

    def main(self, values: dict[str, np.ndarray[Any, Any]]) -> str:
        """Text of `main.cpp`, which solves the problem of the data."""
        p = self.prefix
        lines = [
            "// Solves the problem of the data file with Ceres, and prints the solution.",
            "#include <cstdio>",
            "",
            f'#include "{p}_ceres.h"',
            "",
            f"static {p}::Model data() {{",
            f"  {p}::Model model;",
        ]
        for name, value in self._whole_rows(values).items():
            lines += [
                f"  model.{name} = {line}" if not k else line
                for k, line in enumerate(_value(value))
            ]
        lines += [
            "  return model;",
            "}",
            "",
            "int main() {",
            f"  {p}::Model model = data();",
            "  ceres::Problem problem;",
            f"  {p}::build_problem(model, problem);",
            "  ceres::Solver::Options options;",
            "  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;",
            "  options.max_num_iterations = 200;",
            "  options.function_tolerance = 1e-12;",
            "  ceres::Solver::Summary summary;",
            "  ceres::Solve(options, &problem, &summary);",
            '  std::printf("status %d, cost %.17g -> %.17g\\n", !summary.IsSolutionUsable(),',
            "              2 * summary.initial_cost, 2 * summary.final_cost);",
        ]
        for one in self.functions.used:
            name = one.stored.name
            lines += [
                f"  for (std::size_t row = 0; row < model.{name}.size(); row++) {{",
                f'    std::printf("{name} %d", static_cast<int>(row));',
                f'    for (double x : model.{name}[row]) std::printf(" %.17g", x);',
                '    std::printf("\\n");',
                "  }",
            ]
        return "\n".join([*lines, "  return !summary.IsSolutionUsable();", "}"]) + "\n"

    def _whole_rows(
        self, values: dict[str, np.ndarray[Any, Any]]
    ) -> dict[str, np.ndarray[Any, Any]]:
        """Values with one fixed flag a row.

        Raises
        ------
        AraelError
            E1504: a row is fixed in part, which needs a manifold of its own.
        """
        found = dict(values)
        for one in self.functions.used:
            fixed = values[f"{one.stored.name}_fixed"]
            some, whole = fixed.any(axis=1), fixed.all(axis=1)
            if (some != whole).any():
                row = int(np.flatnonzero(some != whole)[0])
                raise AraelError(
                    Diagnostic(
                        "E1504",
                        f"row {row} of {one.stored.title} is fixed in part, and Ceres fixes "
                        "whole parameter blocks",
                        help=("fix the whole row, or none of it",),
                    )
                )
            found[f"{one.stored.name}_fixed"] = whole.astype(int)
        return found


_PRODUCT = [
    "// c = a b, row by row.",
    "template <int R, int T, int N>",
    "inline void multiply(const double* a, const double* b, double* c) {",
    "  for (int i = 0; i < R; i++)",
    "    for (int j = 0; j < N; j++) {",
    "      double sum = 0.0;",
    "      for (int k = 0; k < T; k++) sum += a[i * T + k] * b[k * N + j];",
    "      c[i * N + j] = sum;",
    "    }",
    "}",
]


def cmake_of(stem: str, has_main: bool) -> str:
    """Text of `CMakeLists.txt` for a library, and a main program that needs Ceres."""
    library = f"""cmake_minimum_required(VERSION 3.13)
project({stem} C CXX)

add_library({stem} STATIC {stem}.c)
target_include_directories({stem} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})
set_target_properties({stem} PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON)
if(NOT MSVC)
  target_compile_options({stem} PRIVATE -O2)
endif()
"""
    main = f"""
find_package(Ceres 2.1 REQUIRED)
add_executable({stem}_main main.cpp)
set_target_properties({stem}_main PROPERTIES CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON)
target_link_libraries({stem}_main PRIVATE {stem} Ceres::ceres)
"""
    return library + main * has_main


def _value(value: np.ndarray[Any, Any]) -> list[str]:
    """An array as the right side of an assignment, over several lines."""
    text = str if value.dtype.kind == "i" else c_literal
    if value.ndim == 0:
        return [f"{text(value.item())};"]
    if value.ndim == 1:
        rows = [
            ", ".join(text(v) for v in value[k : k + 8].tolist()) for k in range(0, len(value), 8)
        ]
        return ["{", *(f"      {row}," for row in rows), "  };"]
    rows = [", ".join(text(v) for v in row) for row in value.tolist()]
    return ["{{", *(f"      {{{{{row}}}}}," for row in rows), "  }};"]
