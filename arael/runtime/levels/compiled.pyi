from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arael.runtime.compiled import Interruption
from arael.runtime.layout import Layout
from arael.runtime.levels.outcome import Outcome
from arael.runtime.levels.structure import Structure
from arael.runtime.machine.tape import Tape

class Rows:
    n: int
    m: int
    pattern_version: int
    @property
    def indptr(self) -> NDArray[np.int32]: ...
    @property
    def indices(self) -> NDArray[np.int32]: ...
    def evaluate(self, x: ArrayLike) -> NDArray[np.float64]: ...
    def holds(self, x: ArrayLike, tolerance: ArrayLike) -> bool: ...
    def worst(self, x: ArrayLike, tolerance: ArrayLike) -> tuple[int, float, float]: ...
    def jacobian(self, x: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def check(self, code: int) -> None: ...

class PythonRows(Rows):
    def __init__(
        self,
        function: Callable[[NDArray[np.float64]], ArrayLike],
        jacobian: Callable[[NDArray[np.float64]], ArrayLike] | None = None,
        *,
        n: int,
        m: int,
        pattern: Sequence[Sequence[int]] | NDArray[np.bool_] | None = None,
    ) -> None: ...
    def set_pattern(
        self, pattern: Sequence[Sequence[int]] | NDArray[np.bool_] | None = None
    ) -> None: ...

class CursorRows(Rows):
    def __init__(self, n: int, at: ArrayLike, target: ArrayLike) -> None: ...
    def aim(self, at: ArrayLike, target: ArrayLike) -> bool: ...

class RowFactor:
    n: int
    m: int
    count: int
    components: int
    pivot_tolerance: float
    @property
    def structure(self) -> Structure: ...
    def __init__(
        self, n: int, m: int, structure: Structure, scales: ArrayLike, basic: Any, tolerance: float
    ) -> None: ...
    def dropped(self) -> NDArray[np.int32]: ...

class UnknownWindows:
    n: int
    constants: int
    def __init__(self, n: int, widths: Iterable[int]) -> None: ...
    def resize(self, n: int) -> None: ...
    def take(self, values: ArrayLike) -> int: ...
    def release(self, offset: int) -> None: ...
    def set(self, offset: int, values: ArrayLike) -> None: ...
    def values(self, offset: int) -> NDArray[np.float64]: ...

class LaneTable:
    struct: str
    refs: tuple[str, ...]
    widths: tuple[int, ...]
    fields: tuple[str, ...]
    residuals: int
    count: int
    active: int
    defaults: NDArray[np.float64]
    def __init__(self, layout: Layout, number: int, kernels: Any) -> None: ...

class RowExpression:
    row: int
    quantities: tuple[int, ...]
    unknowns: tuple[int, ...]
    def __init__(
        self,
        row: int,
        tape: Tape,
        quantities: Sequence[int],
        unknowns: Sequence[int],
        numbers: Sequence[float],
        contributions: int,
    ) -> None: ...
    def set_numbers(self, numbers: ArrayLike) -> None: ...

class KernelRows(Rows):
    unknowns: UnknownWindows
    evaluated: int
    tables: dict[str, LaneTable]
    def __init__(self, layout: Layout, kernels: Any = None, n: int = 0) -> None: ...
    def edit(self) -> AbstractContextManager[KernelRows]: ...
    def resize(self, n: int) -> None: ...
    def constant(self, values: ArrayLike) -> int: ...
    def set_constant(self, offset: int, values: ArrayLike) -> None: ...
    def release_constant(self, offset: int) -> None: ...
    def add(
        self,
        struct: str,
        uses: Sequence[int] | NDArray[Any],
        data: ArrayLike | Mapping[str, float] = (),
        *,
        on: bool = True,
        quantity: bool = False,
    ) -> int: ...
    def extend(
        self,
        struct: str,
        uses: ArrayLike,
        data: ArrayLike | Mapping[str, ArrayLike] | None = None,
        *,
        on: bool = True,
        quantity: bool = False,
    ) -> NDArray[np.int64]: ...
    def remove(self, row: int) -> None: ...
    def set_on(self, row: int, on: bool) -> None: ...
    def is_on(self, row: int) -> bool: ...
    def set_uses(self, row: int, uses: Sequence[int] | NDArray[Any]) -> None: ...
    def set_data(self, row: int | NDArray[Any], field: str | int, value: ArrayLike) -> None: ...
    def data(self, row: int, field: str | int | None = None) -> Any: ...
    def uses(self, row: int) -> NDArray[np.int64]: ...
    def struct(self, row: int) -> str: ...
    def instances(self) -> NDArray[np.int64]: ...
    def add_term(self, row: int, unknown: int, coefficient: float) -> None: ...
    def remove_terms(self, row: int) -> None: ...
    def add_expression(
        self,
        row: int,
        program: Tape,
        quantities: Sequence[int] = (),
        unknowns: Sequence[int] = (),
        numbers: Sequence[float] = (),
    ) -> None: ...
    def remove_expression(self, row: int, *, missing_ok: bool = False) -> None: ...
    def set_numbers(self, row: int, numbers: ArrayLike) -> None: ...
    def quantity(self, row: int) -> NDArray[np.float64]: ...

class Excerpt(Rows):
    row_of: NDArray[np.int32]
    def __init__(
        self,
        of: KernelRows,
        instances: Sequence[int],
        quantities: Sequence[int],
        columns: ArrayLike,
    ) -> None: ...

class LowerLevels: ...

Array = NDArray[np.float64]
Mask = NDArray[np.bool_] | None

PIVOT_TOLERANCE: float

class Levels:
    rows: Rows
    soft: Rows | None
    guards: Rows | None
    scales: Array | None
    pivot_tolerance: float
    shortest: float
    limit: int
    rounds: int
    factors: int
    linearisations: int
    interruption: Interruption
    def __init__(
        self,
        rows: Rows,
        soft: Rows | None = None,
        *,
        guards: Rows | None = None,
        scales: ArrayLike | None = None,
        step_limit: int = 100,
        pivot_tolerance: float = ...,
        shortest: float = ...,
        interruption: Interruption | None = None,
    ) -> None: ...
    def interrupt(self) -> None: ...
    @property
    def components(self) -> int: ...
    @property
    def component_of(self) -> NDArray[np.int32]: ...
    def redundant(self) -> NDArray[np.int32]: ...
    def solve(
        self,
        x: Array,
        tolerance: ArrayLike = 1e-10,
        *,
        fixed: Mask = None,
        active: Mask = None,
        basic: Mask = None,
        touched: ArrayLike | None = None,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
        keep: bool = False,
    ) -> Outcome: ...
    def minimise(
        self,
        x: Array,
        tolerance: ArrayLike = 1e-10,
        *,
        home: ArrayLike | None = None,
        soft_tolerance: float | None = None,
        fixed: Mask = None,
        active: Mask = None,
        basic: Mask = None,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
        limit: int = 100,
    ) -> Outcome: ...
    def drag(
        self,
        x: Array,
        at: ArrayLike,
        target: ArrayLike,
        home: ArrayLike | None = None,
        tolerance: ArrayLike = 1e-10,
        *,
        fixed: Mask = None,
        active: Mask = None,
        basic: Mask = None,
        low: ArrayLike | None = None,
        high: ArrayLike | None = None,
        limit: int = 60,
        seconds: float | None = None,
    ) -> Outcome: ...

def surely_independent(
    rows: Rows,
    x: NDArray[np.float64],
    asked: Sequence[int],
    counts: NDArray[np.bool_],
    *,
    more: Sequence[tuple[Any, Any]] = (),
    scales: NDArray[np.float64] | None = None,
    sizes: Sequence[int] = (8, 24, 64),
) -> bool: ...
def components(rows: Rows) -> NDArray[np.int32]: ...

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

def differs(values: Floats, others: Floats, at: Ints) -> bool: ...
def gather(values: Floats, source: Ints, x: Floats) -> None: ...
def scattered(x: Floats, root: Ints, values: Floats, at: Ints) -> tuple[Ints, Floats, Floats]: ...
def spread(kinds: NDArray[np.int8], root: Ints, found: NDArray[np.int8]) -> None: ...
def put(values: Floats, at: Ints, numbers: Floats) -> None: ...
def named(at: Ints, first: Ints, names: list[str]) -> tuple[str, ...]: ...
def near(values: Floats, at: Ints, x: float, y: float, distance: float) -> list[int]: ...
def mostly_apart(values: Floats, least: float) -> bool: ...
def largest(values: Floats) -> float: ...
def extent(values: Floats, points: Ints, lengths: Ints) -> float: ...
def any_short(values: Floats, lines: Ints, lengths: Ints, least: float) -> bool: ...

class ComponentSizes:
    n: int
    def __init__(
        self, axes: NDArray[np.int8], of_unknown: NDArray[np.int32], of_row: NDArray[np.int32]
    ) -> None: ...
    def tolerances(
        self, x: Floats, relative: float, rounding: float, whole: Callable[[], float]
    ) -> Floats: ...
