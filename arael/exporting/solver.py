"""A whole solver of fixed sizes in C99: no heap, no input or output, no globals that change."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.resources import files

from arael.diagnostics.records import AraelError, Diagnostic
from arael.exporting.arrays import ParameterSet
from arael.exporting.c_functions import ConstraintFunction, Functions
from arael.exporting.plan import Plan
from arael.exporting.rows import Rows
from arael.exporting.statements import c_comment
from arael.runtime.layout import LayoutPass, ParamUse
from arael.runtime.system import is_frozen
from arael.schedule import frozen_after
from arael.solving import frozen_by
from arael.symbolic.c import c_literal

PRECISION = {"double": 1e-9, "float": 1e-5}
"""Predicted decrease of the cost, relative to the cost, at which a solve ends by default."""

EPSILON = {"double": 2.220446049250313e-16, "float": 1.1920928955078125e-07}


class Solver:
    """The header and the source of a solver.

    Parameters
    ----------
    functions : evaluate the constraints
    plan : rows, blocks and pattern

    Attributes
    ----------
    rows : names of counts and refs
    """

    def __init__(self, functions: Functions, plan: Plan) -> None:
        self.functions, self.plan = functions, plan
        self.prefix = functions.prefix.removesuffix("_")
        self.upper = self.prefix.upper()
        self.real = functions.real
        self._passes = functions.layout.passes or (LayoutPass("solve"),)
        self._frozen = _frozen_by_pass(functions, self._passes)
        self.rows = Rows(functions, plan.rows)

    # -- header

    def header(self, head: str) -> str:
        """Text of the header."""
        rows = [
            f"#define {self.upper}_{self.rows.names[path].upper()}_ROWS {count}"
            for path, count in self.plan.rows.items()
            if path
        ]
        parameters = [f"    {self.real} {self._member(one)};" for one in self.functions.used]
        covariances = [f"int {self._covariance(one)};" for one in self.functions.used]
        return self._filled(
            "solver.h.in",
            HEAD="\n".join([head.removesuffix("*/"), *self._costs(), "*/"]),
            SCALARS=str(self.plan.scalars),
            BLOCKS=str(len(self.plan.sizes)),
            VALUES=str(self.plan.values),
            ROWS="\n".join(rows) or "/* There is none. */",
            PARAMETERS="\n".join(parameters),
            DATA="\n".join(self._data_members()),
            COVARIANCES="\n".join(covariances),
        )

    def _filled(self, name: str, **texts: str) -> str:
        """A template with its marks replaced."""
        single = self.real == "float"
        marks = {
            **texts,
            "U": self.upper,
            "P": self.prefix,
            "R": self.real,
            "ONE": c_literal(1.0, self.real),
            "ZERO": c_literal(0.0, self.real),
            "SQRT": "sqrtf" if single else "sqrt",
            "EPSILON": c_literal(EPSILON[self.real], self.real),
        }
        text = files("arael.exporting").joinpath(name).read_text(encoding="utf-8")
        for mark, value in marks.items():
            text = text.replace(f"@{mark}@", value)
        return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"

    def _costs(self) -> list[str]:
        """Operations and memory, for the head."""
        plan, size = self.plan, 4 if self.real == "float" else 8
        evaluation = 0
        for function in self.functions.constraints:
            tangents = [one.entity.tangent for one in function.sets]
            r, n = function.group.residuals, sum(tangents)
            once = function.program.tape.operations + 2 * r * n + r * n * (n + 1)
            evaluation += plan.rows[function.group.table] * once
        parameters = sum(
            one.entity.stored * plan.rows[one.entity.table] for one in self.functions.used
        )
        state = (2 * plan.values + 5 * plan.scalars + parameters) * size + plan.scalars
        return [
            f"   An iteration takes at most {evaluation + plan.flops} operations:",
            f"   {evaluation} to linearise, {plan.flops} to factorise and substitute.",
            f"   RAM of the workspace: {state} bytes, and padding.",
        ]

    def _member(self, one: ParameterSet) -> str:
        size = self.functions.macro(one.stored)
        return f"{one.stored.name}[{self.plan.rows[one.entity.table]}][{size}]"

    def _data_members(self) -> list[str]:
        lines = []
        for one in self.functions.used:
            if one.entity.tangent:
                shape = f"[{self.plan.rows[one.entity.table]}][{one.entity.tangent}]"
                lines.append(
                    f"    unsigned char {one.stored.name}_fixed{shape}; /* 1: it is fixed */"
                )
        for path, rows in self.plan.rows.items():
            if path:
                lines.append(f"    int {self.rows.names[path]}_count;")
            for (table, step), name in self.rows.refs.items():
                if table == path:
                    shown = "of its owner" if step.kind == "parent" else f"that `{step.ref}` names"
                    lines.append(f"    int {name}[{rows}]; /* row {c_comment(shown)} */")
            array = self.functions.arrays.data.get(path)
            if array is not None:
                size = self.functions.macro(array)
                lines.append(f"    {self.real} {array.name}[{rows}][{size}];")
        return lines

    def _covariance(self, one: ParameterSet) -> str:
        p, n = self.prefix, one.entity.tangent
        return (
            f"{p}_covariance_{one.stored.name}({p}_state *state, const {p}_data *data, int row, "
            f"{self.real} covariance[{n * n}])"
        )

    # -- source

    def source(self) -> str:
        """Text of the source."""
        return self._filled(
            "solver.c.in",
            TABLES="\n".join(self._tables()),
            MODEL="\n".join(
                [*self._evaluate(), *self._hold_fixed(), *self._bounds(), *self._retract()]
            ),
            SOLVE="\n".join(self._solve()),
        )

    def _tables(self) -> list[str]:
        plan = self.plan
        lines: list[str] = []
        for name, values in (
            ("POSITION", plan.position),
            ("SIZE", plan.sizes),
            ("FIRST", plan.first),
            ("COLUMN_START", plan.column_start),
            ("BLOCK_ROW", plan.block_row),
            ("VALUE_START", plan.value_start),
            ("UPDATE", plan.update or [0]),
        ):
            most = max(values)
            kind = "unsigned char" if most < 256 else "unsigned short" if most < 65536 else "int"
            lines.append(f"static const {kind} {name}[{len(values)}] = {{")
            lines += _columns([str(v) for v in values])
            lines.append("};")
        return lines

    def _evaluate(self) -> list[str]:
        p = self.prefix
        lines = [
            "/* Cost at `x`; with `derive` J'r and J'J as well. */",
            f"static {p}_status evaluate(const {p}_data *data, const {p}_parameters *x,",
            f"                           {p}_state *s, int derive, double *cost)",
            "{",
            "    double sum = 0.0;",
        ]
        for function in self.functions.constraints:
            lines += [f"    {line}" if line else "" for line in self._group(function)]
        return [*lines, "    *cost = sum;", f"    return {p.upper()}_OK;", "}", ""]

    def _group(self, function: ConstraintFunction) -> list[str]:
        group, upper = function.group, self.upper
        r = group.residuals
        count = f"data->{self.rows.names[group.table]}_count" if group.table else "1"
        slots = sorted({one.slot for one in (*function.states, *function.data)})
        failure = f"return {upper}_BAD_REF;"
        body, rows = self.rows.walk(group, "data->", failure=failure, slots=slots)
        arguments = [f"x->{one.array.name}[{rows[one.slot]}]" for one in function.states]
        arguments += [f"data->{one.array.name}[{rows[one.slot]}]" for one in function.data]
        arguments.append("residual")
        body.append(f"{self.real} residual[{r}];")
        blocks = [f"j{k}" for k in range(len(function.sets))]
        for block, one in zip(blocks, function.sets, strict=True):
            body.append(f"{self.real} {block}[{max(r * one.entity.tangent, 1)}];")
        arguments += [f"derive ? {block} : 0" for block in blocks]
        body += [
            f"if (!{function.name}({', '.join(arguments)})) continue;",
            f"for (int k = 0; k < {r}; k++) sum += (double)residual[k] * (double)residual[k];",
            "if (!derive) continue;",
        ]
        places = []
        for use, one in enumerate(function.sets):
            row = rows[function.states[use].slot]
            first = self.plan.first_row[one.number]
            places.append(f"{first} + {row}" if first else row)
            body.append(f"add_gradient(s, {places[use]}, {r}, {blocks[use]}, residual);")
        for a in range(len(blocks)):
            for b in range(a + 1):
                call = (
                    f"add_product(s, {places[a]}, {places[b]}, {r}, {blocks[a]}, {blocks[b]}, "
                    f"{int(a == b)})"
                )
                body.append(f"if (!{call}) return {upper}_PATTERN;")
        title = c_comment(group.label)
        head = f"for (int i = 0; i < {count}; i++) {{ /* {title} */"
        return [head, *(f"    {line}" for line in body), "}"]

    def _hold_fixed(self) -> list[str]:
        p = self.prefix
        lines = [
            "/* Marks what does not move: fixed scalars, those a pass freezes, rows not in use. */",
            f"static void hold_fixed(const {p}_data *data, {p}_state *s)",
            "{",
        ]
        for one in self.functions.used:
            n, rows = one.entity.tangent, self.plan.rows[one.entity.table]
            if not n:
                continue
            name = one.stored.name
            used = f"data->{self.rows.names[one.entity.table]}_count" if one.entity.table else "1"
            at = self.plan.first_row[one.number]
            masks = [masks[one.number] for masks in self._frozen]
            frozen = ""
            if any(any(mask) for mask in masks):
                table = ", ".join(f"{{{', '.join(map(str, mask))}}}" for mask in masks)
                declared = f"{name}_frozen[{len(masks)}][{n}]"
                lines.append(f"    static const unsigned char {declared} = {{{table}}};")
                frozen = f" || {name}_frozen[s->pass][k] != 0"
            lines += [
                f"    for (int row = 0; row < {rows}; row++)",
                f"        for (int k = 0; k < {n}; k++)",
                f"            s->held[FIRST[POSITION[{at} + row]] + k] =",
                f"                row >= {used} || data->{name}_fixed[row][k] != 0{frozen};",
            ]
        return [*lines, "}", ""]

    def _bounded(self) -> list[tuple[ParameterSet, int, int, float | None, float | None]]:
        """Scalars with bounds: set, stored and tangent offset, low, high."""
        found = []
        for one in self.functions.used:
            table = self.functions.layout.table(one.entity.table)
            for use in one.entity.params:
                param = table.column(use.column).param
                if param is None:
                    continue
                for k in range(use.tangent):
                    low = param.low[k] if param.low else None
                    high = param.high[k] if param.high else None
                    if low is not None or high is not None:
                        found.append((one, use.stored_start + k, use.tangent_start + k, low, high))
        return found

    def _bounds(self) -> list[str]:
        p = self.prefix
        bounded = self._bounded()
        lines = [
            "/* Holds scalars that are on a bound and whose gradient points outwards. */",
            f"static void hold_bounds(const {p}_data *data, {p}_state *s)",
            "{",
        ]
        if not bounded:
            lines += ["    (void)data;", "    (void)s;"]
        for one, stored, tangent, low, high in bounded:
            row = f"data->parameters.{one.stored.name}[row][{stored}]"
            at = f"FIRST[POSITION[{self.plan.first_row[one.number]} + row]] + {tangent}"
            tests = []
            if low is not None:
                tests.append(f"({row} <= {c_literal(low, self.real)} && s->gradient[at] > 0)")
            if high is not None:
                tests.append(f"({row} >= {c_literal(high, self.real)} && s->gradient[at] < 0)")
            lines += [
                f"    for (int row = 0; row < {self.plan.rows[one.entity.table]}; row++) {{",
                f"        const int at = {at};",
                f"        if ({' || '.join(tests)}) s->held[at] = 1;",
                "    }",
            ]
        if bounded:
            lines.append("    hold(s);")
        return [*lines, "}", ""]

    def _retract(self) -> list[str]:
        p = self.prefix
        lines = [
            "/* The trial parameters: those accepted, moved by the step, within their bounds. */",
            f"static void retract(const {p}_data *data, {p}_state *s)",
            "{",
        ]
        for one in self.functions.used:
            name, at = one.stored.name, self.plan.first_row[one.number]
            rows = self.plan.rows[one.entity.table]
            lines += [
                f"    for (int row = 0; row < {rows}; row++) {{",
                f"        {p}_{name}_retract(data->parameters.{name}[row],",
                f"            s->step + FIRST[POSITION[{at} + row]], s->trial.{name}[row]);",
            ]
            for other, stored, tangent, low, high in self._bounded():
                if other is one:
                    x = f"s->trial.{name}[row][{stored}]"
                    free = f"!s->held[FIRST[POSITION[{at} + row]] + {tangent}]"
                    if low is not None:
                        limit = c_literal(low, self.real)
                        lines.append(f"        if ({free} && {x} < {limit}) {x} = {limit};")
                    if high is not None:
                        limit = c_literal(high, self.real)
                        lines.append(f"        if ({free} && {x} > {limit}) {x} = {limit};")
            lines.append("    }")
        return [*lines, "}", ""]

    def _solve(self) -> list[str]:
        p, upper = self.prefix, self.upper
        lines = [
            f"{p}_options {p}_default_options(void)",
            "{",
            f"    const {p}_options options = {{100, 0.0, {upper}_DOGLEG, 1e-4}};",
            "    return options;",
            "}",
            "",
            *self._stored(),
            f"static {p}_status check_counts(const {p}_data *data)",
            "{",
            *(
                f"    if ({count} < 0 || {count} > {most}) return {upper}_BAD_COUNT;"
                for count, most in self._counts()
            ),
            "    (void)data;",
            f"    return {upper}_OK;",
            "}",
            "",
            f"{p}_result {p}_solve({p}_state *state, {p}_data *data, const {p}_options *options)",
            "{",
            f"    {p}_result result = {{check_counts(data), 0.0, 0.0, 0, 0}};",
            f"    if (result.status != {upper}_OK) return result;",
            "    keep_stored(data);",
            *self._start_check(),
        ]
        for number, one in enumerate(self._passes):
            if number:
                lines += [
                    f"    if (result.status != {upper}_CONVERGED && "
                    f"result.status != {upper}_MAX_ITERATIONS) return result;"
                ]
            lines += self._pass(one, number)
        return [*lines, "    return result;", "}", "", *self._covariances()]

    def _start_check(self) -> list[str]:
        """Refuse a start outside of its bounds, as arael does; what is fixed may be anywhere."""
        lines = []
        for one, stored, tangent, low, high in self._bounded():
            name, x = one.stored.name, f"data->parameters.{one.stored.name}[row][{stored}]"
            used = f"data->{self.rows.names[one.entity.table]}_count" if one.entity.table else "1"
            tests = [f"{x} < {c_literal(low, self.real)}"] if low is not None else []
            tests += [f"{x} > {c_literal(high, self.real)}"] if high is not None else []
            lines += [
                f"    for (int row = 0; row < {used}; row++)",
                f"        if (!data->{name}_fixed[row][{tangent}] && ({' || '.join(tests)})) {{",
                f"            result.status = {self.upper}_OUT_OF_BOUNDS;",
                "            return result;",
                "        }",
            ]
        return lines

    def _counts(self) -> list[tuple[str, int]]:
        """Number of rows in use of each collection, as C has it, and the most."""
        rows = self.plan.rows.items()
        return [(f"data->{self.rows.names[path]}_count", most) for path, most in rows if path]

    def _pass(self, one: LayoutPass, number: int) -> list[str]:
        p = self.prefix
        lines = [f"    /* pass {c_comment(one.name)} */", f"    state->pass = {number};"]
        for setting in one.settings:
            array = self.functions.arrays.data.get("")
            if array is None or setting.column not in [part.name for part in array.parts]:
                continue  # no constraint reads it
            for k, value in enumerate(setting.value):
                at = self.functions.arrays.offset("", setting.column, k)
                lines.append(f"    data->{array.name}[0][{at}] = {c_literal(value, self.real)};")
        precision = float(one.config.get("rel_precision", PRECISION[self.real]))
        most = int(one.config.get("max_iters", 0))
        limit = f"(options->max_iterations < {most} ? options->max_iterations : {most})"
        limit = limit if most else "options->max_iterations"
        if number == 0:
            lines += [
                "    result.status =",
                "        evaluate(data, &data->parameters, state, 0, &result.start_cost);",
                "    result.cost = result.start_cost;",
                f"    if (result.status != {p.upper()}_OK) return result;",
            ]
        lines.append(
            "    minimise(data, state, options, options->relative_precision > 0.0 ? "
            f"options->relative_precision : {precision!r}, {limit}, &result);"
        )
        return lines

    def _stored(self) -> list[str]:
        """Copies what constraints read as the stored value of a parameter."""
        p = self.prefix
        lines = [
            "/* Stored values that constraints read: the parameters when a solve begins. */",
            f"static void keep_stored({p}_data *data)",
            "{",
            "    (void)data;",
        ]
        for table in self.functions.layout.tables:
            array = self.functions.arrays.data.get(table.path)
            for part in array.parts if array is not None else ():
                found = self._stored_use(table.path, part.name)
                if found is None or array is None:
                    continue
                one, use = found
                stored = f"data->parameters.{one.stored.name}"
                lines += [
                    f"    for (int row = 0; row < {self.plan.rows[table.path]}; row++)",
                    f"        for (int k = 0; k < {use.stored}; k++)",
                    f"            data->{array.name}[row][{part.first} + k] =",
                    f"                {stored}[row][{use.stored_start} + k];",
                ]
        return [*lines, "}", ""]

    def _stored_use(self, table: str, column: str) -> tuple[ParameterSet, ParamUse] | None:
        for one in self.functions.used:
            if one.entity.table == table:
                for use in one.entity.params:
                    if use.column == column:
                        return one, use
        return None

    def _covariances(self) -> Iterable[str]:
        upper = self.upper
        for one in self.functions.used:
            n = one.entity.tangent
            rows = f"data->{self.rows.names[one.entity.table]}_count" if one.entity.table else "1"
            zero = "0.0f" if self.real == "float" else "0.0"
            yield from [
                f"int {self._covariance(one)}",
                "{",
                "    double cost;",
                f"    if (row < 0 || row >= {rows}) return 0;",
                f"    for (int k = 0; k < {upper}_SCALARS; k++) state->scale[k] = {zero};",
                f"    state->pass = {len(self._passes) - 1};",
                f"    if (linearise(data, state, &cost) != {upper}_OK) return 0;",
                f"    if (!factorise(state, {zero})) return 0;",
                f"    const int first = FIRST[POSITION[{self.plan.first_row[one.number]} + row]];",
                f"    for (int k = 0; k < {n}; k++) {{",
                f"        for (int i = 0; i < {upper}_SCALARS; i++) state->newton[i] = {zero};",
                "        if (!state->held[first + k]) state->newton[first + k] = 1;",
                "        substitute(state, state->newton);",
                f"        for (int i = 0; i < {n}; i++)",
                f"            covariance[i * {n} + k] =",
                f"                state->held[first + i] ? {zero} : state->newton[first + i];",
                "    }",
                "    return 1;",
                "}",
                "",
            ]


def _frozen_by_pass(
    functions: Functions, passes: Sequence[LayoutPass]
) -> list[dict[int, list[int]]]:
    """For each pass and parameter set, 1 for each scalar of a step that does not move."""
    layout, found = functions.layout, []
    frozen = frozen_by(layout, passes, ())
    for one in passes:
        for name in one.config:
            if name not in ("rel_precision", "max_iters"):
                raise AraelError(
                    Diagnostic(
                        "E1503",
                        f"pass `{one.name}` sets `{name}`, which an exported solver does not have",
                        help=("it has rel_precision and max_iters",),
                    )
                )
        now = frozen_after(layout, frozen, one)
        found.append({s.number: _frozen_scalars(functions, s, now) for s in functions.used})
    return found


def _frozen_scalars(functions: Functions, one: ParameterSet, frozen: frozenset[str]) -> list[int]:
    entity = one.entity
    found = [0] * entity.tangent
    table = functions.layout.table(entity.table)
    for use in entity.params:
        param = table.column(use.column).param
        if param is None or not use.tangent:
            continue
        whole = is_frozen(entity.table, use.column, frozen)
        for k in range(use.tangent):
            found[use.tangent_start + k] = int(whole or k in param.held)
        for part in param.parts:
            if is_frozen(entity.table, f"{use.column}.{part.name}", frozen):
                for k in range(part.first, part.first + part.count):
                    found[use.tangent_start + k] = 1
        for k, name in enumerate(param.components):
            if is_frozen(entity.table, f"{use.column}.{name}", frozen):
                found[use.tangent_start + k] = 1
    return found


def _columns(texts: Sequence[str]) -> list[str]:
    lines, current = [], "   "
    for text in texts:
        if len(current) + len(text) + 2 > 96:
            lines.append(current)
            current = "   "
        current += f" {text},"
    return [*lines, current]
